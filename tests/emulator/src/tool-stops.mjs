import { nanosOf } from './clock.mjs';

/** Measures how long the tool's outputs stay on after something that must switch them off, whether the machine moves or not. */
export class ToolStops {
  #clock;
  #offTimes;
  #all = [];

  /**
   * @param {import('./clock.mjs').MachineClock} clock
   * @param {import('./off-times.mjs').OffTimes} offTimes
   */
  constructor(clock, offTimes) {
    this.#clock = clock;
    this.#offTimes = offTimes;
  }

  /** A stop has come. It counts if an output is on; a contact that bounces counts once. */
  note(input) {
    if (!this.#offTimes.on || this.#all.some((stop) => stop.input === input && stop.mark.waits)) return;
    this.#all.push({ input, cycle: this.#clock.cycles, mark: this.#offTimes.mark() });
  }

  /** @returns {{input: string, t_ns: number, outputs_off_ns: number | null, outputs_on_again_ns: number | null}[]} */
  summary() {
    return this.#all.map(({ input, cycle, mark }) => ({ input, t_ns: nanosOf(cycle), ...mark.summary() }));
  }
}
