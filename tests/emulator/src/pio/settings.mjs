import { rotateLeft } from './instructions.mjs';

const RESET = { clkdiv: 0x00010000, execctrl: 0x0001f000, shiftctrl: 0x000c0000, pinctrl: 0x14000000 };
const SIDE_FIELD_BITS = 5;
const SIDE_FIELD_SHIFT = 8;
const SIDE_ENABLE = 0x1000;
const WHOLE_DIVIDER = 0x10000;

const field = (word, shift, bits) => (word >>> shift) & ((1 << bits) - 1);
const flag = (word, bit) => ((word >>> bit) & 1) !== 0;
const pins = (count, base) => rotateLeft(count >= 32 ? -1 : (1 << count) - 1, base);

/** A machine's four control registers (datasheet 3.7), decoded once when they are written. */
export class MachineSettings {
  constructor() {
    Object.assign(this, RESET);
    this.period = 1;
    this.takeExecctrl(this.execctrl);
    this.takeShiftctrl(this.shiftctrl);
    this.takePinctrl(this.pinctrl);
  }

  /** CLKDIV as system clock cycles per tick: 1 to 65536, in steps of 1/256. */
  static periodOf(clkdiv) {
    const whole = field(clkdiv, 16, 16);
    return whole === 0 ? WHOLE_DIVIDER : whole + field(clkdiv, 8, 8) / 256;
  }

  takeExecctrl(word) {
    this.execctrl = word & 0x7fffffff;
    this.sideOptional = flag(word, 30);
    this.sideDirections = flag(word, 29);
    this.jumpPin = field(word, 24, 5);
    this.outEnableBit = field(word, 19, 5);
    this.outEnableInline = flag(word, 18);
    this.wrapTop = field(word, 12, 5);
    this.wrapBottom = field(word, 7, 5);
    this.statusOfRx = flag(word, 4);
    this.statusLevel = field(word, 0, 4);
    this.#divideSideField();
  }

  takeShiftctrl(word) {
    this.shiftctrl = word | 0;
    this.joinsRx = flag(word, 31);
    this.joinsTx = flag(word, 30);
    this.pullThreshold = field(word, 25, 5) || 32;
    this.pushThreshold = field(word, 20, 5) || 32;
    this.outRight = flag(word, 19);
    this.inRight = flag(word, 18);
    this.autopull = flag(word, 17);
    this.autopush = flag(word, 16);
  }

  takePinctrl(word) {
    this.pinctrl = word | 0;
    this.setBase = field(word, 5, 5);
    this.outBase = field(word, 0, 5);
    this.inBase = field(word, 15, 5);
    this.setMask = pins(field(word, 26, 3), this.setBase);
    this.outMask = pins(field(word, 20, 6), this.outBase);
    this.#divideSideField();
  }

  /** Every pin the machine may write. */
  get pins() {
    return this.sideMask | this.setMask | this.outMask;
  }

  /** Cycles of an instruction with its delay. */
  cyclesOf(op) {
    return (1 + ((op >> SIDE_FIELD_SHIFT) & this.delayMask)) * this.period;
  }

  /** The pins that an instruction's side-set writes. */
  sideMaskOf(op) {
    return this.sideOptional && (op & SIDE_ENABLE) === 0 ? 0 : this.sideMask;
  }

  /** The levels of these pins, among other bits. */
  sideValueOf(op) {
    return rotateLeft((op >> (SIDE_FIELD_SHIFT + this.delayBits)) & 31, this.sideBase);
  }

  /** Inline OUT enable: a bit of the data says whether the pins are written at all. */
  outEnabled(value) {
    return !this.outEnableInline || flag(value, this.outEnableBit);
  }

  /** Divides the instruction's five bits between side-set (with its enable bit, if optional) and delay. */
  #divideSideField() {
    const sideBits = field(this.pinctrl, 29, 3);
    this.delayBits = SIDE_FIELD_BITS - sideBits;
    this.delayMask = (1 << this.delayBits) - 1;
    this.sideBase = field(this.pinctrl, 10, 5);
    this.sideMask = pins(Math.max(0, sideBits - (this.sideOptional ? 1 : 0)), this.sideBase);
  }
}
