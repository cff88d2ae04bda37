import { BasePeripheral } from 'rp2040js';
import { CSR, PwmSlice } from './pwm-slice.mjs';

const SLICES = 8;
const SLICE_BYTES = 0x14;
const SLICES_END = SLICES * SLICE_BYTES;
const REGISTER = { csr: 0x00, div: 0x04, ctr: 0x08, cc: 0x0c, top: 0x10 };
const [EN, INTR, INTE, INTF, INTS] = [0xa0, 0xa4, 0xa8, 0xac, 0xb0];
const ALL_SLICES = 0xff;
const ALL_PINS = 0x3fffffff;
const CHANNELS = 2;
const IRQ_PWM_WRAP = 4;

export const FUNCTION_PWM = 4;

/** Which slice and which of its outputs (0 for A, 1 for B) a pin shows. */
const channelOf = (pin) => ({ slice: (pin >> 1) & (SLICES - 1), channel: pin & 1 });

/**
 * The PWM block (datasheet 4.5), exact to the cycle; rp2040js's counts in rounded nanoseconds. A level is computed when
 * it is read. Pins are always informed of changes by registers and latches; of other edges, only if they are to be
 * shown.
 */
export class Pwm extends BasePeripheral {
  #slices;
  #enabled = 0;
  #forced = 0;
  #awaited = 0;

  constructor(chip, name) {
    super(chip, name);
    /** All pins of a free-running slice are outputs. */
    this.gpioDirection = ALL_PINS;
    /** rp2040js calls these when the system clock changes. The machine's clock never changes. */
    this.channels = [];
    this.#slices = Array.from({ length: SLICES }, (_, index) => new PwmSlice(chip.clock, () => this.#changed(index)));
  }

  /** The levels of all pins, a bit each. */
  get gpioValue() {
    let levels = 0;
    this.#slices.forEach((slice, index) => {
      for (let channel = 0; channel < CHANNELS; channel++) if (slice.level(channel)) levels |= 1 << (CHANNELS * index + channel);
    });
    return (levels | (levels << (SLICES * CHANNELS))) & ALL_PINS;
  }

  /** The fraction of time during which the slice drives a pin high. */
  dutyOf(pin) {
    const { slice, channel } = channelOf(pin);
    return this.#slices[slice].duty(channel);
  }

  /** From now on, shows every edge of this pin's slice on the pin, on its cycle. */
  showEdges(pin) {
    this.#slices[channelOf(pin).slice].showEdges();
  }

  /** rp2040js reports the levels of inputs here. A free-running slice ignores them. */
  gpioOnInput() {}

  readUint32(offset) {
    if (offset < SLICES_END) return this.#readSlice(this.#slices[Math.floor(offset / SLICE_BYTES)], offset % SLICE_BYTES);
    switch (offset) {
      case EN:
        return this.#bits((slice) => slice.enabled);
      case INTR:
        return this.#raised;
      case INTE:
        return this.#enabled;
      case INTF:
        return this.#forced;
      case INTS:
        return this.#status;
    }
    return super.readUint32(offset);
  }

  writeUint32(offset, value) {
    if (offset < SLICES_END) return this.#writeSlice(this.#slices[Math.floor(offset / SLICE_BYTES)], offset % SLICE_BYTES, value);
    switch (offset) {
      case EN:
        return this.#slices.forEach((slice, index) => slice.writeCsr((slice.csr & ~CSR.enable) | ((value >>> index) & 1)));
      case INTR:
        return this.#slices.forEach((slice, index) => (this.rawWriteValue >>> index) & 1 && slice.clearWrapped());
      case INTE:
        this.#enabled = value & ALL_SLICES;
        return this.#awaitWraps();
      case INTF:
        this.#forced = value & ALL_SLICES;
        return this.#interrupt();
    }
    super.writeUint32(offset, value);
  }

  get #raised() {
    return this.#bits((slice) => slice.wrapped);
  }

  get #status() {
    return (this.#raised & this.#enabled) | this.#forced;
  }

  #bits(holds) {
    return this.#slices.reduce((bits, slice, index) => bits | (holds(slice) ? 1 << index : 0), 0);
  }

  #readSlice(slice, register) {
    switch (register) {
      case REGISTER.csr:
        return slice.csr;
      case REGISTER.div:
        return slice.div;
      case REGISTER.ctr:
        return slice.counter;
      case REGISTER.cc:
        return slice.cc;
    }
    return slice.top;
  }

  #writeSlice(slice, register, value) {
    switch (register) {
      case REGISTER.csr:
        if (value & (CSR.phaseCorrect | CSR.divMode | CSR.retard | CSR.advance)) this.warn(`CSR 0x${value.toString(16)}: slices run free and trailing-edge only`);
        return slice.writeCsr(value);
      case REGISTER.div:
        return slice.writeDiv(value);
      case REGISTER.ctr:
        return slice.writeCounter(value);
      case REGISTER.cc:
        return slice.writeCc(value);
    }
    slice.writeTop(value);
  }

  #awaitWraps() {
    this.#slices.forEach((slice, index) => {
      const bit = 1 << index;
      if ((this.#enabled ^ this.#awaited) & bit) slice.awaitWrap((this.#enabled & bit) !== 0);
    });
    this.#awaited = this.#enabled;
    this.#interrupt();
  }

  #changed(index) {
    if ((this.#enabled | this.#forced) !== 0) this.#interrupt();
    for (const pin of this.rp2040.gpio) {
      if (pin.functionSelect === FUNCTION_PWM && channelOf(pin.index).slice === index) pin.checkForUpdates();
    }
  }

  #interrupt() {
    this.rp2040.setInterrupt(IRQ_PWM_WRAP, this.#status !== 0);
  }
}
