import { CYCLES_PER_MICRO, nanosOf } from './clock.mjs';

/** Software that notices that it was late sets the alarm again within microseconds. */
const NOTICED_MICROS = 20;
/** A target that lies further back is one of the far future, after the counter has come round. */
const PAST_MICROS = 1_000_000;
/** The target if there is nothing to wake. */
const NEVER = 2 ** 32 - 1;

/**
 * The timer's alarms that were set for an instant that had passed. Such an alarm does not fire until the counter has come
 * round, so whatever it was to wake sleeps until something else sets the alarm. It counts if that takes longer than
 * software needs which notices it, or if nothing sets the alarm again until the end.
 */
export class LateAlarms {
  constructor() {
    this.count = 0;
    this.longestCycles = 0;
    this.firstCycle = null;
    /** The cycle at which each alarm was set that is late now. */
    this.since = new Map();
  }

  /** The results at cycle `now`, at the end of the run. */
  summary(now) {
    for (const alarm of [...this.since.keys()]) this.cleared(alarm, now);
    const first = this.firstCycle === null ? null : nanosOf(this.firstCycle);
    return { count: this.count, longest_us: this.longestCycles / CYCLES_PER_MICRO, first_t_ns: first };
  }

  /** A chip starts, with no alarm set. */
  restarted() {
    this.since.clear();
  }

  /** This alarm is set for `target` at `micros`, both in us of 32 bits, in this cycle. */
  set(alarm, target, micros, cycle) {
    if (target !== NEVER && (micros - target) >>> 0 < PAST_MICROS) this.since.set(alarm, cycle);
  }

  /** This alarm is set no longer, from this cycle on. */
  cleared(alarm, cycle) {
    const since = this.since.get(alarm) ?? cycle;
    this.since.delete(alarm);
    const cycles = cycle - since;
    if (cycles <= NOTICED_MICROS * CYCLES_PER_MICRO) return;
    this.count += 1;
    this.longestCycles = Math.max(this.longestCycles, cycles);
    this.firstCycle ??= since;
  }
}
