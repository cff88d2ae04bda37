import { PRIVATE } from './privacy.mjs';

const PROGRAM_WORDS = 32;

/** The program as one machine executes it: each instruction decoded with the machine's settings, once and not at every step. */
export class ProgramView {
  constructor() {
    /** The address of the next instruction, wrap included. */
    this.follows = new Uint8Array(PROGRAM_WORDS);
    /** Cycles of each instruction, delay included. */
    this.cycles = new Float64Array(PROGRAM_WORDS);
    /** The pins that side-set writes, and their levels. */
    this.sideMasks = new Int32Array(PROGRAM_WORDS);
    this.sideValues = new Int32Array(PROGRAM_WORDS);
    /** Whether the instruction affects only its own machine, provided that its side-set changes nothing. */
    this.privates = new Uint8Array(PROGRAM_WORDS);
    this.stale = true;
  }

  /**
   * @param {Uint16Array} memory
   * @param {import('./settings.mjs').MachineSettings} settings
   * @param {number} sharedPins pins that other machines write too
   */
  update(memory, settings, sharedPins) {
    this.stale = false;
    const alone = !settings.autopull && !settings.autopush && !settings.sideDirections && (settings.sideMask & sharedPins) === 0;
    memory.forEach((op, at) => {
      this.follows[at] = at === settings.wrapTop ? settings.wrapBottom : (at + 1) & (PROGRAM_WORDS - 1);
      this.cycles[at] = settings.cyclesOf(op);
      this.sideMasks[at] = settings.sideMaskOf(op);
      this.sideValues[at] = settings.sideValueOf(op) & this.sideMasks[at];
      this.privates[at] = alone ? PRIVATE[op] : 0;
    });
  }
}
