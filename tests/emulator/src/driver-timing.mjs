import { AXES, SECOND } from './pins.mjs';

const MOTORS = [...AXES, SECOND];

/**
 * The drivers' minimum times, in nanoseconds, from their datasheets: TI's DRV8825 (table 7.6), Trinamic's TMC2209
 * (section 13.1, at its own 12 MHz clock; it has no times for ENABLE, so those of DIR are used).
 */
export const DRIVERS = {
  drv8825: { name: 'DRV8825', step_high: 1900, step_low: 1900, dir_setup: 650, dir_hold: 650, enable_setup: 650, enable_hold: 650 },
  tmc2209: { name: 'TMC2209', step_high: 100, step_low: 100, dir_setup: 20, dir_hold: 20, enable_setup: 20, enable_hold: 20 },
};
const KEPT = 5;

/** Checks every edge of STEP, DIR and ENABLE against the driver's minimum times. */
export class DriverTiming {
  constructor(limits = DRIVERS.drv8825) {
    this.limits = limits;
    this.counts = {};
    /** The first few violations, with their time and value. */
    this.first = [];
    this.axes = Object.fromEntries(MOTORS.map((axis) => [axis, { riseNanos: -Infinity, fallNanos: -Infinity, dirNanos: -Infinity }]));
    this.enableNanos = -Infinity;
    this.energised = true;
  }

  get total() {
    return Object.values(this.counts).reduce((sum, count) => sum + count, 0);
  }

  /** A rising edge of STEP. @returns {boolean} whether the driver takes the step; it does not while it is off */
  rise(axis, nanos) {
    const { limits } = this;
    const seen = this.axes[axis];
    if (nanos - seen.fallNanos < limits.step_low) this.#record('step_low', axis, nanos, nanos - seen.fallNanos);
    if (nanos - seen.dirNanos < limits.dir_setup) this.#record('dir_setup', axis, nanos, nanos - seen.dirNanos);
    if (nanos - this.enableNanos < limits.enable_setup) this.#record('enable_setup', axis, nanos, nanos - this.enableNanos);
    if (!this.energised) this.#record('step_while_off', axis, nanos, 0);
    seen.riseNanos = nanos;
    return this.energised;
  }

  fall(axis, nanos) {
    const seen = this.axes[axis];
    if (nanos - seen.riseNanos < this.limits.step_high) this.#record('step_high', axis, nanos, nanos - seen.riseNanos);
    seen.fallNanos = nanos;
  }

  turn(axis, nanos) {
    const seen = this.axes[axis];
    if (nanos - seen.riseNanos < this.limits.dir_hold) this.#record('dir_hold', axis, nanos, nanos - seen.riseNanos);
    seen.dirNanos = nanos;
  }

  enable(energised, nanos) {
    for (const axis of energised ? [] : MOTORS) {
      const heldNanos = nanos - this.axes[axis].riseNanos;
      if (heldNanos < this.limits.enable_hold) this.#record('enable_hold', axis, nanos, heldNanos);
    }
    this.energised = energised;
    this.enableNanos = nanos;
  }

  #record(rule, axis, nanos, value) {
    this.counts[rule] = (this.counts[rule] ?? 0) + 1;
    if (this.first.length < KEPT) this.first.push({ rule, axis, t_ns: nanos, value_ns: value, limit_ns: this.limits[rule] ?? 0 });
  }
}
