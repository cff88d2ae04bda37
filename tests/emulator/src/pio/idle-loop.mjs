const NONE = -1;

/**
 * Recognises a program that only looks at pins, round after round. A machine that looks at the same place again, in the
 * same state, sees the same levels and has done nothing else in between goes round until one of these levels changes.
 */
export class IdleLoop {
  constructor() {
    /** The state in which the machine looked last; the pins, a bit each, and their levels. */
    this.pc = NONE;
    this.next = 0;
    this.x = 0;
    this.y = 0;
    this.isr = 0;
    this.isrCount = 0;
    this.osr = 0;
    this.osrCount = 0;
    this.pins = 0;
    this.levels = 0;
    /** The cycles that a round takes. */
    this.round = 0;
  }

  /** It ends only when a level changes. */
  get endsAt() {
    return Infinity;
  }

  forget() {
    this.pc = NONE;
  }

  /** Its rounds change nothing. */
  takeRounds() {}

  /**
   * The machine is about to look at pins.
   *
   * @param {import('./state-machine.mjs').StateMachine} machine
   * @returns {boolean} whether it goes round
   */
  comesRound(machine, pins, levels) {
    const goesRound = this.#isAs(machine) && this.pins === pins && this.levels === levels;
    if (goesRound && this.round === 0) this.round = machine.next - this.next;
    if (!goesRound) this.#remember(machine, pins, levels);
    return goesRound;
  }

  #isAs({ pc, x, y, isr, isrCount, osr, osrCount }) {
    return pc === this.pc && x === this.x && y === this.y && isr === this.isr && isrCount === this.isrCount && osr === this.osr && osrCount === this.osrCount;
  }

  #remember({ pc, next, x, y, isr, isrCount, osr, osrCount }, pins, levels) {
    Object.assign(this, { pc, next, x, y, isr, isrCount, osr, osrCount, pins, levels, round: 0 });
  }
}
