import { rotateLeft } from './instructions.mjs';
import { polling } from './polling.mjs';
import { PRIVATE } from './privacy.mjs';

const PROGRAM_WORDS = 32;
/** The bits of an instruction for its delay and side-set. Without them, an unconditional jump is its target. */
const DELAY_AND_SIDE = 0x1f00;
/** The upper bits of IN PINS, without delay and side-set. */
const IN_PINS = 0x4000 >> 5;
const ALL_PINS = -1;

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
    /** Whether the instruction is a jump to itself that nothing ends but a change of the program, or an instruction forced. */
    this.halts = new Uint8Array(PROGRAM_WORDS);
    /** The pins whose levels the instruction reads, a bit each, if it affects only its own machine otherwise. */
    this.looks = new Int32Array(PROGRAM_WORDS);
    /** For jumps by a pin's level, the rounds that only count and come back here: while the pin is low, and while it is high. */
    this.rounds = [new Array(PROGRAM_WORDS).fill(null), new Array(PROGRAM_WORDS).fill(null)];
    /** Whether the instruction begins such a round, provided that its side-set changes nothing. */
    this.polls = new Uint8Array(PROGRAM_WORDS);
    this.stale = true;
  }

  /**
   * @param {Uint16Array} memory
   * @param {import('./settings.mjs').MachineSettings} settings
   * @param {number} sharedPins pins that other machines write too
   */
  update(memory, settings, sharedPins) {
    this.stale = false;
    const sideAlone = !settings.sideDirections && (settings.sideMask & sharedPins) === 0;
    const alone = !settings.autopull && !settings.autopush && sideAlone;
    // With autopull, the FIFO could be emptied on the way.
    const mayPoll = !settings.autopull && sideAlone;
    memory.forEach((op, at) => {
      this.follows[at] = at === settings.wrapTop ? settings.wrapBottom : (at + 1) & (PROGRAM_WORDS - 1);
      this.cycles[at] = settings.cyclesOf(op);
      this.sideMasks[at] = settings.sideMaskOf(op);
      this.sideValues[at] = settings.sideValueOf(op) & this.sideMasks[at];
      this.halts[at] = alone && (op & ~DELAY_AND_SIDE) === at && this.cycles[at] === settings.period ? 1 : 0;
      this.privates[at] = alone && this.halts[at] === 0 ? PRIVATE[op] : 0;
      this.looks[at] = alone ? pinsRead(op, settings.inBase) : 0;
    });
    memory.forEach((_, at) => this.#findRounds(memory, mayPoll, at));
  }

  #findRounds(memory, mayPoll, at) {
    this.rounds.forEach((rounds, level) => (rounds[at] = mayPoll ? polling(memory, this, at, level === 1) : null));
    this.polls[at] = this.rounds.some((rounds) => rounds[at] !== null) ? 1 : 0;
  }
}

/** The pins that IN PINS reads. */
function pinsRead(op, inBase) {
  if ((op & ~DELAY_AND_SIDE) >> 5 !== IN_PINS) return 0;
  const bits = op & 31;
  return bits === 0 ? ALL_PINS : rotateLeft((1 << bits) - 1, inBase);
}
