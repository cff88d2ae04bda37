import { AXES, SECOND } from './pins.mjs';
import { Tmc2209 } from './tmc2209.mjs';
import { TmcWire } from './tmc-wire.mjs';

/** The drivers of a board that talks to them: one for each motor, the fourth for A or a second motor. */
export class Drivers {
  #chip = null;

  /**
   * @param {import('./clock.mjs').MachineClock} clock
   * @param {typeof import('./pins.mjs').BOARDS['skr-pico']} board
   * @param {{seed: number, states: [string, string][], onDiag: (axis: string, high: boolean) => void}} options
   */
  constructor(clock, board, { seed, states, onDiag }) {
    this.board = board;
    this.motors = Object.fromEntries(
      AXES.map((axis) => {
        const wiring = { address: board.tmcWire.addresses[axis], seed, levels: () => this.#levels(axis), onDiag: (high) => onDiag(axis, high) };
        return [axis, new Tmc2209(clock, wiring)];
      }),
    );
    this.wire = new TmcWire(clock, board.tmcWire, Object.values(this.motors));
    for (const [motor, state] of states) this.of(motor).set(state);
  }

  /** @param {string} motor an axis, or the second motor */
  of(motor) {
    return this.motors[motor === SECOND ? 'A' : motor];
  }

  attach(chip) {
    this.#chip = chip;
    this.wire.attach(chip);
  }

  /** ENABLE of these drivers has changed. */
  enable(pin, enabled) {
    for (const axis of AXES) if (this.board.axes[axis].enable === pin) this.motors[axis].enable(enabled);
  }

  /** Power is back. A driver whose supply is off stays off. */
  powerUp() {
    for (const driver of Object.values(this.motors)) if (driver.powered) driver.powerUp();
  }

  #levels(axis) {
    const { step, dir } = this.board.axes[axis];
    const { gpio } = this.#chip;
    return { step: gpio[step].rawInputValue, dir: gpio[dir].rawInputValue };
  }

  summary() {
    return Object.fromEntries(Object.entries(this.motors).map(([axis, driver]) => [axis, driverSummary(driver)]));
  }
}

function driverSummary({ address, microsteps, runCurrent, holdCurrent, chopper, reads, writes, refused }) {
  return { address, microsteps, irun: runCurrent, ihold: holdCurrent, chopper, reads, writes, refused };
}
