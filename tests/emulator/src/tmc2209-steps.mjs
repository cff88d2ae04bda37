import { CLOCK_HZ } from './clock.mjs';

const DRIVER_CLOCK_HZ = 12_000_000;
/** TSTEP of a motor that stands still, or is slower than TSTEP can say. */
export const SLOWEST = 2 ** 20 - 1;
const STANDSTILL_CLOCKS = 2 ** 20;
const POSITIONS = 1024;
const FULL_STEP = 256;

/** Cycles of the emulated chip that so many clocks of the driver take. */
export const cyclesOfClocks = (clocks) => (clocks * CLOCK_HZ) / DRIVER_CLOCK_HZ;
const clocksOfCycles = (cycles) => (cycles * DRIVER_CLOCK_HZ) / CLOCK_HZ;

/** What a driver measures on its STEP input: its place in the electrical wave, and its time for 1/256 of a full step. */
export class StepInput {
  position = 0;
  lastCycle = -Infinity;
  #tstep = SLOWEST;

  /**
   * @param {number} length of the step, in 1/256 of a full step; negative downwards
   * @returns {boolean} whether it begins another full step
   */
  step(cycle, length) {
    const before = Math.floor(this.position / FULL_STEP);
    this.position = (this.position + length + POSITIONS) % POSITIONS;
    const clocks = clocksOfCycles(cycle - this.lastCycle);
    this.#tstep = Math.min(SLOWEST, Math.floor(clocks / Math.abs(length)));
    this.lastCycle = cycle;
    return Math.floor(this.position / FULL_STEP) !== before;
  }

  /** The last one that was measured, until the motor counts as standing. */
  tstep(cycle) {
    return this.stands(cycle) ? SLOWEST : this.#tstep;
  }

  get standstillCycle() {
    return this.lastCycle + Math.ceil(cyclesOfClocks(STANDSTILL_CLOCKS));
  }

  stands(cycle) {
    return cycle >= this.standstillCycle;
  }
}

/** Whether a motor is faster than a threshold, which is 1/16 higher for one that was slower (TSTEP in the data sheet, 5.2). */
export function isFaster(was, tstep, threshold) {
  return was ? tstep < threshold : tstep < (threshold * 15) / 16 - 1;
}
