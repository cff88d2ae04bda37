import { CLOCK_HZ, cyclesOfMillis } from './clock.mjs';
import { AXES } from './pins.mjs';

/** Steps further apart than this do not belong to one move. */
const PAUSE_CYCLES = cyclesOfMillis(50);

/** Counts steps, and what the core spends on them while the machine moves. */
export class StepStatistics {
  constructor() {
    this.axes = Object.fromEntries(AXES.map((axis) => [axis, { edges: 0, lastCycle: -Infinity, shortestCycles: Infinity }]));
    this.lastCycle = -Infinity;
    this.lastAwake = 0;
    this.lastHandler = 0;
    this.moving = { cycles: 0, awakeCycles: 0, handlerCycles: 0, edges: 0 };
  }

  step(axis, clock) {
    const { cycles, awakeCycles, handlerCycles } = clock;
    const of = this.axes[axis];
    of.edges += 1;
    of.shortestCycles = Math.min(of.shortestCycles, cycles - of.lastCycle);
    of.lastCycle = cycles;
    if (cycles - this.lastCycle < PAUSE_CYCLES) {
      this.moving.cycles += cycles - this.lastCycle;
      this.moving.awakeCycles += awakeCycles - this.lastAwake;
      this.moving.handlerCycles += handlerCycles - this.lastHandler;
      this.moving.edges += 1;
    }
    this.lastCycle = cycles;
    this.lastAwake = awakeCycles;
    this.lastHandler = handlerCycles;
  }

  highestRate(axis) {
    return Math.round(CLOCK_HZ / this.axes[axis].shortestCycles);
  }
}
