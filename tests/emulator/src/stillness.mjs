import { NANOS_PER_CYCLE } from './clock.mjs';

/** Checks that the gantry is still from an instant on: no step comes, and at the end no output of the tool is on. */
export class Stillness {
  #gantry;
  #fromCycle = Infinity;
  /** The first step after that instant. */
  #late = null;

  /** @param {import('./gantry.mjs').Gantry} gantry */
  constructor(gantry) {
    this.#gantry = gantry;
    gantry.stepWatchers.add((cycle, axis) => this.#stepped(cycle, axis));
    gantry.second?.stepWatchers.add((cycle) => this.#stepped(cycle, 'the second motor'));
  }

  /** No step may come later than this cycle. */
  from(cycle) {
    this.#fromCycle = cycle;
    this.#late = null;
  }

  /** Ends the check. @returns {string | null} what was not still */
  end() {
    if (this.#fromCycle === Infinity) return 'nothing was to be still: stop-within first';
    this.#fromCycle = Infinity;
    const on = Object.entries(this.#gantry.tool.values).find(([, value]) => value > 0);
    return this.#late ?? (on === undefined ? null : `the output ${on[0]} is on`);
  }

  #stepped(cycle, axis) {
    if (cycle <= this.#fromCycle) return;
    this.#late ??= `a step of ${axis} came ${((cycle - this.#fromCycle) * NANOS_PER_CYCLE * 1e-3).toFixed(3)} us too late`;
  }
}
