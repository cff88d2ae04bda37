/** The ROM's size: 16 KiB at address 0. */
export const ROM_BYTES = 0x4000;
const [MAGIC_AND_VERSION, FUNCTIONS_AT, DATA_AT, LOOKUP_AT, FIRST_FREE] = [0x10, 0x14, 0x16, 0x18, 0x20];
/** 'M', 'u', 1, and the version number of the RP2040-B2's ROM. */
const MAGIC = [0x754d, 0x0301];
const BKPT = 0xbe00;
/** subs r3, #1; bne to it. */
const WAIT = [0x3b01, 0xd1fd];
const [BX_LR, B_SELF, CMP_ZERO, BNE_TO_STEP] = [0x4770, 0xe7fe, 0x2800, 0xd1fa];
/** Searches the table r0 for the code r1: ldrh, cmp, beq, adds, cmp, bne to the first, movs, bx; ldrh, bx. */
const LOOKUP = [0x8802, 0x428a, 0xd004, 0x3004, 0x2a00, 0xd1f9, 0x2000, 0x4770, 0x8840, 0x4770];

export const codeOf = (text) => text.charCodeAt(0) | (text.charCodeAt(1) << 8);

/** The ROM's memory, written from beginning to end. The rest is filled with breakpoints of a number that no function has. */
export class RomImage {
  constructor(emptyTrap) {
    this.halfwords = new Uint16Array(ROM_BYTES / 2).fill(BKPT | emptyTrap);
    this.end = FIRST_FREE;
    this.halfwords.set(MAGIC, MAGIC_AND_VERSION / 2);
    this.halfwords[LOOKUP_AT / 2] = this.add(LOOKUP) | 1;
  }

  /** @returns {number} where the half-words begin, aligned to a word */
  add(halfwords) {
    const at = this.end;
    this.halfwords.set(halfwords, at / 2);
    this.end = (at + 2 * halfwords.length + 3) & ~3;
    return at;
  }

  addText(text) {
    const bytes = new TextEncoder().encode(`${text}\0\0`);
    return this.add(new Uint16Array(bytes.buffer.slice(0, bytes.length & ~1)));
  }

  /**
   * A function that begins with a trap and then waits for as long as r3 says. @returns {number} its address, with the
   * Thumb bit
   */
  addStub(trap) {
    return this.add([BKPT | trap, ...WAIT, BX_LR]) | 1;
  }

  /** A function whose second trap and wait repeat until a register is 0. */
  addLoop(checkTrap, stepTrap, register) {
    return this.add([BKPT | checkTrap, BKPT | stepTrap, ...WAIT, CMP_ZERO | (register << 8), BNE_TO_STEP, BX_LR]) | 1;
  }

  /** A function that never returns. */
  addEnd(trap) {
    return this.add([BKPT | trap, B_SELF]) | 1;
  }

  /** A table of pointers at their offsets. */
  addPointers(pointers) {
    const words = new Uint32Array(Math.max(...pointers.keys()) / 4 + 1);
    for (const [offset, pointer] of pointers) words[offset / 4] = pointer;
    return this.add(new Uint16Array(words.buffer));
  }

  setFunctions(byCode) {
    this.halfwords[FUNCTIONS_AT / 2] = this.#addTable(byCode);
  }

  setData(byCode) {
    this.halfwords[DATA_AT / 2] = this.#addTable(byCode);
  }

  #addTable(byCode) {
    return this.add([...[...byCode].flatMap(([code, address]) => [codeOf(code), address]), 0]);
  }
}
