import { BasePeripheral } from 'rp2040js';

/** Registers that keep what is written to them; some read as something that follows from others. */
export class Plain extends BasePeripheral {
  /** @param {Map<number, (read: (offset: number) => number) => number>} computed by offset */
  constructor(chip, name, computed = new Map()) {
    super(chip, name);
    this.computed = computed;
    this.words = new Map();
  }

  readUint32(offset) {
    const stored = (at) => this.words.get(at) ?? 0;
    return (this.computed.get(offset)?.(stored) ?? stored(offset)) >>> 0;
  }

  writeUint32(offset, value) {
    this.words.set(offset, value);
  }
}
