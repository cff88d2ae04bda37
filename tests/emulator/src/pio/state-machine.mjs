import { Fifo } from './fifo.mjs';
import { DONE, execute, JUMPED, rotateLeft, SPINNING, STALLED, WAITS_FOR } from './instructions.mjs';
import { MachineSettings } from './settings.mjs';

const NONE = -1;
const WORD_BITS = 32;

/**
 * One PIO state machine (datasheet 3.2).
 *
 * It is stepped on the cycles on which it does something: `next` says when. A delay is a later `next`, a stalled machine
 * has none until somebody wakes it, and a jump onto itself that counts a register down is taken in one go. Times are
 * cycles of the system clock; with a fractional divider they have binary fractions, of which the whole part counts.
 */
export class StateMachine extends MachineSettings {
  /** @param {import('./block.mjs').PioBlock} block */
  constructor(block, index) {
    super();
    this.block = block;
    this.index = index;
    this.tx = new Fifo();
    this.rx = new Fifo();
    this.enabled = false;
    this.pc = 0;
    this.x = 0;
    this.y = 0;
    this.isr = 0;
    this.isrCount = 0;
    this.osr = 0;
    this.osrCount = WORD_BITS;
    /** An instruction to carry out before the one at `pc`: from OUT EXEC, MOV EXEC, or a forced one that stalled. */
    this.injected = NONE;
    /** Whether the instruction under way comes from the memory. */
    this.fromMemory = true;
    /** Whether the IRQ instruction that waits has set its flag. */
    this.flagRaised = false;
    this.waitsFor = 0;
    this.next = Infinity;
    this.stalledAt = 0;
    /** While disabled: how long after enabling the machine goes on. */
    this.heldCycles = 1;
    this.spinCount = 0;
  }

  step(cycle) {
    const op = this.current;
    const outcome = this.carryOut(op, cycle);
    if (outcome === STALLED) {
      this.stall(op);
      return;
    }
    if (outcome === SPINNING) this.spin(op);
    if (outcome !== JUMPED && this.fromMemory) this.pc = this.pc === this.wrapTop ? this.wrapBottom : (this.pc + 1) & 31;
    // An instruction that brings in another one has no delay of its own.
    const ticks = this.injected === NONE ? 1 + ((op >> 8) & this.delayMask) : 1;
    this.next = this.runs ? this.next + ticks * this.period : Infinity;
    if (this.autopull) this.refill(cycle);
  }

  carryOut(op, cycle) {
    this.fromMemory = this.injected === NONE;
    this.injected = NONE;
    this.waitsFor = 0;
    this.spinCount = 0;
    const outcome = execute(this, op, cycle);
    if (this.sideMask !== 0) this.sideSet((op >> 8) & 31);
    return outcome;
  }

  /** An instruction written to SMx_INSTR: at once, enabled or not; its delay is ignored (datasheet 3.5.7). */
  force(op, cycle) {
    const { waitsFor, flagRaised, next } = this;
    this.flagRaised = false;
    this.injected = op;
    const outcome = this.carryOut(op, cycle);
    if (outcome === STALLED) {
      this.injected = op;
      this.stalledAt = cycle;
      this.next = this.waitsFor === 0 ? this.tickAfter(cycle) : Infinity;
      return;
    }
    // A jump ends the machine's own stall; after anything else it goes on with what it was at.
    if (outcome !== JUMPED) Object.assign(this, { waitsFor, flagRaised, next });
    if (this.injected !== NONE || (outcome === JUMPED && this.enabled && waitsFor !== 0)) this.resume(cycle);
  }

  /** Parks the machine until what it waits for may have come; without such a thing it tries again at once. */
  stall(op) {
    if (!this.fromMemory) this.injected = op;
    this.stalledAt = this.next;
    if (this.waitsFor === 0) this.next += this.period;
    else this.next = this.waitsFor === WAITS_FOR.pin ? this.tickAfter(this.block.inputs.nextChange - 1) : Infinity;
  }

  stallOn(what) {
    this.waitsFor = what;
    return STALLED;
  }

  stallOnEmptyTx() {
    if (this.enabled) this.block.stalledTx |= 1 << this.index;
    return this.stallOn(WAITS_FOR.tx);
  }

  stallOnFullRx() {
    if (this.enabled) this.block.stalledRx |= 1 << this.index;
    return this.stallOn(WAITS_FOR.rx);
  }

  /** Something happened on the cycle that the machine may be waiting for: it tries again on its next tick. */
  wake(what, cycle) {
    if ((this.waitsFor & what) !== 0 && this.runs) this.resume(cycle);
  }

  /** Whether it has something to carry out: enabled, or an instruction forced on it. */
  get runs() {
    return this.enabled || this.injected !== NONE;
  }

  get stalledOnTx() {
    return this.enabled && this.waitsFor === WAITS_FOR.tx;
  }

  get stalledOnRx() {
    return this.enabled && this.waitsFor === WAITS_FOR.rx;
  }

  /** Whether a forced or brought-in instruction is waiting. */
  get execStalled() {
    return this.injected !== NONE && this.waitsFor !== 0;
  }

  /** The instruction at hand. */
  get current() {
    return this.injected === NONE ? this.block.memory[this.pc] : this.injected;
  }

  resume(cycle) {
    this.next = Math.min(this.next, this.tickAfter(cycle));
    this.block.expect(this.next);
  }

  /** The machine's first tick after a cycle. */
  tickAfter(cycle) {
    const ticks = Math.ceil((cycle + 1 - this.stalledAt) / this.period);
    return this.stalledAt + Math.max(0, ticks) * this.period;
  }

  /** Whether a jump to the target would be onto itself. */
  spinsAt(target) {
    return this.fromMemory && target === this.pc;
  }

  /** Takes all rounds of `jmp x--` or `jmp y--` onto itself at once. */
  spin(op) {
    const countsX = ((op >> 5) & 7) === 2;
    this.spinCount = (countsX ? this.x : this.y) >>> 0;
    this.spinsX = countsX;
    this.spinStart = this.next;
    this.spinPeriod = (1 + ((op >> 8) & this.delayMask)) * this.period;
    this.spinPc = this.pc;
    if (countsX) this.x = -1;
    else this.y = -1;
    this.next += this.spinCount * this.spinPeriod;
  }

  /** Takes back the rounds that are not over, so that the registers are those of this cycle. */
  settle(cycle) {
    const rounds = Math.ceil((cycle + 1 - this.spinStart) / this.spinPeriod);
    if (this.spinCount === 0 || rounds > this.spinCount) return;
    const left = (this.spinCount - rounds) | 0;
    if (this.spinsX) this.x = left;
    else this.y = left;
    this.pc = this.spinPc;
    this.next = this.spinStart + rounds * this.spinPeriod;
    this.spinCount = 0;
    this.block.expect(this.next);
  }

  enable(enabled, cycle) {
    if (enabled === this.enabled) return;
    this.enabled = enabled;
    if (enabled) {
      this.next = this.stalledAt = cycle + this.heldCycles;
      this.block.expect(this.next);
    } else {
      this.heldCycles = this.next === Infinity ? 1 : this.next - cycle;
      this.next = Infinity;
    }
  }

  /** SM_RESTART: forgets what is under way, keeps the program counter, X, Y and OSR. */
  restart(cycle) {
    this.isr = 0;
    this.isrCount = 0;
    this.osrCount = WORD_BITS;
    this.injected = NONE;
    this.flagRaised = false;
    this.waitsFor = 0;
    this.heldCycles = 1;
    this.next = this.enabled ? cycle + 1 : Infinity;
    this.block.expect(this.next);
  }

  /** A new divider, or its phase begun anew: the ticks left of a delay follow from the next cycle on. */
  rephase(period, cycle) {
    const ticksLeft = this.next === Infinity ? 0 : Math.ceil((this.next - cycle) / this.period) - 1;
    this.period = period;
    this.stalledAt = cycle + 1;
    if (this.next === Infinity) return;
    this.next = cycle + 1 + ticksLeft * period;
    this.block.expect(this.next);
  }

  /** Joining or parting the FIFOs empties them. */
  joinFifos() {
    this.tx.resize(this.joinsTx ? 8 : this.joinsRx ? 0 : 4);
    this.rx.resize(this.joinsRx ? 8 : this.joinsTx ? 0 : 4);
  }

  get status() {
    return (this.statusOfRx ? this.rx : this.tx).level < this.statusLevel ? -1 : 0;
  }

  /** A word arrives in the TX FIFO. @returns {boolean} whether it found room */
  write(word, cycle) {
    if (this.tx.full) return false;
    this.tx.push(word);
    if (this.autopull && this.enabled && this.waitsFor !== WAITS_FOR.tx) this.refill(cycle);
    this.wake(WAITS_FOR.tx, cycle);
    return true;
  }

  /** Autopull in the background: an empty OSR takes the next word as soon as there is one. */
  refill(cycle) {
    if (this.osrCount >= this.pullThreshold && !this.tx.empty) this.pullOsr(cycle);
  }

  pullOsr(cycle) {
    this.osr = this.tx.pop();
    this.osrCount = 0;
    this.block.txPopped(this.index, cycle);
  }

  pushIsr(cycle) {
    this.rx.push(this.isr);
    this.dropIsr();
    this.block.rxPushed(this.index, cycle);
  }

  dropIsr() {
    this.isr = 0;
    this.isrCount = 0;
  }

  /** The core or the DMA takes a word from the RX FIFO. */
  read(cycle) {
    const word = this.rx.pop();
    this.wake(WAITS_FOR.rx, cycle);
    return word;
  }

  sideSet(field) {
    if (this.sideOptional && (field & 16) === 0) return;
    const value = rotateLeft(field >> this.delayBits, this.sideBase);
    if (this.sideDirections) this.block.writeDirections(this.sideMask, value);
    else this.block.writePins(this.sideMask, value);
  }

  outPins(value) {
    if (this.outEnabled(value)) this.block.writePins(this.outMask, rotateLeft(value, this.outBase));
  }

  outDirections(value) {
    if (this.outEnabled(value)) this.block.writeDirections(this.outMask, rotateLeft(value, this.outBase));
  }

  setPins(value) {
    this.block.writePins(this.setMask, rotateLeft(value, this.setBase));
  }

  setDirections(value) {
    this.block.writeDirections(this.setMask, rotateLeft(value, this.setBase));
  }
}
