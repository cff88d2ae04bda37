import { seededRandom } from './limit-switch.mjs';
import { DriverFaults } from './tmc2209-faults.mjs';
import { LoadMeter } from './tmc2209-load.mjs';
import { CLOCK_TRIM, REGISTER, Registers } from './tmc2209-registers.mjs';
import { cyclesOfClocks, StepInput } from './tmc2209-steps.mjs';

const { GCONF, GSTAT, IFCNT, NODECONF, OTP_READ, IOIN, FACTORY_CONF, IHOLD_IRUN, TPOWERDOWN, TSTEP, SG_RESULT, MSCNT, CHOPCONF, DRV_STATUS } = REGISTER;
const VERSION = 0x21;
const [RESET, DRIVER_ERROR] = [1 << 0, 1 << 1];
/** By the pins that are the address too: MS1 is its bit 0, MS2 its bit 1 (data sheet 1.6). */
const MRES_OF_PINS = [5, 3, 2, 4];
const FULL_STEP_MRES = 8;
const POWER_DOWN_CLOCKS = 2 ** 18;

/** A TMC2209: its registers, what it makes of STEP, its load measurement with DIAG, and its faults. */
export class Tmc2209 {
  registers = new Registers();
  faults = new DriverFaults();
  reads = 0;
  writes = 0;
  /** Datagrams to its address with a wrong CRC. */
  refused = 0;
  #powered = true;
  #status = RESET;
  #count = 0;
  #input = new StepInput();
  #load;
  #random;
  #enabled = true;
  /** What a step moves the motor by with DIR high, in 1/256 of a full step. */
  #stepLength;
  #energised = true;
  #error = false;
  #diag = false;

  /**
   * @param {import('./clock.mjs').MachineClock} clock
   * @param {{address: number, seed: number, levels: () => {step: boolean, dir: boolean}, onDiag?: (high: boolean) => void}} wiring
   *   its address by MS1 and MS2, the seed of its noise, what STEP and DIR are at, and who sees DIAG change
   */
  constructor(clock, { address, seed, levels, onDiag = () => {} }) {
    Object.assign(this, { clock, address, levels, onDiag });
    this.#random = seededRandom(seed + address);
    this.standstill = clock.createOutsideAlarm(() => this.#follow());
    this.powerUp();
  }

  get powered() {
    return this.#powered;
  }

  get diag() {
    return this.#diag;
  }

  /** Its supply comes back: every register is as at first. */
  powerUp() {
    this.#powered = true;
    this.registers.reset();
    [this.#status, this.#count, this.#error] = [RESET, 0, false];
    this.#input = new StepInput();
    this.#load = new LoadMeter(this.#random, this.registers);
    this.#settle();
  }

  /** @param {string} state one of DRIVER_STATES */
  set(state) {
    if (state === 'on') return this.powerUp();
    if (state === 'off') this.#powered = false;
    else this.faults.set(state);
    this.#settle();
  }

  /** ENN is low, or not. */
  enable(enabled) {
    this.#enabled = enabled;
    this.#settle();
  }

  /** A rising edge of STEP. @returns {boolean} whether the motor is driven, so that it turns if nothing blocks it */
  step(up, blocked) {
    if (!this.#powered) return false;
    const begins = this.#input.step(this.clock.cycles, up ? this.#stepLength : -this.#stepLength);
    if (begins) this.#load.measure(this.#input.tstep(this.clock.cycles), blocked);
    this.#follow();
    return this.#energised && !this.faults.open;
  }

  write(register, value) {
    this.#count = (this.#count + 1) & 0xff;
    if (register === GSTAT) this.#status &= ~value;
    else this.registers.write(register, value);
    this.#settle();
  }

  read(register) {
    switch (register) {
      case GSTAT:
        return this.#status;
      case IFCNT:
        return this.#count;
      case OTP_READ:
        return CLOCK_TRIM;
      case IOIN:
        return this.#inputs();
      case TSTEP:
        return this.#input.tstep(this.clock.cycles);
      case SG_RESULT:
        return this.#load.result;
      case MSCNT:
        return this.#input.position;
      case DRV_STATUS:
        return this.#driverStatus();
    }
    return this.registers.read(register);
  }

  /** Bit times before it answers. */
  get sendDelayBits() {
    return 8 * (this.registers.field(NODECONF, 8, 4) | 1);
  }

  /** The power of two of 1/256 steps that a step makes. */
  get mres() {
    return this.#bit(GCONF, 7) ? Math.min(FULL_STEP_MRES, this.registers.field(CHOPCONF, 24, 4)) : MRES_OF_PINS[this.address];
  }

  get microsteps() {
    return 2 ** (FULL_STEP_MRES - this.mres);
  }

  get runCurrent() {
    return this.registers.field(IHOLD_IRUN, 8, 5);
  }

  get holdCurrent() {
    return this.registers.field(IHOLD_IRUN, 0, 5);
  }

  /** As configured; beyond TPWMTHRS it is SpreadCycle in any case. */
  get chopper() {
    return this.#bit(GCONF, 2) ? 'SpreadCycle' : 'StealthChop';
  }

  get energised() {
    return this.#energised;
  }

  get #trim() {
    return this.registers.field(FACTORY_CONF, 8, 2);
  }

  #bit(register, bit) {
    return this.registers.field(register, bit, 1) === 1;
  }

  /** Something other than a step has changed. */
  #settle() {
    const switchedOn = this.#powered && this.#enabled && this.registers.field(CHOPCONF, 0, 4) > 0;
    this.#stepLength = (this.#bit(GCONF, 3) ? -1 : 1) * 2 ** this.mres;
    this.#load.configure();
    this.faults.look(switchedOn, this.#trim);
    const { tripped } = this.faults;
    this.#energised = switchedOn && !tripped;
    this.#error = tripped || (this.#error && switchedOn);
    if (this.#powered && tripped) this.#status |= DRIVER_ERROR;
    this.#follow();
  }

  /** DIAG follows the speed and the load, and errors until the driver is switched off. */
  #follow() {
    this.#load.follow(this.#input.tstep(this.clock.cycles));
    const stalled = this.#energised && this.#load.stalled;
    if (stalled) this.standstill.scheduleAt(this.#input.standstillCycle);
    this.#show(this.#powered && (this.#error || stalled));
  }

  #show(diag) {
    if (diag === this.#diag) return;
    this.#diag = diag;
    this.onDiag(diag);
  }

  #inputs() {
    const { step, dir } = this.levels();
    const bits = [!this.#enabled, false, (this.address & 1) === 1, (this.address & 2) === 2, this.#diag, false, true, step, false, dir];
    return bits.reduce((all, high, bit) => all | (high ? 1 << bit : 0), VERSION << 24) >>> 0;
  }

  #driverStatus() {
    const stands = this.#input.stands(this.clock.cycles) ? 2 ** 31 : 0;
    return stands + (this.#load.stealth ? 2 ** 30 : 0) + (this.#actualCurrent() << 16) + this.faults.flags(this.#trim);
  }

  /** After TPOWERDOWN the current falls to that of standstill, a step each IHOLDDELAY, unless PDN_UART, which idles high, forbids it. */
  #actualCurrent() {
    const { registers } = this;
    const since = this.clock.cycles - this.#input.standstillCycle - cyclesOfClocks(POWER_DOWN_CLOCKS * registers.field(TPOWERDOWN));
    if (!this.#bit(GCONF, 6) || since < 0) return this.runCurrent;
    const perStep = cyclesOfClocks(POWER_DOWN_CLOCKS * registers.field(IHOLD_IRUN, 16, 4));
    const steps = perStep === 0 ? Infinity : Math.floor(since / perStep);
    return Math.max(Math.min(this.holdCurrent, this.runCurrent), this.runCurrent - steps);
  }
}
