import { Fault } from '../fault.mjs';
import { WAITS_FOR } from './instructions.mjs';
import { Inputs } from './inputs.mjs';
import { StateMachine } from './state-machine.mjs';

const MACHINES = 4;
const PROGRAM_WORDS = 32;
const GPIOS = 0x3fffffff;
/** The flags that reach the interrupt lines: the first four. */
const FLAGS_TO_CORE = 0xf;
const FIFO_SOURCES = 0xff;
/** A GPIO's FUNCSEL for the first block. */
const FIRST_FUNCTION_SELECT = 6;
/** Bits of a flag's number: it is relative to the machine, or, with bit 3, of a neighbour, which is the next block if bit 4 is set too. */
const [NEIGHBOURS, RELATIVE, NEXT] = [8, 16, 24];

/**
 * A PIO block (datasheet 3): four state machines, their shared program, flags and pins.
 *
 * All machines see the flags as they were before the cycle, and the pins change when all machines are done. If several
 * write a pin, the one with the highest number wins.
 */
export class PioBlock {
  /**
   * @param {object} chip
   * @param {number} index 0 or 1, and 2 on an RP2350
   * @param {{irq: number, lockstep: import('../lockstep.mjs').Lockstep}} wiring the first of its two interrupt lines
   */
  constructor(chip, index, { irq, lockstep }) {
    this.chip = chip;
    this.irq = irq;
    this.lockstep = lockstep;
    this.functionSelect = FIRST_FUNCTION_SELECT + index;
    this.firstRequest = index * 2 * MACHINES;
    this.memory = new Uint16Array(PROGRAM_WORDS);
    this.inputs = new Inputs();
    this.machines = Array.from({ length: MACHINES }, (_, number) => new StateMachine(this, number));
    this.next = Infinity;
    /** FDEBUG's sticky bits, one bit per machine. */
    this.stalledTx = 0;
    this.stalledRx = 0;
    this.overTx = 0;
    this.underRx = 0;
    this.flags = 0;
    this.raised = 0;
    this.lowered = 0;
    /** On an RP2350 the blocks before and after it, in a ring. @type {{previous: PioBlock, next: PioBlock} | null} */
    this.neighbours = null;
    // The levels and directions that the block gives the GPIOs with its FUNCSEL, and those last shown on the pins.
    // rp2040js reads the first two.
    this.pinValues = 0;
    this.pinDirections = 0;
    this.shownValues = 0;
    this.shownDirections = 0;
    /** Pins that more than one enabled machine may write. */
    this.sharedPins = 0;
    this.enabledSources = [0, 0];
    this.forcedSources = [0, 0];
    this.onRequest = () => {};
  }

  /** Steps the machines that are due on this cycle. */
  tick(cycle) {
    const end = cycle + 1;
    const { machines } = this;
    this.next = Infinity;
    for (let index = 0; index < MACHINES; index++) {
      const machine = machines[index];
      if (machine.next < end) machine.step(cycle);
      if (machine.next < this.next) this.next = machine.next;
    }
    this.commit(cycle);
  }

  /** Something is due on this cycle, which may be earlier than expected so far. */
  expect(cycle) {
    if (cycle >= this.next) return;
    this.next = cycle;
    this.lockstep.expect(cycle);
  }

  /** Makes the effects of the cycle visible: first the flags, then the pins. */
  commit(cycle) {
    if ((this.raised | this.lowered) !== 0) this.#commitFlags(cycle);
    const changed = (this.pinValues ^ this.shownValues) | (this.pinDirections ^ this.shownDirections);
    if (changed !== 0) this.#showPins(changed & GPIOS);
  }

  raise(bit) {
    this.raised |= bit;
  }

  lower(bit) {
    this.lowered |= bit;
  }

  /** The flag that an instruction of a machine means: its block, and its bit. */
  flag(machine, index) {
    const block = this.neighbours !== null && (index & NEIGHBOURS) !== 0 ? this.#neighbour(index) : this;
    const isRelative = block === this && (index & RELATIVE) !== 0;
    return { block, bit: 1 << (isRelative ? (index & 4) | ((index + machine.index) & 3) : index & 7) };
  }

  /**
   * All machines see a neighbour's flags too as they were before the cycle. So the block must be visited before its neighbour, whose
   * flags change at the end of its visit: of the next block after the last, which is the first, that is so.
   */
  #neighbour(index) {
    const { next } = this.neighbours;
    if ((index & NEXT) !== NEXT || next.functionSelect > this.functionSelect) throw new Fault('only the last PIO block may name flags of a neighbour, those of the next: the others are not emulated');
    return next;
  }

  /** A machine of this block raises a flag, here or in a neighbour. */
  raiseIn(block, bit, cycle) {
    block.raise(bit);
    if (block !== this) block.expect(cycle);
  }

  lowerIn(block, bit, cycle) {
    block.lower(bit);
    if (block !== this) block.expect(cycle);
  }

  #commitFlags(cycle) {
    this.flags = (this.flags & ~this.lowered) | this.raised;
    this.raised = 0;
    this.lowered = 0;
    for (const machine of this.machines) machine.wake(WAITS_FOR.irq, cycle);
    for (const machine of this.neighbours?.previous.machines ?? []) machine.wake(WAITS_FOR.irq, cycle);
    this.interrupt();
  }

  writePins(mask, value) {
    this.pinValues = (this.pinValues & ~mask) | (value & mask);
  }

  writeDirections(mask, value) {
    this.pinDirections = (this.pinDirections & ~mask) | (value & mask);
  }

  #showPins(changed) {
    this.shownValues = this.pinValues;
    this.shownDirections = this.pinDirections;
    for (let left = changed; left !== 0; left &= left - 1) this.#showPin(31 - Math.clz32(left & -left));
  }

  /** Like `checkForUpdates` of rp2040js, but faster for a pin that is simply the block's output. */
  #showPin(index) {
    const pin = this.chip.gpio[index];
    if (pin.faulty || pin.ctrl !== this.functionSelect || ((this.pinDirections >>> index) & 1) === 0) {
      pin.checkForUpdates();
      return;
    }
    const level = (this.pinValues >>> index) & 1;
    const { lastValue } = pin;
    if (level === lastValue) return;
    pin.lastValue = level;
    for (const listener of pin.listeners) listener(level, lastValue);
    pin.follow(level === 1);
  }

  /** The level at an input changes. */
  inputChanged(pin, high, cycle) {
    const seenAt = this.inputs.change(pin, high, cycle);
    if (seenAt === Infinity) return;
    for (let index = 0; index < MACHINES; index++) this.machines[index].inputChanges(pin, seenAt - 1);
  }

  /** Brings the registers of the machines to the state of this cycle. */
  settle(cycle) {
    for (const machine of this.machines) machine.settle(cycle);
  }

  /** A machine's FIFOs are joined or separated, which empties them. */
  joinFifos(machine, cycle) {
    machine.joinFifos();
    machine.wake(WAITS_FOR.rx, cycle);
    this.txPopped(machine.index, cycle);
  }

  /** Called after a change of the program or of settings. */
  changeProgram(cycle) {
    let seen = 0;
    this.sharedPins = 0;
    for (const machine of this.machines) {
      machine.program.stale = true;
      machine.wake(WAITS_FOR.program, cycle);
      if (!machine.enabled) continue;
      this.sharedPins |= seen & machine.pins;
      seen |= machine.pins;
    }
  }

  txPopped(index, cycle) {
    this.onRequest(this.firstRequest + index, cycle);
    this.#fifoMoved();
  }

  rxPushed(index, cycle) {
    this.onRequest(this.firstRequest + MACHINES + index, cycle);
    this.#fifoMoved();
  }

  /** Whether the DMA may move a word: room in a TX FIFO (the first four requests), or a word in an RX FIFO. */
  requests(number) {
    const machine = this.machines[number & (MACHINES - 1)];
    return number < MACHINES ? !machine.tx.full : !machine.rx.empty;
  }

  write(index, word, cycle) {
    if (!this.machines[index].write(word, cycle)) this.overTx |= 1 << index;
    this.#fifoMoved();
  }

  read(index, cycle) {
    const machine = this.machines[index];
    if (machine.rx.empty) {
      this.underRx |= 1 << index;
      return 0;
    }
    const word = machine.read(cycle);
    this.#fifoMoved();
    return word;
  }

  /** A bit mask with one bit per machine, set where `test` holds. */
  bits(test) {
    return this.machines.reduce((bits, machine, index) => bits | (test(machine) ? 1 << index : 0), 0);
  }

  /** INTR: one bit each for flags 3 to 0, TX FIFOs with room, and RX FIFOs with words. */
  get sources() {
    return ((this.flags & FLAGS_TO_CORE) << 8) | (this.bits(({ tx }) => !tx.full) << 4) | this.bits(({ rx }) => !rx.empty);
  }

  status(line) {
    return (this.sources & this.enabledSources[line]) | this.forcedSources[line];
  }

  /** Sets both interrupt lines according to their sources. */
  interrupt() {
    this.chip.setInterrupt(this.irq, this.status(0) !== 0);
    this.chip.setInterrupt(this.irq + 1, this.status(1) !== 0);
  }

  #fifoMoved() {
    if (((this.enabledSources[0] | this.enabledSources[1]) & FIFO_SOURCES) !== 0) this.interrupt();
  }
}
