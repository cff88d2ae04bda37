import { cyclesOfMillis, nanosOf } from './clock.mjs';
import { AXES, SECOND } from './pins.mjs';

const MOTORS = [...AXES, SECOND];

/** Steps further apart than this do not belong to one move. */
const PAUSE_CYCLES = cyclesOfMillis(50);
/** The machine is at rest if there is no step for a millisecond and for four of the previous intervals. */
const REST_CYCLES = cyclesOfMillis(1);
const REST_INTERVALS = 4;

/** Measures how long the machine goes on stepping after a stop: a switch, the E-stop, a reset. */
export class Stops {
  /**
   * @param {import('./clock.mjs').MachineClock} clock
   * @param {import('./off-times.mjs').OffTimes} offTimes of the tool's outputs
   */
  constructor(clock, offTimes) {
    this.clock = clock;
    this.offTimes = offTimes;
    /** Finished stops and those whose end is not known yet, in order. */
    this.all = [];
    this.open = [];
    this.axes = Object.fromEntries(MOTORS.map((axis) => [axis, { lastCycle: -Infinity, interval: Infinity }]));
    this.lastCycle = -Infinity;
    /** Whether it was reset while it was stepping, and has not been at rest since. */
    this.braking = false;
  }

  /** A reset byte has come. The first one makes the machine brake; another one is a stop. */
  reset() {
    if (this.braking) this.note('RESET');
    this.braking = this.clock.cycles - this.lastCycle < PAUSE_CYCLES;
  }

  /** A stop has come. It counts if the machine is stepping; a contact that bounces counts once. */
  note(input) {
    const { cycles } = this.clock;
    if (cycles - this.lastCycle >= PAUSE_CYCLES || this.open.some((stop) => stop.input === input)) return;
    const stop = { input, cycle: cycles, lastCycle: this.lastCycle, edgesAfter: 0, mark: this.offTimes.mark() };
    this.all.push(stop);
    this.open.push(stop);
  }

  /** A rising edge of STEP. */
  step(axis, cycle) {
    if (this.open.length > 0 || this.braking) this.#stepAfter(cycle);
    const of = this.axes[axis];
    of.interval = cycle - of.lastCycle;
    of.lastCycle = cycle;
    this.lastCycle = cycle;
  }

  /** An axis that reverses has been at rest before. */
  turn() {
    this.#rested();
  }

  /**
   * @returns {{input: string, t_ns: number, last_edge_ns: number, latency_ns: number, edges_after: number,
   *   outputs_off_ns: number | null, outputs_on_again_ns: number | null}[]}
   */
  summary() {
    return this.all.map(({ input, cycle, lastCycle, edgesAfter, mark }) => ({
      input,
      t_ns: nanosOf(cycle),
      last_edge_ns: nanosOf(lastCycle),
      latency_ns: nanosOf(Math.max(0, lastCycle - cycle)),
      edges_after: edgesAfter,
      ...mark.summary(),
    }));
  }

  #rested() {
    if (this.open.length > 0) this.open = [];
    this.braking = false;
  }

  #stepAfter(cycle) {
    if (cycle - this.lastCycle > this.#restCycles(cycle)) {
      this.#rested();
      return;
    }
    for (const stop of this.open) {
      stop.lastCycle = cycle;
      stop.edgesAfter += 1;
    }
  }

  #restCycles(cycle) {
    let longest = 0;
    for (const axis of MOTORS) {
      const { lastCycle, interval } = this.axes[axis];
      if (cycle - lastCycle < PAUSE_CYCLES && interval < PAUSE_CYCLES) longest = Math.max(longest, interval);
    }
    return Math.max(REST_CYCLES, REST_INTERVALS * longest);
  }
}
