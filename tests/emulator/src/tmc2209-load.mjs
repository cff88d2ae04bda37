import { REGISTER } from './tmc2209-registers.mjs';
import { isFaster } from './tmc2209-steps.mjs';

const { GCONF, TPWMTHRS, TCOOLTHRS, SGTHRS } = REGISTER;
/** SG_RESULT, always even: some 200 where nothing loads the motor, near 0 where it is blocked, and no use at slower TSTEPs than this. */
const [FREE, NOISE, BLOCKED_NOISE, SLOW_TSTEP] = [200, 20, 4, 2000];

/** StallGuard: the load that a driver measures once each full step, and when that counts as a stall. */
export class LoadMeter {
  /** SG_RESULT. */
  result = 0;
  #beyondPwm = false;
  #beyondCool = false;

  /**
   * @param {() => number} random
   * @param {import('./tmc2209-registers.mjs').Registers} registers
   */
  constructor(random, registers) {
    Object.assign(this, { random, registers });
    this.configure();
  }

  /** Registers have been written. */
  configure() {
    const { registers } = this;
    this.spread = registers.field(GCONF, 2, 1) === 1;
    this.pwmLimit = registers.field(TPWMTHRS);
    this.coolLimit = registers.field(TCOOLTHRS) + 1;
    this.stallLimit = 2 * registers.field(SGTHRS);
  }

  /** Whether it is in StealthChop now. Beyond TPWMTHRS it is in SpreadCycle, which measures no load. */
  get stealth() {
    return !this.spread && !this.#beyondPwm;
  }

  get stalled() {
    return this.#beyondCool && this.stealth && this.result <= this.stallLimit;
  }

  follow(tstep) {
    this.#beyondPwm = isFaster(this.#beyondPwm, tstep, this.pwmLimit);
    this.#beyondCool = isFaster(this.#beyondCool, tstep, this.coolLimit);
  }

  /** A full step has been made. */
  measure(tstep, blocked) {
    if (!this.stealth) this.result = 0;
    else if (blocked) this.result = this.#even(BLOCKED_NOISE);
    else this.result = tstep > SLOW_TSTEP ? this.#even(FREE) : FREE - NOISE + this.#even(2 * NOISE);
  }

  #even(most) {
    return 2 * Math.floor((this.random() * most) / 2 + 0.5);
  }
}
