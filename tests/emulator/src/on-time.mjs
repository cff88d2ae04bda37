import { CLOCK_HZ, cyclesOfMillis } from './clock.mjs';

/** If there is no step for this long, the machine stands still. */
const PAUSE_CYCLES = cyclesOfMillis(50);

/** How long the tool's power is on, and how long of that while the machine stands still. */
export class OnTime {
  #cycles = 0;
  #onSince = null;
  #stepCycle = 0;
  #cyclesAtStep = 0;
  #standstillCycles = 0;

  /** The power goes on or off. */
  set(on, cycle) {
    this.#cycles = this.#at(cycle);
    this.#onSince = on ? cycle : null;
  }

  /** A rising edge of STEP. */
  step(cycle) {
    const cycles = this.#at(cycle);
    this.#standstillCycles += this.#still(cycle, cycles);
    this.#stepCycle = cycle;
    this.#cyclesAtStep = cycles;
  }

  /** @returns {{on_s: number, on_at_standstill_s: number}} up to a cycle, in seconds */
  summary(cycle) {
    const cycles = this.#at(cycle);
    return { on_s: cycles / CLOCK_HZ, on_at_standstill_s: (this.#standstillCycles + this.#still(cycle, cycles)) / CLOCK_HZ };
  }

  #at(cycle) {
    return this.#cycles + (this.#onSince === null ? 0 : cycle - this.#onSince);
  }

  /** The part of the on-time since the last step that counts as standstill. */
  #still(cycle, cycles) {
    return cycle - this.#stepCycle < PAUSE_CYCLES ? 0 : cycles - this.#cyclesAtStep;
  }
}
