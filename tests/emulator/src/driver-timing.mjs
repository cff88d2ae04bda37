/** The DRV8825's least times, in nanoseconds. */
export const DRV8825 = { step_high: 1900, step_low: 1900, dir_setup: 650, dir_hold: 650, enable_setup: 650, enable_hold: 650 };
const KEPT = 5;

/** Holds every edge of STEP, DIR and ENABLE against what the driver needs. */
export class DriverTiming {
  constructor(limits = DRV8825) {
    this.limits = limits;
    this.counts = {};
    /** The first few, with their time and value. */
    this.first = [];
    this.axes = {};
    this.enableNanos = -Infinity;
    this.energised = true;
  }

  get total() {
    return Object.values(this.counts).reduce((sum, count) => sum + count, 0);
  }

  /** A rising edge of STEP. @returns {boolean} whether the driver takes the step: not while it is off */
  rise(axis, nanos) {
    const seen = this.#axis(axis);
    this.#check('step_low', axis, nanos, nanos - seen.fallNanos);
    this.#check('dir_setup', axis, nanos, nanos - seen.dirNanos);
    this.#check('enable_setup', axis, nanos, nanos - this.enableNanos);
    if (!this.energised) this.#record('step_while_off', axis, nanos, 0, 0);
    seen.riseNanos = nanos;
    return this.energised;
  }

  fall(axis, nanos) {
    const seen = this.#axis(axis);
    this.#check('step_high', axis, nanos, nanos - seen.riseNanos);
    seen.fallNanos = nanos;
  }

  turn(axis, nanos) {
    const seen = this.#axis(axis);
    this.#check('dir_hold', axis, nanos, nanos - seen.riseNanos);
    seen.dirNanos = nanos;
  }

  enable(energised, nanos) {
    if (!energised) {
      for (const axis of Object.keys(this.axes)) this.#check('enable_hold', axis, nanos, nanos - this.axes[axis].riseNanos);
    }
    this.energised = energised;
    this.enableNanos = nanos;
  }

  #axis(axis) {
    return (this.axes[axis] ??= { riseNanos: -Infinity, fallNanos: -Infinity, dirNanos: -Infinity });
  }

  #check(rule, axis, nanos, value) {
    if (value < this.limits[rule]) this.#record(rule, axis, nanos, value, this.limits[rule]);
  }

  #record(rule, axis, nanos, value, limit) {
    this.counts[rule] = (this.counts[rule] ?? 0) + 1;
    if (this.first.length < KEPT) this.first.push({ rule, axis, t_ns: nanos, value_ns: value, limit_ns: limit });
  }
}
