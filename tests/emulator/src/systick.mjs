import { CYCLES_PER_MICRO } from './clock.mjs';

const [CSR, RVR, CVR, CALIB] = [0x010, 0x014, 0x018, 0x01c];
const BIT = { enable: 1 << 0, interrupts: 1 << 1, coreClock: 1 << 2, counted: 1 << 16 };
const COUNT_MASK = 0xffffff;
/** TENMS: 10 ms of the 1 us reference, and not skewed. */
const CALIBRATION = 0x0000270f;

/**
 * SysTick (ARMv6-M B3.3): a 24-bit counter that falls by one each core cycle (or each microsecond, without CLKSOURCE),
 * so that firmware can measure time. rp2040js's rounds through nanoseconds and restarts in wrong places.
 */
export class SysTick {
  constructor(chip) {
    this.core = chip.core;
    this.clock = chip.clock;
    this.control = 0;
    this.reload = 0;
    this.counted = false;
    /** The count while the timer is stopped; while it runs, the count at `sinceCycle`. */
    this.count = 0;
    this.sinceCycle = 0;
    this.alarm = this.clock.createAlarm(() => this.#reachedZero());
  }

  /** Replaces rp2040js's SysTick in the private peripherals. */
  attach(ppb) {
    const { readUint32, writeUint32 } = ppb;
    const ours = (offset) => offset >= CSR && offset <= CALIB;
    ppb.readUint32 = (offset) => (ours(offset) ? this.read(offset) : readUint32.call(ppb, offset));
    ppb.writeUint32 = (offset, value) => (ours(offset) ? this.write(offset, value) : writeUint32.call(ppb, offset, value));
  }

  get tickCycles() {
    return this.control & BIT.coreClock ? 1 : CYCLES_PER_MICRO;
  }

  get value() {
    if (!(this.control & BIT.enable)) return this.count;
    const ticks = Math.floor((this.clock.cycles - this.sinceCycle) / this.tickCycles);
    if (ticks <= this.count) return this.count - ticks;
    // From 0 the count goes to the reload value.
    const period = this.reload + 1;
    return this.reload - ((ticks - this.count - 1) % period);
  }

  read(offset) {
    switch (offset) {
      case CSR:
        return this.#status();
      case RVR:
        return this.reload;
      case CVR:
        return this.value;
      default:
        return CALIBRATION;
    }
  }

  write(offset, value) {
    const count = this.value;
    if (offset === CSR) this.control = value & (BIT.enable | BIT.interrupts | BIT.coreClock);
    if (offset === RVR) this.reload = value & COUNT_MASK;
    if (offset === CVR) this.counted = false;
    this.#restart(offset === CVR ? 0 : count);
  }

  /** COUNTFLAG is cleared by reading it. */
  #status() {
    const status = this.control | (this.counted ? BIT.counted : 0);
    this.counted = false;
    return status;
  }

  #restart(count) {
    this.count = count;
    this.sinceCycle = this.clock.cycles;
    this.alarm.cancel();
    if (!(this.control & BIT.enable)) return;
    const ticks = count > 0 ? count : this.reload + 1;
    if (ticks > 1 || count === 1) this.alarm.scheduleAt(this.sinceCycle + ticks * this.tickCycles);
  }

  /** The count goes from 1 to 0. */
  #reachedZero() {
    this.counted = true;
    if (this.control & BIT.interrupts) {
      this.core.pendingSystick = true;
      this.core.interruptsUpdated = true;
      this.core.sleep.pended();
    }
    this.#restart(0);
  }
}
