import { CYCLES_PER_MICRO, NANOS_PER_CYCLE } from './clock.mjs';

/** Software that notices that it was late sets the alarm again within microseconds. */
const NOTICED_MICROS = 20;
/** A target that lies further back is one of the far future, after the counter has come round. */
const PAST_MICROS = 1_000_000;
/** The target if there is nothing to wake. */
const NEVER = 2 ** 32 - 1;

/**
 * The timer's alarms that were set for an instant that had passed. Such an alarm does not fire until the counter has come
 * round, so whatever it was to wake sleeps until something else sets the alarm. It counts if that takes longer than
 * software needs which notices it.
 */
export class LateAlarms {
  constructor() {
    this.count = 0;
    this.longestCycles = 0;
    this.firstCycle = null;
  }

  summary() {
    const first = this.firstCycle === null ? null : this.firstCycle * NANOS_PER_CYCLE;
    return { count: this.count, longest_us: this.longestCycles / CYCLES_PER_MICRO, first_t_ns: first };
  }

  /** Returns whether an alarm for `target` that is set at `now`, both in us of 32 bits, is late. */
  static isLate(target, now) {
    return target !== NEVER && (now - target) >>> 0 < PAST_MICROS;
  }

  /** An alarm that was late when it was set at cycle `since` has been replaced at cycle `until`. */
  replaced(since, until) {
    const cycles = until - since;
    if (cycles <= NOTICED_MICROS * CYCLES_PER_MICRO) return;
    this.count += 1;
    this.longestCycles = Math.max(this.longestCycles, cycles);
    this.firstCycle ??= since;
  }
}
