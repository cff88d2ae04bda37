import { NOWHERE, readCycles, writeCycles } from './bus.mjs';
import { alu, addWithCarry } from './alu.mjs';
import { highRegisters, loadStoreRegister, miscellaneous, wide } from './instructions.mjs';
import { holds, untilFault } from './thumb.mjs';

/** ARM's figure for a Cortex-M0+ with no wait states: 15 cycles from the interrupt to its handler's first instruction. */
const EXCEPTION_ENTRY_CYCLES = 15;
const [SP, PC] = [13, 15];

/**
 * Runs rp2040js's core until `limit`, the clock's next alarm, or sleep, whichever comes first, with PIO and DMA at its side.
 *
 * The state (registers, flags, exceptions) stays rp2040js's; this replaces its `executeInstruction`, a chain of some
 * eighty comparisons, by one switch on the instruction's first five bits. It is about three times as fast, charges
 * exception entry and return, and sets the flags of ADCS, SBCS and shifts as the architecture says.
 *
 * @returns {import('./fault.mjs').Fault | null} what stopped it, if an instruction could not be carried out
 */
export function run(core, bus, clock, limit) {
  return untilFault(runOn, core, bus, clock, limit);
}

function runOn(core, bus, clock, limit) {
  const r = bus.registers;
  const { lockstep, profile } = clock;
  while (core.cycles < clock.next && core.cycles < limit && !core.waiting) {
    if (core.interruptsUpdated && core.checkForInterrupts()) core.cycles += EXCEPTION_ENTRY_CYCLES;
    const pc = r[PC];
    const since = core.cycles;
    bus.dataAddress = NOWHERE;
    const op = bus.fetch(pc);
    r[PC] = pc + 2;
    core.cycles += 1;
    execute(core, bus, r, op);
    if (profile !== null) profile.add(pc, core.cycles - since, core.cycles);
    if (lockstep.next <= core.cycles) lockstep.catchUp();
  }
}

function execute(core, bus, r, op) {
  const low = op & 7;
  const middle = (op >> 3) & 7;
  const high = (op >> 8) & 7;
  switch (op >> 11) {
    case 0: // LSLS and MOVS
      return shiftLeft(core, r, low, r[middle], (op >> 6) & 31);
    case 1: // LSRS
      return shiftRight(core, r, low, r[middle], (op >> 6) & 31 || 32, false);
    case 2: // ASRS
      return shiftRight(core, r, low, r[middle], (op >> 6) & 31 || 32, true);
    case 3: {
      // ADDS and SUBS of a register or a 3-bit number
      const operand = op & 0x400 ? (op >> 6) & 7 : r[(op >> 6) & 7];
      r[low] = op & 0x200 ? addWithCarry(core, r[middle], ~operand, 1) : addWithCarry(core, r[middle], operand, 0);
      return;
    }
    case 4: // MOVS
      r[high] = op & 0xff;
      core.N = false;
      core.Z = (op & 0xff) === 0;
      return;
    case 5: // CMP
      addWithCarry(core, r[high], ~(op & 0xff), 1);
      return;
    case 6: // ADDS
      r[high] = addWithCarry(core, r[high], op & 0xff, 0);
      return;
    case 7: // SUBS
      r[high] = addWithCarry(core, r[high], ~(op & 0xff), 1);
      return;
    case 8:
      return op < 0x4400 ? alu(core, r, op) : highRegisters(core, r, op);
    case 9: // LDR, literal
      r[high] = load(core, bus, ((r[PC] + 2) & ~3) + ((op & 0xff) << 2));
      return;
    case 10:
    case 11:
      return loadStoreRegister(core, bus, r, op);
    case 12: // STR
      return store(core, bus, (r[middle] + ((op >> 4) & 0x7c)) | 0, r[low]);
    case 13: // LDR
      r[low] = load(core, bus, (r[middle] + ((op >> 4) & 0x7c)) | 0);
      return;
    case 14: {
      // STRB
      const address = (r[middle] + ((op >> 6) & 0x1f)) | 0;
      core.cycles += writeCycles(address);
      bus.write8(address, r[low]);
      return;
    }
    case 15: {
      // LDRB
      const address = (r[middle] + ((op >> 6) & 0x1f)) | 0;
      core.cycles += readCycles(address);
      r[low] = bus.read8(address);
      return;
    }
    case 16: {
      // STRH
      const address = (r[middle] + ((op >> 5) & 0x3e)) | 0;
      core.cycles += writeCycles(address);
      bus.write16(address, r[low]);
      return;
    }
    case 17: {
      // LDRH
      const address = (r[middle] + ((op >> 5) & 0x3e)) | 0;
      core.cycles += readCycles(address);
      r[low] = bus.read16(address);
      return;
    }
    case 18: // STR, SP
      return store(core, bus, (r[SP] + ((op & 0xff) << 2)) | 0, r[high]);
    case 19: // LDR, SP
      r[high] = load(core, bus, (r[SP] + ((op & 0xff) << 2)) | 0);
      return;
    case 20: // ADR
      r[high] = ((r[PC] + 2) & ~3) + ((op & 0xff) << 2);
      return;
    case 21: // ADD, SP
      r[high] = r[SP] + ((op & 0xff) << 2);
      return;
    case 22:
    case 23:
      return miscellaneous(core, bus, r, op);
    case 24:
      return storeMultiple(core, bus, r, high, op & 0xff);
    case 25:
      return loadMultiple(core, bus, r, high, op & 0xff);
    case 26:
    case 27:
      return branchIf(core, r, op);
    case 28: // B
      r[PC] += ((op << 21) >> 20) + 2;
      core.cycles += 1;
      return;
    default:
      return wide(core, bus, r, op);
  }
}

function load(core, bus, address) {
  core.cycles += readCycles(address);
  return bus.read32(address);
}

function store(core, bus, address, value) {
  core.cycles += writeCycles(address);
  bus.write32(address, value);
}

function shiftLeft(core, r, target, value, by) {
  const result = value << by;
  if (by !== 0) core.C = ((value >>> (32 - by)) & 1) !== 0;
  core.N = result < 0;
  core.Z = result === 0;
  r[target] = result;
}

function shiftRight(core, r, target, value, by, arithmetic) {
  const result = arithmetic ? value >> Math.min(by, 31) : by === 32 ? 0 : value >>> by;
  core.C = ((value >>> (by - 1)) & 1) !== 0;
  core.N = (result | 0) < 0;
  core.Z = result === 0;
  r[target] = result;
}

function storeMultiple(core, bus, r, base, list) {
  let address = r[base];
  for (let index = 0; index < 8; index++) {
    if (list & (1 << index)) {
      bus.write32(address, r[index]);
      address += 4;
      core.cycles += 1;
    }
  }
  r[base] = address;
}

function loadMultiple(core, bus, r, base, list) {
  let address = r[base];
  for (let index = 0; index < 8; index++) {
    if (list & (1 << index)) {
      r[index] = bus.read32(address);
      address += 4;
      core.cycles += 1;
    }
  }
  if (!(list & (1 << base))) r[base] = address;
}

function branchIf(core, r, op) {
  const condition = (op >> 8) & 15;
  if (condition >= 14) {
    // UDF and SVC
    r[PC] -= 2;
    core.cycles -= 1;
    core.executeInstruction();
  } else if (holds(core, condition)) {
    r[PC] += ((op << 24) >> 23) + 2;
    core.cycles += 1;
  }
}
