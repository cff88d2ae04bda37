import { Fifo } from './fifo.mjs';
import { IdleLoop } from './idle-loop.mjs';
import { DONE, execute, JUMPED, rotateLeft, SPINNING, STALLED, WAITS_FOR } from './instructions.mjs';
import { PollLoop } from './poll-loop.mjs';
import { ProgramView } from './program-view.mjs';
import { MachineSettings } from './settings.mjs';

const NONE = -1;
const WORD_BITS = 32;
/** Enough for any sequence of register instructions. An endless one is cut off here. */
const MOST_AHEAD = 16;

/**
 * One PIO state machine (datasheet 3.2).
 *
 * It is stepped on the cycles on which it does something that others can see; `next` is the next such cycle. A delay
 * only makes `next` later. A stalled machine has no `next` until something wakes it, nor has one that only jumps to the
 * same instruction for ever, or that only looks at pins, round after round (`IdleLoop`, `PollLoop`). Instructions that use
 * only its own registers are carried out ahead of time. If an instruction jumps to itself and counts a register down, all
 * its rounds are carried out at once. `settle` reverts what
 * is not due yet before anything reads the registers. Times are cycles of the system clock; with a fractional divider
 * they have binary fractions, of which only the whole part counts.
 */
export class StateMachine extends MachineSettings {
  /** @param {import('./block.mjs').PioBlock} block */
  constructor(block, index) {
    super();
    this.block = block;
    this.index = index;
    this.program = new ProgramView();
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
    /** Whether the IRQ instruction that is waiting has set its flag. */
    this.flagRaised = false;
    this.waitsFor = 0;
    this.next = Infinity;
    this.stalledAt = 0;
    this.idleLoop = new IdleLoop();
    this.pollLoop = new PollLoop();
    /** The one in which it goes round, while it does. @type {IdleLoop | PollLoop} */
    this.loop = this.idleLoop;
    /** While the machine is disabled: the time from enabling to the next instruction. */
    this.heldCycles = 1;
    /** Whether instructions have been carried out ahead of time, and the state before them. */
    this.isAhead = false;
    this.before = { next: 0.5, pc: 0, x: 0, y: 0, isr: 0, isrCount: 0, osr: 0, osrCount: 0 };
  }

  step(cycle) {
    this.isAhead = false;
    if (this.waitsFor === WAITS_FOR.look) this.loop.takeRounds(this, (this.next - this.stalledAt) / this.loop.round);
    if (this.program.stale) this.program.update(this.block.memory, this, this.block.sharedPins);
    if (this.injected !== NONE) this.stepInjected(cycle);
    else if (this.isPrivate(this.pc)) this.runAhead();
    else this.stepProgram(cycle);
    if (this.autopull && this.waitsFor === 0) this.refill(cycle);
  }

  stepProgram(cycle) {
    const at = this.pc;
    if (this.goesRound(at, cycle)) {
      this.waitsFor = WAITS_FOR.look;
      this.stall();
      return;
    }
    const outcome = this.carryOut(this.block.memory[at], cycle, true);
    const sideMask = this.program.sideMasks[at];
    if (sideMask !== 0) this.sideSet(sideMask, this.program.sideValues[at]);
    if (outcome === STALLED) {
      this.stall();
      return;
    }
    if (this.program.halts[at] !== 0) {
      this.waitsFor = WAITS_FOR.program;
      this.stall();
      return;
    }
    this.goOn(at, outcome);
    if (this.injected === NONE && this.isPrivate(this.pc)) this.runAhead();
  }

  /** Whether it looks at pins that are as they were, and does nothing else until one of them changes. */
  goesRound(at, cycle) {
    const { program } = this;
    if (program.polls[at] !== 0 && !this.changesSide(at)) return this.pollsOn(at, cycle);
    const pins = program.looks[at];
    if (pins !== 0 && !this.changesSide(at)) {
      this.loop = this.idleLoop;
      return this.idleLoop.comesRound(this, pins, this.block.inputs.at(cycle) & pins);
    }
    this.idleLoop.forget();
    return false;
  }

  /** Whether it is at a jump by a pin's level, and with this level comes back to it after nothing but counting. */
  pollsOn(at, cycle) {
    const pins = 1 << this.jumpPin;
    const levels = this.block.inputs.at(cycle) & pins;
    const round = this.program.rounds[levels === 0 ? 0 : 1][at];
    this.idleLoop.forget();
    this.loop = this.pollLoop;
    return round !== null && this.pollLoop.comesRound(this, round, pins, levels);
  }

  /** Only the delay of the injected instruction counts, not that of the instruction that injected it. */
  stepInjected(cycle) {
    const op = this.injected;
    const outcome = this.carryOut(op, cycle, false);
    this.sideSet(this.sideMaskOf(op), this.sideValueOf(op));
    if (outcome === STALLED) {
      this.injected = op;
      this.stall();
    } else {
      this.next = this.runs ? this.next + this.cyclesOf(op) : Infinity;
    }
  }

  carryOut(op, cycle, fromMemory) {
    this.fromMemory = fromMemory;
    this.injected = NONE;
    this.waitsFor = 0;
    return execute(this, op, cycle);
  }

  /** Continues with the next instruction of the program, at its time. */
  goOn(at, outcome) {
    if (outcome === SPINNING) this.spin(at);
    if (outcome !== JUMPED) this.pc = this.program.follows[at];
    this.next += this.injected === NONE ? this.program.cycles[at] : this.period;
  }

  /** An instruction written to SMx_INSTR is carried out at once, enabled or not; its delay is ignored (datasheet 3.5.7). */
  force(op, cycle) {
    const { waitsFor, flagRaised, next } = this;
    this.flagRaised = false;
    const outcome = this.carryOut(op, cycle, false);
    this.sideSet(this.sideMaskOf(op), this.sideValueOf(op));
    if (outcome === STALLED) {
      this.injected = op;
      this.stalledAt = cycle;
      this.next = this.waitsFor === 0 ? this.tickAfter(cycle) : Infinity;
      return;
    }
    // A jump ends the machine's own stall. After any other instruction the machine continues its stall.
    if (outcome !== JUMPED) Object.assign(this, { waitsFor, flagRaised, next });
    if (this.injected !== NONE || (outcome === JUMPED && this.enabled && waitsFor !== 0)) this.resume(cycle);
    this.wake(WAITS_FOR.program, cycle);
  }

  /** Stops the machine until its condition may be true. Without a condition it tries again on the next tick. */
  stall() {
    this.stalledAt = this.next;
    if (this.waitsFor === 0) this.next += this.period;
    else this.next = (this.waitsFor & WAITS_FOR.level) !== 0 ? this.tickAfter(this.block.inputs.nextChange - 1) : Infinity;
    if (this.waitsFor === WAITS_FOR.look) this.next = Math.min(this.next, this.loop.endsAt);
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

  /** An event for which the machine may be waiting happened on this cycle. The machine tries again on its next tick. */
  wake(what, cycle) {
    if ((this.waitsFor & what) !== 0 && this.runs) this.resume(cycle);
  }

  /** A pin changes, which is seen from the cycle after this one on. */
  inputChanges(pin, cycle) {
    if (this.waitsFor === WAITS_FOR.look && ((this.loop.pins >>> pin) & 1) === 0) return;
    this.wake(WAITS_FOR.level, cycle);
  }

  /** Whether it has an instruction to carry out: it is enabled, or an instruction was forced. */
  get runs() {
    return this.enabled || this.injected !== NONE;
  }

  get stalledOnTx() {
    return this.enabled && this.waitsFor === WAITS_FOR.tx;
  }

  get stalledOnRx() {
    return this.enabled && this.waitsFor === WAITS_FOR.rx;
  }

  /** Whether a forced or injected instruction is waiting. */
  get execStalled() {
    return this.injected !== NONE && this.waitsFor !== 0;
  }

  /** The current instruction. */
  get current() {
    return this.injected === NONE ? this.block.memory[this.pc] : this.injected;
  }

  resume(cycle) {
    this.next = Math.min(this.next, this.tickAfter(cycle));
    this.block.expect(this.next);
  }

  /** The machine's first tick after a cycle, or its first look if it goes round. */
  tickAfter(cycle) {
    const period = this.waitsFor === WAITS_FOR.look ? this.loop.round : this.period;
    const ticks = Math.ceil((cycle + 1 - this.stalledAt) / period);
    return this.stalledAt + Math.max(0, ticks) * period;
  }

  /** Whether a jump to the target would be onto itself. */
  spinsAt(target) {
    return this.fromMemory && target === this.pc;
  }

  /** Carries out all rounds of `jmp x--` or `jmp y--` to itself at once, up to the last. */
  spin(at) {
    const rounds = this.roundsLeft(at);
    this.next += rounds * this.program.cycles[at];
    this.takeRounds(at, rounds + 1);
  }

  countsX(at) {
    return ((this.block.memory[at] >> 5) & 7) === 2;
  }

  roundsLeft(at) {
    return (this.countsX(at) ? this.x : this.y) >>> 0;
  }

  takeRounds(at, rounds) {
    if (this.countsX(at)) this.x = (this.x - rounds) | 0;
    else this.y = (this.y - rounds) | 0;
  }

  /** Carries out instructions that affect only this machine: the next one and those after it. */
  runAhead() {
    this.remember();
    this.fromMemory = true;
    const { memory } = this.block;
    for (let left = MOST_AHEAD; left > 0 && this.isPrivate(this.pc); left--) {
      const at = this.pc;
      this.goOn(at, execute(this, memory[at], 0));
    }
  }

  /** Whether an instruction works on the registers only, and its side-set changes nothing. */
  isPrivate(at) {
    return this.program.privates[at] !== 0 && !this.changesSide(at);
  }

  changesSide(at) {
    const { sideMasks, sideValues } = this.program;
    return ((sideValues[at] ^ this.block.pinValues) & sideMasks[at]) !== 0;
  }

  remember() {
    const { before } = this;
    this.isAhead = true;
    before.next = this.next;
    before.pc = this.pc;
    before.x = this.x;
    before.y = this.y;
    before.isr = this.isr;
    before.isrCount = this.isrCount;
    before.osr = this.osr;
    before.osrCount = this.osrCount;
  }

  /** Reverts what was carried out ahead of this cycle, or makes up for the rounds that were not carried out. */
  settle(cycle) {
    if (this.waitsFor === WAITS_FOR.look) this.leaveLoop(cycle);
    this.idleLoop.forget();
    if (!this.isAhead) return;
    this.isAhead = false;
    Object.assign(this, this.before);
    this.fromMemory = true;
    while (this.next < cycle + 1) this.redo(cycle);
    this.block.expect(this.next);
  }

  /** Goes to the last look up to this cycle, which saw the levels that all rounds saw, and from there to this cycle. */
  leaveLoop(cycle) {
    const { inputs } = this.block;
    const { seen } = inputs;
    const { pins, levels, round } = this.loop;
    this.next = this.tickAfter(cycle) - round;
    this.loop.takeRounds(this, (this.next - this.stalledAt) / round);
    this.waitsFor = 0;
    this.fromMemory = true;
    inputs.seen = (seen & ~pins) | levels;
    while (this.next < cycle + 1) this.redo(cycle);
    inputs.seen = seen;
    this.block.expect(this.next);
  }

  redo(cycle) {
    const at = this.pc;
    const outcome = execute(this, this.block.memory[at], 0);
    const period = this.program.cycles[at];
    const rounds = Math.ceil((cycle + 1 - this.next) / period);
    if (outcome !== SPINNING || rounds > this.roundsLeft(at)) {
      this.goOn(at, outcome);
    } else {
      this.takeRounds(at, rounds);
      this.next += rounds * period;
    }
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

  /** SM_RESTART: discards the current instruction; keeps the program counter, X, Y and OSR. */
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

  /** A new divider, or a restart of its phase. The remaining ticks of a delay follow from the next cycle on. */
  rephase(period, cycle) {
    const ticksLeft = this.next === Infinity ? 0 : Math.ceil((this.next - cycle) / this.period) - 1;
    this.period = period;
    this.stalledAt = cycle + 1;
    if (this.next === Infinity) return;
    this.next = cycle + 1 + ticksLeft * period;
    this.block.expect(this.next);
  }

  /** Joining or separating the FIFOs empties them. */
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

  sideSet(mask, value) {
    if (this.sideDirections) this.block.writeDirections(mask, value);
    else this.block.writePins(mask, value);
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
