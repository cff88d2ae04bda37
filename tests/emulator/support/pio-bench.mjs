import { buildChip } from '../src/chip.mjs';
import { MachineClock } from '../src/clock.mjs';

/** The registers the tests use. */
export const PIO0 = 0x50200000;
export const PIO1 = 0x50300000;
export const DMA = 0x50000000;
export const RAM = 0x20000000;
const GPIO_CTRL = 0x40014004;
export const REG = { ctrl: 0x00, fstat: 0x04, fdebug: 0x08, flevel: 0x0c, txf: 0x10, rxf: 0x20, irq: 0x30, irqForce: 0x34, bypass: 0x38, memory: 0x48, intr: 0x128, inte: 0x12c, ints: 0x134 };
export const SM = { clkdiv: 0xc8, execctrl: 0xcc, shiftctrl: 0xd0, addr: 0xd4, instr: 0xd8, pinctrl: 0xdc };
const SM_BYTES = 0x18;

/** A chip whose core stands still while the test reads and writes registers at any cycle. */
export class PioBench {
  constructor(base = PIO0) {
    this.base = base;
    this.clock = new MachineClock();
    this.clock.core.cycles = 0;
    const nothing = () => {};
    Object.assign(this, buildChip(this.clock, { onWatchdog: nothing, onUartByte: nothing, onWarning: nothing }));
  }

  /** Lets time pass up to and including a cycle. */
  runTo(cycle) {
    this.core.cycles = cycle;
    this.clock.lockstep.catchUp();
  }

  run(cycles) {
    this.runTo(this.core.cycles + cycles);
  }

  read(register) {
    return this.bus.read32((this.base + register) | 0) >>> 0;
  }

  write(register, value) {
    this.bus.write32((this.base + register) | 0, value);
  }

  readAt(address) {
    return this.bus.read32(address | 0) >>> 0;
  }

  writeAt(address, value) {
    this.bus.write32(address | 0, value);
  }

  sm(index, register) {
    return register + index * SM_BYTES;
  }

  load(program, at = 0) {
    program.forEach((word, index) => this.write(REG.memory + 4 * (at + index), word));
  }

  /** Sets a machine up: wrap, side-set and so on, as register words. */
  configure(index, { clkdiv = 0x10000, execctrl = 0x1f000, shiftctrl = 0xc0000, pinctrl = 0 }) {
    this.write(this.sm(index, SM.clkdiv), clkdiv);
    this.write(this.sm(index, SM.execctrl), execctrl);
    this.write(this.sm(index, SM.shiftctrl), shiftctrl);
    this.write(this.sm(index, SM.pinctrl), pinctrl);
  }

  force(index, ...words) {
    for (const word of words) this.write(this.sm(index, SM.instr), word);
  }

  /** Connects a pin to the block, and records its edges: [cycle, level]. */
  watch(pin, noted = true) {
    this.writeAt(GPIO_CTRL + 8 * pin, this.base === PIO0 ? 6 : 7);
    const edges = [];
    if (noted) this.chip.gpio[pin].addListener((state, before) => state <= 1 && before <= 1 && edges.push([this.clock.cycles, state]));
    return edges;
  }

  input(pin, high) {
    this.chip.gpio[pin].padValue |= 0x40;
    this.chip.gpio[pin].setInputValue(high);
  }

  pending(irq) {
    return ((this.core.pendingInterrupts >>> irq) & 1) !== 0;
  }
}
