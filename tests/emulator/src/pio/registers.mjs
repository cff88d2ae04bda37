import { BasePeripheral } from 'rp2040js';
import { MachineSettings } from './settings.mjs';

const [CTRL, FSTAT, FDEBUG, FLEVEL, TXF0, RXF0] = [0x000, 0x004, 0x008, 0x00c, 0x010, 0x020];
const [IRQ, IRQ_FORCE, INPUT_SYNC_BYPASS, DBG_PADOUT, DBG_PADOE, DBG_CFGINFO] = [0x030, 0x034, 0x038, 0x03c, 0x040, 0x044];
const [INSTR_MEM0, SM0, INTR, IRQ0_INTE, END] = [0x048, 0x0c8, 0x128, 0x12c, 0x144];
/** The distance between the registers of two machines, and the offsets of these registers. */
const SM_BYTES = 0x18;
const [CLKDIV, EXECCTRL, SHIFTCTRL, ADDR, INSTR, PINCTRL] = [0x00, 0x04, 0x08, 0x0c, 0x10, 0x14];
/** The distance between the registers of the two interrupt lines. */
const LINE_BYTES = 0x0c;
const [INTE, INTF] = [0x00, 0x04];
const FIFO_JOINS = 0xc0000000;
const EXEC_STALLED = 0x80000000;
/** 32 instructions, four machines, FIFOs four deep. */
const CONFIGURATION = (32 << 16) | (4 << 8) | 4;

/** A PIO block's registers (datasheet 3.7), on the bus. */
export class PioRegisters extends BasePeripheral {
  constructor(chip, name, block) {
    super(chip, name);
    this.block = block;
    this.clock = chip.clock;
  }

  readUint32(offset) {
    const { block } = this;
    if (offset >= RXF0 && offset < IRQ) return block.read((offset - RXF0) >> 2, this.clock.cycles) >>> 0;
    if (offset >= SM0 && offset < INTR) return this.#readMachine(offset - SM0);
    if (offset >= IRQ0_INTE && offset < END) return this.#readLine(offset - IRQ0_INTE);
    switch (offset) {
      case CTRL:
        return block.bits(({ enabled }) => enabled);
      case FSTAT:
        return this.#fifoStatus();
      case FDEBUG:
        return (block.stalledTx << 24) | (block.overTx << 16) | (block.underRx << 8) | block.stalledRx;
      case FLEVEL:
        return block.machines.reduce((levels, { tx, rx }, index) => levels | (((rx.level << 4) | tx.level) << (8 * index)), 0) >>> 0;
      case IRQ:
        return block.flags;
      case INPUT_SYNC_BYPASS:
        return block.inputs.bypassed >>> 0;
      case DBG_PADOUT:
        return block.pinValues >>> 0;
      case DBG_PADOE:
        return block.pinDirections >>> 0;
      case DBG_CFGINFO:
        return CONFIGURATION;
      case INTR:
        return block.sources;
    }
    // TXF, IRQ_FORCE and the instruction memory can only be written.
    return offset < INTR ? 0 : super.readUint32(offset);
  }

  /** FIFOs are written directly, whichever alias is used, because reading them first would take a word. */
  writeUint32Atomic(offset, value, kind) {
    if (offset >= TXF0 && offset < IRQ) this.writeUint32(offset, value);
    else super.writeUint32Atomic(offset, value, kind);
  }

  writeUint32(offset, value) {
    const { block } = this;
    const { cycles } = this.clock;
    if (offset >= TXF0 && offset < RXF0) return block.write((offset - TXF0) >> 2, value | 0, cycles);
    if (offset >= RXF0 && offset < IRQ) return undefined;
    if (offset >= INSTR_MEM0 && offset < SM0) return this.#writeInstruction((offset - INSTR_MEM0) >> 2, value, cycles);
    if (offset >= SM0 && offset < INTR) return this.#writeMachine(offset - SM0, value, cycles);
    if (offset >= IRQ0_INTE && offset < END) return this.#writeLine(offset - IRQ0_INTE, value);
    switch (offset) {
      case CTRL:
        return this.#control(value, cycles);
      case FDEBUG:
        return this.#clearDebug(this.rawWriteValue);
      case IRQ:
        block.lower(this.rawWriteValue & 0xff);
        return block.commit(cycles);
      case IRQ_FORCE:
        block.raise(this.rawWriteValue & 0xff);
        return block.commit(cycles);
      case INPUT_SYNC_BYPASS:
        block.inputs.bypassed = value | 0;
        return undefined;
    }
    return super.writeUint32(offset, value);
  }

  #fifoStatus() {
    const { block } = this;
    const tx = (block.bits(({ tx }) => tx.empty) << 24) | (block.bits(({ tx }) => tx.full) << 16);
    return tx | (block.bits(({ rx }) => rx.empty) << 8) | block.bits(({ rx }) => rx.full);
  }

  /** A machine that is still stalled sets its bit again at once. */
  #clearDebug(word) {
    const { block } = this;
    block.stalledTx = (block.stalledTx & ~(word >>> 24)) | block.bits((machine) => machine.stalledOnTx);
    block.stalledRx = (block.stalledRx & ~word & 0xf) | block.bits((machine) => machine.stalledOnRx);
    block.overTx &= ~(word >>> 16);
    block.underRx &= ~(word >>> 8);
  }

  #control(word, cycle) {
    const { block } = this;
    control(block, word, cycle);
    if (block.neighbours === null) return;
    const { previous, next } = block.neighbours;
    controlOther(previous, (word >> 16) & 0xf, word, cycle);
    controlOther(next, (word >> 20) & 0xf, word, cycle);
  }

  #writeInstruction(index, word, cycle) {
    this.block.settle(cycle);
    this.block.memory[index] = word;
    this.block.changeProgram(cycle);
  }

  #readMachine(offset) {
    const machine = this.block.machines[Math.floor(offset / SM_BYTES)];
    switch (offset % SM_BYTES) {
      case CLKDIV:
        return machine.clkdiv;
      case EXECCTRL:
        return (machine.execctrl | (machine.execStalled ? EXEC_STALLED : 0)) >>> 0;
      case SHIFTCTRL:
        return machine.shiftctrl >>> 0;
      case PINCTRL:
        return machine.pinctrl >>> 0;
    }
    this.block.settle(this.clock.cycles);
    return offset % SM_BYTES === ADDR ? machine.pc : machine.current;
  }

  #writeMachine(offset, word, cycle) {
    const machine = this.block.machines[Math.floor(offset / SM_BYTES)];
    this.block.settle(cycle);
    this.#setMachine(machine, offset, word, cycle);
    if (offset % SM_BYTES !== INSTR) this.block.changeProgram(cycle);
  }

  #setMachine(machine, offset, word, cycle) {
    switch (offset % SM_BYTES) {
      case CLKDIV:
        machine.clkdiv = word & 0xffffff00;
        return machine.rephase(MachineSettings.periodOf(word), cycle);
      case EXECCTRL:
        return machine.takeExecctrl(word);
      case SHIFTCTRL:
        return this.#shiftControl(machine, word, cycle);
      case PINCTRL:
        return machine.takePinctrl(word);
      case INSTR:
        machine.force(word & 0xffff, cycle);
        this.block.commit(cycle);
    }
    return undefined;
  }

  #shiftControl(machine, word, cycle) {
    const joins = (machine.shiftctrl ^ word) & FIFO_JOINS;
    machine.takeShiftctrl(word);
    if (joins !== 0) this.block.joinFifos(machine, cycle);
  }

  #readLine(offset) {
    const line = Math.floor(offset / LINE_BYTES);
    switch (offset % LINE_BYTES) {
      case INTE:
        return this.block.enabledSources[line];
      case INTF:
        return this.block.forcedSources[line];
      default:
        return this.block.status(line);
    }
  }

  #writeLine(offset, word) {
    const line = Math.floor(offset / LINE_BYTES);
    if (offset % LINE_BYTES === INTE) this.block.enabledSources[line] = word & 0xfff;
    else if (offset % LINE_BYTES === INTF) this.block.forcedSources[line] = word & 0xfff;
    this.block.interrupt();
  }
}

/** CTRL: which machines are enabled, and which restart their state or the phase of their divider. */
function control(block, word, cycle) {
  block.settle(cycle);
  block.machines.forEach((machine, index) => {
    machine.enable(((word >> index) & 1) !== 0, cycle);
    if ((word >> (4 + index)) & 1) machine.restart(cycle);
    if ((word >> (8 + index)) & 1) machine.rephase(machine.period, cycle);
  });
  block.changeProgram(cycle);
}

/** The upper half of an RP2350's CTRL: what the same write does to some machines of a neighbour. To disable goes before to enable. */
function controlOther(block, machines, word, cycle) {
  const [enables, disables, rephases] = [24, 25, 26].map((bit) => ((word >> bit) & 1) !== 0);
  if (machines === 0 || !(enables || disables || rephases)) return;
  const enabled = block.bits((machine) => machine.enabled);
  control(block, (disables ? enabled & ~machines : enables ? enabled | machines : enabled) | (rephases ? machines << 8 : 0), cycle);
}
