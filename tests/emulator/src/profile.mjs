import { writeFileSync } from 'node:fs';
import { cyclesOfMillis } from './clock.mjs';

const INSTRUCTION_BYTES = 2;
/** The machine is in motion as long as its last edge is no older than this. */
const IN_MOTION_CYCLES = cyclesOfMillis(50);

/**
 * What the core spends on every instruction of flash and RAM: how often it ran, how often while the machine was in motion,
 * and its cycles. What the ROM does and what waits for flash counts for the instruction that asked for it.
 */
export class Profile {
  /** @param {import('./statistics.mjs').StepStatistics} statistics which know the last edge */
  constructor(statistics) {
    this.statistics = statistics;
    this.regions = [
      { start: 0x10000000, end: 0x10200000 },
      { start: 0x20000000, end: 0x20042000 },
    ].map(({ start, end }) => ({ start, end, counts: new Float64Array(3 * ((end - start) / INSTRUCTION_BYTES)) }));
    this.last = null;
  }

  /** The instruction at `address` has taken so many cycles, up to `now`. */
  add(address, cycles, now) {
    const at = this.#place(address) ?? this.last;
    if (at === null) return;
    this.last = at;
    const { counts, index } = at;
    counts[index] += 1;
    if (now - this.statistics.lastCycle < IN_MOTION_CYCLES) counts[index + 1] += 1;
    counts[index + 2] += cycles;
  }

  #place(address) {
    const region = this.regions.find(({ start, end }) => address >= start && address < end);
    return region && { counts: region.counts, index: 3 * ((address - region.start) >>> 1) };
  }

  /** A line for each instruction that ran: its address, how often it ran, how often in motion, and its cycles. */
  toString() {
    const lines = ['address,executions,in_motion,cycles'];
    for (const { start, counts } of this.regions) {
      for (let index = 0; index < counts.length; index += 3) {
        if (counts[index] > 0) lines.push(`${start + (index / 3) * INSTRUCTION_BYTES},${counts.subarray(index, index + 3).join(',')}`);
      }
    }
    return `${lines.join('\n')}\n`;
  }
}
