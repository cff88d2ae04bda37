import { nanosOf } from './clock.mjs';

/**
 * The probe: a contact to ground that a plate or a hand closes. It records the steps at which the contact closed and
 * opened.
 */
export class Probe {
  #clock;
  #carriages;
  #onLevel;
  #plate = null;
  #touched = false;
  #pressed = false;
  #closed = false;
  #contacts = [];
  #releases = [];
  #last = null;

  /**
   * @param {import('./clock.mjs').MachineClock} clock
   * @param {Record<string, import('./carriage.mjs').Carriage>} carriages
   * @param {(high: boolean) => void} onLevel
   */
  constructor(clock, carriages, onLevel) {
    this.#clock = clock;
    this.#carriages = carriages;
    this.#onLevel = onLevel;
  }

  /** Places a plate or removes it. @param {import('./probe-plate.mjs').ProbePlate | null} plate */
  setPlate(plate) {
    this.#plate = plate;
    this.#touch(plate?.axis ?? null);
  }

  /** Closes the contact by hand, or releases it. */
  press(pressed) {
    this.#pressed = pressed;
    this.#settle(null);
  }

  /** A motor has made a step, by which these axes have moved. */
  step(motor, axes) {
    if (this.#plate === null) return;
    // Another axis may step on the cycle of a contact.
    if (this.#last?.cycle === this.#clock.cycles) this.#last.position = this.#positions();
    if (axes.includes(this.#plate.axis)) this.#touch(motor);
  }

  summary() {
    return { closed: this.#closed, plate: this.#plate, contacts: this.#contacts.map(changeSummary), releases: this.#releases.map(changeSummary) };
  }

  #touch(axis) {
    this.#touched = this.#plate !== null && this.#plate.touches(this.#carriages[this.#plate.axis].placeMm);
    this.#settle(axis);
  }

  #settle(axis) {
    const closed = this.#touched || this.#pressed;
    if (closed === this.#closed) return;
    this.#closed = closed;
    this.#last = { cycle: this.#clock.cycles, axis, position: this.#positions() };
    (closed ? this.#contacts : this.#releases).push(this.#last);
    this.#onLevel(!closed);
  }

  #positions() {
    return Object.values(this.#carriages).map((carriage) => carriage.positionSteps);
  }
}

function changeSummary({ cycle, axis, position }) {
  return { t_ns: nanosOf(cycle), axis, position_steps: position };
}
