import { Fault } from '../fault.mjs';

const [SP, LR, PC] = [13, 14, 15];
const [NMI, HARD_FAULT, PENDSV, SYSTICK] = [2, 3, 14, 15];
const FIRST_INTERRUPT = 16;
const INTERRUPTS = 52;
const EXCEPTIONS = FIRST_INTERRUPT + INTERRUPTS;
/** Lower than any that can be set. */
const LOWEST = 0x100;
/** The RP2350 has four bits of priority. */
const PRIORITY_MASK = 0xf0;
const FRAME_BYTES = 32;
const ALIGNED = 1 << 9;
/** The secure state, no floats, the main stack. */
const [TO_HANDLER, TO_THREAD] = [0xfffffff1 | 0, 0xfffffff9 | 0];

/** Exceptions of a Cortex-M33: which are pending, enabled and active, and how handlers are entered and left (ARMv8-M B3). */
export class Exceptions {
  constructor(core) {
    this.core = core;
    this.pending = new Uint8Array(EXCEPTIONS);
    this.enabled = new Uint8Array(EXCEPTIONS).fill(1, 0, FIRST_INTERRUPT);
    this.priority = new Int16Array(EXCEPTIONS);
    [this.priority[NMI], this.priority[HARD_FAULT]] = [-2, -1];
    /** The lines that hold an interrupt pending. */
    this.lines = new Uint8Array(EXCEPTIONS);
    /** Interrupts that a fault of the test holds back: they stay pending. */
    this.held = new Uint8Array(EXCEPTIONS);
    /** The handlers under way, the innermost last. */
    this.active = [];
  }

  /** The priority at which the core runs. */
  get running() {
    let lowest = LOWEST;
    for (const number of this.active) lowest = Math.min(lowest, this.priority[number]);
    return lowest;
  }

  /** The priority that another must be above. */
  get threshold() {
    const { core } = this;
    const masked = core.PM ? 0 : core.BASEPRI || LOWEST;
    return Math.min(this.running, masked);
  }

  /** Pends an exception or takes it back. */
  pend(number, isPending = true) {
    const isNew = isPending && this.pending[number] === 0;
    this.pending[number] = isPending ? 1 : this.lines[number];
    if (!isPending) return;
    this.core.interruptsUpdated = true;
    if (isNew) this.core.sleep.pended();
  }

  /** A line of a peripheral. While it is asserted its interrupt is pending, unless its handler is under way. */
  setLine(interrupt, isAsserted) {
    const number = FIRST_INTERRUPT + interrupt;
    this.lines[number] = isAsserted ? 1 : 0;
    if (!isAsserted) this.pending[number] = 0;
    else if (!this.active.includes(number)) this.pend(number);
  }

  setPriority(number, value) {
    this.priority[number] = value & PRIORITY_MASK;
    this.core.interruptsUpdated = true;
  }

  enable(number, isEnabled) {
    this.enabled[number] = isEnabled ? 1 : 0;
    if (!isEnabled) return;
    this.core.interruptsUpdated = true;
    this.core.sleep.enabled();
  }

  hold(interrupt, isHeld) {
    this.held[FIRST_INTERRUPT + interrupt] = isHeld ? 1 : 0;
    this.core.interruptsUpdated = true;
    if (!isHeld) this.core.sleep.enabled();
  }

  /** The exception that would be entered at a threshold; 0 if none. Of equal priority the lowest number comes first. */
  next(threshold) {
    let [found, best] = [0, threshold];
    for (let number = NMI; number < EXCEPTIONS; number++) {
      if (this.pending[number] !== 0 && this.enabled[number] !== 0 && this.held[number] === 0 && this.priority[number] < best) {
        [found, best] = [number, this.priority[number]];
      }
    }
    return found;
  }

  /** @returns {boolean} whether a handler is entered */
  enterNext() {
    this.core.interruptsUpdated = false;
    const number = this.next(this.threshold);
    if (number === 0) return false;
    this.core.waiting = false;
    this.core.exceptionEntry(number);
    return true;
  }

  /** Whether a pending exception wakes the core from sleep. WFI ignores whether interrupts are masked. */
  wakes(heedsMask) {
    return this.next(heedsMask ? this.threshold : this.running) !== 0;
  }

  enter(number) {
    const { core } = this;
    const { bus, registers: r } = core;
    const isAligned = (r[SP] & 4) !== 0;
    const frame = (r[SP] - FRAME_BYTES) & ~4;
    const psr = (core.xpsr & ~ALIGNED) | (isAligned ? ALIGNED : 0);
    [r[0], r[1], r[2], r[3], r[12], r[LR], r[PC] & ~1, psr].forEach((word, index) => bus.write32((frame + 4 * index) | 0, word));
    r[SP] = frame;
    r[LR] = this.active.length > 0 ? TO_HANDLER : TO_THREAD;
    this.pending[number] = 0;
    this.active.push(number);
    core.IPSR = number;
    core.it = 0;
    core.exclusive = false;
    core.eventRegistered = true;
    r[PC] = core.chip.readUint32((core.VTOR + 4 * number) >>> 0) & ~1;
    // Another may have become pending meanwhile, of a higher priority.
    core.interruptsUpdated = true;
  }

  leave(value) {
    const { core } = this;
    const { bus, registers: r } = core;
    if (value !== TO_HANDLER && value !== TO_THREAD) throw new Fault(`a return from a handler by 0x${(value >>> 0).toString(16)}, which is not emulated`);
    const number = this.active.pop();
    const frame = r[SP];
    const words = Array.from({ length: 8 }, (_, index) => bus.read32((frame + 4 * index) | 0));
    [r[0], r[1], r[2], r[3], r[12], r[LR], r[PC]] = words;
    const psr = words[7];
    r[SP] = (frame + FRAME_BYTES) | (psr & ALIGNED ? 4 : 0);
    core.xpsr = psr;
    core.exclusive = false;
    core.eventRegistered = true;
    // The line still asks.
    if (this.lines[number] !== 0) this.pending[number] = 1;
    core.interruptsUpdated = true;
    if (this.active.length === 0 ? core.IPSR !== 0 : core.IPSR !== this.active.at(-1)) throw new Fault('a return from a handler to what did not run');
  }

  /** The words of ICSR. */
  get isAnyPending() {
    return this.next(LOWEST + 1) !== 0;
  }

  get systickPending() {
    return this.pending[SYSTICK] !== 0;
  }

  get pendSvPending() {
    return this.pending[PENDSV] !== 0;
  }
}

export { FIRST_INTERRUPT, HARD_FAULT, INTERRUPTS, NMI, PENDSV, SYSTICK };
