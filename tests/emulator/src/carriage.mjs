import { STEPS_PER_MM } from './pins.mjs';

/** Below this, in steps, a difference is the rounding of millimetres. */
const ROUNDING = 1e-6;

/**
 * One carriage on its motor: where it is, where the firmware's steps have taken it, and whether it presses its switch. With crossed
 * belts the motor moves another carriage too (belts.mjs): the place is the axis's, and the count of steps the motor's.
 */
export class Carriage {
  /**
   * @param {number} startMm how far above its switch it stands at power-up
   * @param {number} endMm where a hard end blocks it, above its switch; below it if negative
   */
  constructor(startMm, limitSwitch, endMm = -Infinity) {
    this.startMm = startMm;
    this.endSteps = Math.ceil((endMm - startMm) * STEPS_PER_MM - ROUNDING);
    this.limitSwitch = limitSwitch;
    /** Steps taken since power-up, up and down: never re-zeroed. */
    this.travelSteps = 0;
    this.lowestSteps = 0;
    this.highestSteps = 0;
    /** Steps of its motor that have moved nothing. */
    this.lostSteps = 0;
    /** The position in a trace: 0 at power-up, and 0 again when the axis is homed. */
    this.positionSteps = 0;
    limitSwitch.press(this.placeMm <= 0);
  }

  /** Distance above the switch. At 0 and below, the carriage presses it. */
  get placeMm() {
    return this.startMm + this.travelSteps / STEPS_PER_MM;
  }

  get lowestMm() {
    return this.startMm + this.lowestSteps / STEPS_PER_MM;
  }

  get highestMm() {
    return this.startMm + this.highestSteps / STEPS_PER_MM;
  }

  /** Whether a hard end keeps it from moving so far. */
  blocked(steps) {
    return steps < 0 && this.travelSteps + steps < this.endSteps;
  }

  /** A step of its motor. One that is not driven, or is against a hard end, is lost. */
  step(direction, driven = true) {
    const isMade = driven && !this.blocked(direction);
    this.count(direction, isMade);
    if (isMade) this.shift(direction);
  }

  /** Counts a step of its motor, as the firmware does, whatever becomes of it. */
  count(direction, isMade) {
    this.positionSteps += direction;
    if (!isMade) this.lostSteps += 1;
  }

  /** Moves it by so many steps. */
  shift(steps) {
    this.travelSteps += steps;
    this.lowestSteps = Math.min(this.lowestSteps, this.travelSteps);
    this.highestSteps = Math.max(this.highestSteps, this.travelSteps);
    this.limitSwitch.press(this.placeMm <= 0);
  }

  home() {
    this.positionSteps = 0;
  }
}
