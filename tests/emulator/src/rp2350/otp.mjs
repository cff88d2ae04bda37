import { BasePeripheral } from 'rp2040js';

/** The chip's own number, which is in the first rows of 16 bits, the lowest first: that of the emulated RP2040's flash, whatever the board. */
const CHIP_ID_ROWS = [0x1125, 0x832a, 0x5838, 0xe660];

/**
 * The one-time programmable memory (datasheet 13), as far as it has the chip's number: two rows a word with their errors corrected, or one row
 * a word as it is, here without the bits that correct. All other rows are 0.
 */
export class Otp extends BasePeripheral {
  /** @param {boolean} isRaw a row a word */
  constructor(chip, name, isRaw) {
    super(chip, name);
    this.isRaw = isRaw;
  }

  readUint32(offset) {
    const row = (index) => CHIP_ID_ROWS[index] ?? 0;
    const word = offset >>> 2;
    return this.isRaw ? row(word) : (row(2 * word) | (row(2 * word + 1) << 16)) >>> 0;
  }
}
