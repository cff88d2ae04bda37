import { BasePeripheral } from 'rp2040js';
import { CYCLES_PER_MICRO } from './clock.mjs';
import { LateAlarms } from './late-alarms.mjs';

const [TIMEHR, TIMELR, ALARM0, ALARM3, ARMED] = [0x08, 0x0c, 0x10, 0x1c, 0x20];
const [TIMERAWH, TIMERAWL, INTR, INTE, INTF, INTS] = [0x24, 0x28, 0x34, 0x38, 0x3c, 0x40];
const ALARMS = 4;
const TWO_TO_32 = 2 ** 32;

/**
 * The RP2040's microsecond timer (datasheet 4.6), exact to the cycle: an alarm fires on the cycle on which the low word
 * of the time becomes its target. rp2040js's own truncates the delay and fires up to 1 us early.
 */
export class ExactTimer extends BasePeripheral {
  /** @param {LateAlarms} late counts the alarms that were set too late */
  constructor(chip, name, late = new LateAlarms()) {
    super(chip, name);
    this.late = late;
    late.restarted();
    this.clock = chip.clock;
    this.startCycle = chip.clock.cycles;
    this.latchedHigh = 0;
    this.targets = new Uint32Array(ALARMS);
    this.alarms = Array.from({ length: ALARMS }, (_, index) => this.clock.createAlarm(() => this.#fire(index)));
    this.raised = 0;
    this.enabled = 0;
    this.forced = 0;
  }

  get micros() {
    return Math.floor((this.clock.cycles - this.startCycle) / CYCLES_PER_MICRO);
  }

  get status() {
    return (this.raised & this.enabled) | this.forced;
  }

  readUint32(offset) {
    if (offset >= ALARM0 && offset <= ALARM3) return this.targets[(offset - ALARM0) / 4];
    switch (offset) {
      case TIMELR:
        this.latchedHigh = Math.floor(this.micros / TWO_TO_32);
        return this.micros >>> 0;
      case TIMEHR:
        return this.latchedHigh;
      case TIMERAWH:
        return Math.floor(this.micros / TWO_TO_32);
      case TIMERAWL:
        return this.micros >>> 0;
      case ARMED:
        return this.alarms.reduce((bits, alarm, index) => bits | (alarm.scheduled ? 1 << index : 0), 0);
      case INTR:
        return this.raised;
      case INTE:
        return this.enabled;
      case INTF:
        return this.forced;
      case INTS:
        return this.status;
    }
    return super.readUint32(offset);
  }

  writeUint32(offset, value) {
    if (offset >= ALARM0 && offset <= ALARM3) return this.#arm((offset - ALARM0) / 4, value);
    switch (offset) {
      case ARMED:
        this.alarms.forEach((_, index) => this.rawWriteValue & (1 << index) && this.#disarm(index));
        return;
      case INTR:
        this.raised &= ~this.rawWriteValue;
        return this.#interrupt();
      case INTE:
        this.enabled = value & 0xf;
        return this.#interrupt();
      case INTF:
        this.forced = value & 0xf;
        return this.#interrupt();
    }
    super.writeUint32(offset, value);
  }

  /** Arms an alarm. As on the chip, a target that is now or has just passed is reached again only after 2^32 us. */
  #arm(index, target) {
    this.#disarm(index);
    this.targets[index] = target;
    const now = this.micros;
    this.late.set(index, target, now, this.clock.cycles);
    const wait = (target - now) >>> 0 || TWO_TO_32;
    this.alarms[index].scheduleAt(this.startCycle + (now + wait) * CYCLES_PER_MICRO);
  }

  #disarm(index) {
    this.alarms[index].cancel();
    this.late.cleared(index, this.clock.cycles);
  }

  #fire(index) {
    this.raised |= 1 << index;
    this.#interrupt();
  }

  #interrupt() {
    const { status } = this;
    for (let index = 0; index < ALARMS; index++) this.rp2040.setInterrupt(index, (status & (1 << index)) !== 0);
  }
}
