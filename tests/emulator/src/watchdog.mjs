import { BasePeripheral } from 'rp2040js';
import { CYCLES_PER_MICRO, IS_RP2350 } from './clock.mjs';

const [CTRL, LOAD, REASON, SCRATCH0, SCRATCH7, TICK] = [0x00, 0x04, 0x08, 0x0c, 0x28, 0x2c];
const TRIGGER = 1 << 31;
const ENABLE = 1 << 30;
const COUNT_MASK = 0xffffff;
const TICK_RUNNING = 0x600;
/** Erratum RP2040-E1: the counter falls by two every microsecond. An RP2350's falls by one. */
const COUNTS_PER_MICRO = IS_RP2350 ? 1 : 2;

export const RESET_TIMER = 1;
export const RESET_FORCED = 2;

/**
 * The watchdog (datasheet 4.7) with an alarm of its own, because rp2040js's countdown schedules itself for the same
 * instant forever. It makes the board reset; scratch registers and the reason outlive that.
 */
export class Watchdog extends BasePeripheral {
  /** @param {(reason: number) => void} onBite */
  constructor(chip, name, onBite) {
    super(chip, name);
    this.clock = chip.clock;
    this.onBite = onBite;
    this.enabled = false;
    this.count = 0;
    this.countedAtCycle = this.clock.cycles;
    this.reason = 0;
    this.scratch = new Uint32Array(8);
    this.alarm = this.clock.createAlarm(() => this.onBite(RESET_TIMER));
  }

  get remaining() {
    if (!this.enabled) return this.count;
    const micros = Math.floor((this.clock.cycles - this.countedAtCycle) / CYCLES_PER_MICRO);
    return Math.max(0, this.count - micros * COUNTS_PER_MICRO);
  }

  readUint32(offset) {
    if (offset >= SCRATCH0 && offset <= SCRATCH7) return this.scratch[(offset - SCRATCH0) / 4];
    switch (offset) {
      case CTRL:
        return (this.enabled ? ENABLE : 0) | this.remaining;
      case REASON:
        return this.reason;
      case TICK:
        return TICK_RUNNING;
    }
    return super.readUint32(offset);
  }

  writeUint32(offset, value) {
    if (offset >= SCRATCH0 && offset <= SCRATCH7) {
      this.scratch[(offset - SCRATCH0) / 4] = value;
    } else if (offset === CTRL) {
      this.#count(this.remaining, (value & ENABLE) !== 0);
      // The core finishes its instruction first, so the reset comes on the next cycle.
      if (value & TRIGGER) this.clock.createAlarm(() => this.onBite(RESET_FORCED)).schedule(0);
    } else if (offset === LOAD) {
      this.#count(value & COUNT_MASK, this.enabled);
    } else if (offset !== TICK) {
      super.writeUint32(offset, value);
    }
  }

  #count(count, enabled) {
    this.count = count;
    this.enabled = enabled;
    this.countedAtCycle = this.clock.cycles;
    this.alarm.cancel();
    if (enabled) this.alarm.scheduleAt(this.countedAtCycle + Math.ceil(count / COUNTS_PER_MICRO) * CYCLES_PER_MICRO);
  }
}
