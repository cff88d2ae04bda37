import { nanosOf } from './clock.mjs';

/** Records when all of the tool's outputs were off after an instant, and when one was on again after that. */
export class OffTimes {
  #clock;
  #on = false;
  /** Marks that are not complete yet. */
  #open = [];

  /** @param {import('./clock.mjs').MachineClock} clock */
  constructor(clock) {
    this.#clock = clock;
  }

  /** Whether any output is on. */
  get on() {
    return this.#on;
  }

  /** Marks this instant. @returns {Mark} */
  mark() {
    const mark = new Mark(this.#clock.cycles, this.#on);
    this.#open.push(mark);
    return mark;
  }

  /** An output has changed: now any of them is on, or none. */
  set(on, cycle) {
    if (on === this.#on) return;
    this.#on = on;
    for (const mark of this.#open) mark.set(on, cycle);
    if (on) this.#open = [];
  }
}

/** An instant after which the outputs are watched. */
class Mark {
  #cycle;
  #offCycle;
  #onAgainCycle = null;

  constructor(cycle, on) {
    this.#cycle = cycle;
    this.#offCycle = on ? null : cycle;
  }

  /** Whether the outputs are still on. */
  get waits() {
    return this.#offCycle === null;
  }

  set(on, cycle) {
    if (on) this.#onAgainCycle = cycle;
    else this.#offCycle = cycle;
  }

  /** @returns {{outputs_off_ns: number | null, outputs_on_again_ns: number | null}} from the mark; null if not before the end */
  summary() {
    return { outputs_off_ns: this.#nanosTo(this.#offCycle), outputs_on_again_ns: this.#nanosTo(this.#onAgainCycle) };
  }

  #nanosTo(cycle) {
    return cycle === null ? null : nanosOf(cycle - this.#cycle);
  }
}
