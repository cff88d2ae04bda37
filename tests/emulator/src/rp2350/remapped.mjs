import { BasePeripheral } from 'rp2040js';

/**
 * A peripheral of the RP2040 at the RP2350's addresses: the same registers in other places, with some of their bits moved.
 *
 * Writes by which bits are set, cleared or inverted are passed on as they are, with the bits moved alike.
 */
export class Remapped extends BasePeripheral {
  /**
   * @param {BasePeripheral} inner
   * @param {(offset: number) => number | null} place where a register of the RP2350 is in the RP2040; null if it has none, which reads as 0
   * @param {{toInner: (offset: number, word: number) => number, fromInner: (offset: number, word: number) => number}} moved
   */
  constructor(chip, name, inner, place, moved = AS_THEY_ARE) {
    super(chip, name);
    Object.assign(this, { inner, place, moved });
  }

  readUint32(offset) {
    const at = this.place(offset);
    return at === null ? 0 : this.moved.fromInner(offset, this.inner.readUint32(at)) >>> 0;
  }

  writeUint32Atomic(offset, value, kind) {
    const at = this.place(offset);
    if (at !== null) this.inner.writeUint32Atomic(at, this.moved.toInner(offset, value) >>> 0, kind);
    else if (value !== 0) this.warn(`a write of 0x${value.toString(16)} to offset 0x${offset.toString(16)}, which is not emulated`);
  }
}

const AS_THEY_ARE = { toInner: (_, word) => word, fromInner: (_, word) => word };

/** Moves fields of a word. @param {{from: number, to: number, bits: number}[]} fields */
export function mover(fields) {
  const move = (word, from, to, bits) => ((word >>> from) & (2 ** bits - 1)) << to;
  return {
    there: (word) => fields.reduce((moved, { from, to, bits }) => moved | move(word, from, to, bits), 0),
    back: (word) => fields.reduce((moved, { from, to, bits }) => moved | move(word, to, from, bits), 0),
  };
}
