import { BasePeripheral } from 'rp2040js';

const [DIRECT_CSR, DIRECT_RX, M0_TIMING] = [0x00, 0x08, 0x0c];
/** The interface to flash is never busy, and has sent all. */
const READY = (1 << 11) | (1 << 16);
/**
 * Cycles for a word of flash that is not in the cache, after the ROM's set-up: command EB by one line (8 clocks), address and mode by
 * four (8), waiting (4), data by four (8), with a divider of 3. That the ROM takes these is an assumption, and so is what a miss costs.
 */
const WORD_CYCLES = 3 * (8 + 8 + 4 + 8);
/** After `flash_enter_cmd_xip` (command 03, one line). */
const SLOW_WORD_CYCLES = 3 * 64;

/** The RP2350's interface to flash, as far as the ROM and what it leaves in the boot RAM use it. */
export class Qmi extends BasePeripheral {
  /** @param {() => void} onChange */
  constructor(chip, name, onChange) {
    super(chip, name);
    this.onChange = onChange;
    this.words = new Map();
    this.showsFlash = true;
    this.wordCycles = WORD_CYCLES;
  }

  /** Sets the interface up like the ROM: for plain commands, or to show flash. */
  set({ showsFlash }) {
    this.showsFlash = showsFlash;
    this.wordCycles = SLOW_WORD_CYCLES;
    this.onChange();
  }

  readUint32(offset) {
    if (offset === DIRECT_CSR) return READY;
    return offset === DIRECT_RX ? 0 : (this.words.get(offset) ?? 0);
  }

  writeUint32(offset, value) {
    this.words.set(offset, value);
    if (offset !== M0_TIMING) return;
    this.showsFlash = true;
    this.wordCycles = WORD_CYCLES;
    this.onChange();
  }
}

/**
 * What the ROM leaves in the boot RAM: a function that shows flash again as it was when the program started. This one writes the
 * timing of the interface, which stands for all of it: ldr r0, the interface; str r0, [r0, #M0_TIMING]; bx lr.
 */
export const XIP_SETUP = [(0x60c0 << 16) | 0x4801, 0xbf004770 | 0, 0x400d0000];
