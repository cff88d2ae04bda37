/**
 * A core that takes `factor` cycles for each one that is assumed of it, entries of handlers included. What it waits for flash stays as
 * it is.
 */
export class Slowness {
  /** The part of a cycle that is still to be taken. */
  #owed = 0;
  #waited;

  /** @param {import('../xip-cache.mjs').FlashCounts} counts */
  constructor(factor, counts) {
    Object.assign(this, { factor, counts });
    this.#waited = counts.stallCycles;
  }

  /** The core has just carried out an instruction, which began on this cycle. */
  charge(core, began) {
    const waited = this.counts.stallCycles;
    this.#owed += (core.cycles - began - (waited - this.#waited)) * (this.factor - 1);
    this.#waited = waited;
    const whole = Math.floor(this.#owed);
    this.#owed -= whole;
    core.cycles += whole;
  }
}
