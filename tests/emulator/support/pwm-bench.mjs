import { buildChip } from '../src/chip.mjs';
import { MachineClock } from '../src/clock.mjs';

const PWM = 0x40050000;
const [SLICE, SLICE_BYTES] = [6, 0x14];
const GPIO_CTRL = 0x40014004;
export const PIN = 13;
export const FUNCTION = { pwm: 4, sio: 5 };
export const ALIAS = { xor: 0x1000, set: 0x2000, clear: 0x3000 };
/** The registers of the slice whose output B is GP13. */
export const [CSR, DIV, CTR, CC, TOP] = [0x00, 0x04, 0x08, 0x0c, 0x10].map((register) => SLICE * SLICE_BYTES + register);
export const SLICE_BIT = 1 << SLICE;

/** A chip whose core stands still while time passes cycle by cycle. */
export class PwmBench {
  constructor() {
    this.clock = new MachineClock();
    this.warnings = [];
    const nothing = () => {};
    Object.assign(this, buildChip(this.clock, { onWatchdog: nothing, onUartByte: nothing, onWarning: (text) => this.warnings.push(text) }));
    this.control(PIN, FUNCTION.pwm);
  }

  get pin() {
    return this.chip.gpio[PIN];
  }

  get duty() {
    return this.chip.pwm.dutyOf(PIN);
  }

  runTo(cycle) {
    while (this.clock.next <= cycle) {
      this.core.cycles = this.clock.next;
      this.clock.fireDue();
    }
    this.core.cycles = cycle;
  }

  writeAt(address, value) {
    this.bus.write32(address | 0, value);
  }

  readAt(address) {
    return this.bus.read32(address | 0) >>> 0;
  }

  write(register, value, alias = 0) {
    this.writeAt(PWM + alias + register, value);
  }

  /** Writes a pin's CTRL: its function, and its overrides. */
  control(pin, value) {
    this.writeAt(GPIO_CTRL + 8 * pin, value);
  }

  read(register) {
    return this.readAt(PWM + register);
  }

  /** Starts the slice on this cycle. */
  start({ div = 1, cc, top }) {
    this.write(DIV, div * 16);
    this.write(TOP, top);
    this.write(CC, cc << 16);
    this.write(CSR, 1);
  }

  /** The level on each of the next `count` cycles. */
  levels(count) {
    return Array.from({ length: count }, () => {
      const high = this.pin.outputValue;
      this.runTo(this.core.cycles + 1);
      return Number(high);
    }).join('');
  }
}
