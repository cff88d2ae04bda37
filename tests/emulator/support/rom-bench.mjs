import { buildChip } from '../src/chip.mjs';
import { MachineClock } from '../src/clock.mjs';
import { run } from '../src/core.mjs';
import { codeOf } from '../src/rom/image.mjs';

const RAM = 0x20000000;
/** Where a call returns to, and the stack. */
export const RETURN = RAM + 0x100;
export const STACK = RAM + 0x4000;
const [TABLE_OF_FUNCTIONS, TABLE_OF_DATA, LOOKUP] = [0x14, 0x16, 0x18];
const LONGEST_CYCLES = 1e9;

/** A chip without firmware, whose ROM the test calls as firmware does: through its tables. */
export class RomBench {
  constructor() {
    this.clock = new MachineClock();
    this.clock.core.cycles = 0;
    const nothing = () => {};
    Object.assign(this, buildChip(this.clock, { onWatchdog: nothing, onUartByte: nothing, onWarning: nothing }));
  }

  /** Sets a call up: arguments in r0 to r3. */
  enter(address, args) {
    this.core.registers.fill(0);
    Object.assign(this.bus.registers, { ...args, 13: STACK, 14: RETURN | 1, 15: address & ~1 });
    this.started = this.core.cycles;
  }

  /** Runs until the call has returned. */
  finish() {
    const { core, bus, clock } = this;
    const limit = core.cycles + LONGEST_CYCLES;
    while (bus.registers[15] !== RETURN && core.cycles < limit) {
      clock.fireDue();
      const fault = run(core, bus, clock, core.cycles + 1);
      if (fault !== null) throw fault;
    }
    this.took = core.cycles - this.started;
    return bus.registers[0];
  }

  /** Calls a function. @returns {number} r0 */
  call(address, ...args) {
    this.enter(address, args);
    return this.finish();
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
}
