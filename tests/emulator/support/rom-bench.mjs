import { buildChip } from '../src/chip.mjs';
import { MachineClock } from '../src/clock.mjs';
import { run } from '../src/core.mjs';
import { codeOf } from '../src/rom/image.mjs';

export const RAM = 0x20000000;
/** A call returns to a WFI. */
const RETURN = RAM + 0x100;
const STACK = RAM + 0x4000;
const VECTORS = RAM + 0x200;
const [WFI, WFI_CYCLES] = [0xbf30, 2];
const [TABLE_OF_FUNCTIONS, TABLE_OF_DATA, LOOKUP] = [0x14, 0x16, 0x18];
const LONGEST_CYCLES = 1e9;
const IRQ = 26;

/** A chip without firmware. A test calls its ROM like firmware, through the ROM's tables. */
export class RomBench {
  constructor() {
    this.clock = new MachineClock();
    this.clock.core.cycles = 0;
    this.bootsels = [];
    const nothing = () => {};
    Object.assign(this, buildChip(this.clock, { onWatchdog: nothing, onUartByte: nothing, onWarning: nothing, onBootsel: (...hints) => this.bootsels.push(hints) }));
    this.core.VTOR = VECTORS;
    this.load(RETURN, [WFI]);
  }

  load(address, halfwords) {
    this.bus.ram16.set(halfwords, (address - RAM) / 2);
  }

  /** Calls a function. `took` is then the number of cycles from its entry to its return. @returns {number} r0 */
  call(address, ...args) {
    const { core, bus, clock } = this;
    core.registers.fill(0);
    Object.assign(bus.registers, { ...args, 13: STACK, 14: RETURN | 1, 15: address & ~1 });
    core.waiting = false;
    const started = core.cycles;
    while (!core.waiting && core.cycles < started + LONGEST_CYCLES) {
      clock.fireDue();
      const fault = run(core, bus, clock, started + LONGEST_CYCLES);
      if (fault !== null) throw fault;
    }
    this.took = core.cycles - started - WFI_CYCLES;
    return bus.registers[0];
  }

  /** Makes an interrupt come after `cycles` cycles. Its handler runs this code, in RAM by default. */
  interruptIn(cycles, handler, vectors = VECTORS) {
    const { core, clock } = this;
    const at = VECTORS + 0x100;
    this.load(at, handler);
    this.bus.ram32[(VECTORS - RAM) / 4 + 16 + IRQ] = at | 1;
    core.VTOR = vectors;
    core.enabledInterrupts = 1 << IRQ;
    clock.createAlarm(() => core.setInterrupt(IRQ, true)).scheduleAt(core.cycles + cycles);
  }

  lookup(table, code) {
    return this.call(this.bus.read16(LOOKUP), this.bus.read16(table), codeOf(code));
  }

  functionAt(code) {
    return this.lookup(TABLE_OF_FUNCTIONS, code);
  }

  dataAt(code) {
    return this.lookup(TABLE_OF_DATA, code);
  }

  /** The function at an offset of a table of floats ('SF') or doubles ('SD'). */
  soft(table, offset) {
    return this.bus.read32(this.dataAt(table) + offset);
  }

  text(address) {
    const bytes = [];
    for (let at = address; this.bus.read8(at) !== 0; at++) bytes.push(this.bus.read8(at));
    return String.fromCharCode(...bytes);
  }
}
