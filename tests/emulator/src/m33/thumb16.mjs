import { readCycles, writeCycles } from '../bus.mjs';
import { Fault } from '../fault.mjs';
import { extended, holds, reversed } from '../thumb.mjs';
import { add, negativeOrZero, shift, shiftByCode } from './flags.mjs';

const [SP, LR, PC] = [13, 14, 15];
/** Cycles of a branch beyond its own: the pipeline is filled anew. An assumption: ARM publishes no timing of this core. */
export const BRANCH_CYCLES = 2;

/** Carries out an instruction of 16 bits. `r[PC]` is the address behind it. */
export function execute16(core, bus, r, op) {
  const low = op & 7;
  const middle = (op >> 3) & 7;
  const high = (op >> 8) & 7;
  // In an IT block only comparisons set flags.
  const sets = core.it === 0;
  switch (op >> 11) {
    case 0: // LSLS, MOVS
    case 1: // LSRS
    case 2: { // ASRS
      const result = shiftByCode(core, op >> 11, r[middle], (op >> 6) & 31);
      r[low] = result;
      if (sets) logicalFlags(core, result);
      return;
    }
    case 3: {
      // ADDS and SUBS of a register or a 3-bit number
      const operand = op & 0x400 ? (op >> 6) & 7 : r[(op >> 6) & 7];
      r[low] = op & 0x200 ? add(core, r[middle], ~operand, 1, sets) : add(core, r[middle], operand, 0, sets);
      return;
    }
    case 4: // MOVS
      r[high] = op & 0xff;
      if (sets) negativeOrZero(core, op & 0xff);
      return;
    case 5: // CMP
      add(core, r[high], ~(op & 0xff), 1, true);
      return;
    case 6: // ADDS
      r[high] = add(core, r[high], op & 0xff, 0, sets);
      return;
    case 7: // SUBS
      r[high] = add(core, r[high], ~(op & 0xff), 1, sets);
      return;
    case 8:
      return op < 0x4400 ? alu(core, r, op, sets) : highRegisters(core, bus, r, op);
    case 9: // LDR, literal
      r[high] = load32(core, bus, ((r[PC] + 2) & ~3) + ((op & 0xff) << 2));
      return;
    case 10:
    case 11:
      return withRegister(core, bus, r, op);
    case 12:
      return store32(core, bus, (r[middle] + ((op >> 4) & 0x7c)) | 0, r[low]);
    case 13:
      r[low] = load32(core, bus, (r[middle] + ((op >> 4) & 0x7c)) | 0);
      return;
    case 14:
      return store8(core, bus, (r[middle] + ((op >> 6) & 0x1f)) | 0, r[low]);
    case 15:
      r[low] = load8(core, bus, (r[middle] + ((op >> 6) & 0x1f)) | 0);
      return;
    case 16:
      return store16(core, bus, (r[middle] + ((op >> 5) & 0x3e)) | 0, r[low]);
    case 17:
      r[low] = load16(core, bus, (r[middle] + ((op >> 5) & 0x3e)) | 0);
      return;
    case 18:
      return store32(core, bus, (r[SP] + ((op & 0xff) << 2)) | 0, r[high]);
    case 19:
      r[high] = load32(core, bus, (r[SP] + ((op & 0xff) << 2)) | 0);
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
    case 24: {
      // STMIA
      r[high] = storeMultiple(core, bus, r, r[high], op & 0xff);
      return;
    }
    case 25: {
      // LDMIA, which writes the address back unless it loads that register
      const end = loadMultiple(core, bus, r, r[high], op & 0xff);
      if (!(op & (1 << high))) r[high] = end;
      return;
    }
    case 26:
    case 27: {
      const condition = (op >> 8) & 15;
      if (condition === 14) throw new Fault('an undefined instruction (UDF)');
      if (condition === 15) return core.callSupervisor();
      if (holds(core, condition)) branch(core, r, r[PC] + 2 + ((op << 24) >> 23));
      return;
    }
    default: // B
      branch(core, r, r[PC] + 2 + ((op << 21) >> 20));
  }
}

export function branch(core, r, to) {
  r[PC] = to;
  core.cycles += BRANCH_CYCLES;
}

/** Where a value that is loaded or moved leads: to an address, or out of a handler. */
export function goTo(core, r, value) {
  core.cycles += BRANCH_CYCLES;
  if (core.IPSR !== 0 && value >>> 24 === 0xff) core.exceptionReturn(value);
  else if (value & 1) r[PC] = value & ~1;
  else throw new Fault(`a branch to 0x${(value >>> 0).toString(16)}, which is no Thumb code`);
}

export function load32(core, bus, address) {
  core.cycles += readCycles(address);
  return bus.read32(address);
}

export function load16(core, bus, address) {
  core.cycles += readCycles(address);
  return bus.read16(address);
}

export function load8(core, bus, address) {
  core.cycles += readCycles(address);
  return bus.read8(address);
}

export function store32(core, bus, address, value) {
  core.cycles += storeCycles(address);
  bus.write32(address, value);
}

export function store16(core, bus, address, value) {
  core.cycles += storeCycles(address);
  bus.write16(address, value);
}

export function store8(core, bus, address, value) {
  core.cycles += storeCycles(address);
  bus.write8(address, value);
}

/** Cycles of a store beyond its own. One to RAM is taken over by a buffer. */
function storeCycles(address) {
  const cycles = writeCycles(address);
  return cycles > 1 ? cycles - 1 : 0;
}

/** Stores the registers of a list from an address up. @returns {number} the address behind them */
export function storeMultiple(core, bus, r, address, list) {
  let at = address;
  for (let index = 0; index < 15; index++) {
    if (!(list & (1 << index))) continue;
    bus.write32(at, r[index]);
    at = (at + 4) | 0;
    core.cycles += 1;
  }
  return at;
}

/** Loads the registers of a list but PC, which is left to the caller. @returns {number} the address behind them */
export function loadMultiple(core, bus, r, address, list) {
  let at = address;
  for (let index = 0; index < 15; index++) {
    if (!(list & (1 << index))) continue;
    r[index] = bus.read32(at);
    at = (at + 4) | 0;
    core.cycles += 1;
  }
  return at;
}

function logicalFlags(core, result) {
  negativeOrZero(core, result);
  core.C = core.carryOut;
}

/** The sixteen operations of registers, 0x4000 to 0x43ff. */
function alu(core, r, op, sets) {
  const d = op & 7;
  const a = r[d];
  const b = r[(op >> 3) & 7];
  const kind = (op >> 6) & 15;
  switch (kind) {
    case 2: // LSLS
    case 3: // LSRS
    case 4: // ASRS
    case 7: { // RORS
      const result = shift(core, kind === 7 ? 3 : kind - 2, a, b & 0xff);
      r[d] = result;
      if (sets) logicalFlags(core, result);
      return;
    }
    case 5: // ADCS
      r[d] = add(core, a, b, core.C ? 1 : 0, sets);
      return;
    case 6: // SBCS
      r[d] = add(core, a, ~b, core.C ? 1 : 0, sets);
      return;
    case 8: // TST
      return negativeOrZero(core, a & b);
    case 9: // RSBS
      r[d] = add(core, ~b, 0, 1, sets);
      return;
    case 10: // CMP
      add(core, a, ~b, 1, true);
      return;
    case 11: // CMN
      add(core, a, b, 0, true);
      return;
    default: {
      const result = logical(kind, a, b);
      r[d] = result;
      if (sets) negativeOrZero(core, result);
    }
  }
}

function logical(kind, a, b) {
  switch (kind) {
    case 0: return a & b;
    case 1: return a ^ b;
    case 12: return a | b;
    case 13: return Math.imul(a, b);
    case 14: return a & ~b;
    default: return ~b;
  }
}

/** ADD, CMP and MOV on all sixteen registers; BX and BLX. */
function highRegisters(core, bus, r, op) {
  const source = (op >> 3) & 15;
  const target = ((op >> 4) & 8) | (op & 7);
  const value = source === PC ? r[PC] + 2 : r[source];
  switch ((op >> 8) & 3) {
    case 0:
      return move(core, r, target, ((target === PC ? r[PC] + 2 : r[target]) + value) | 0);
    case 1:
      add(core, r[target], ~value, 1, true);
      return;
    case 2:
      return move(core, r, target, value);
    default:
      if (op & 0x80) r[LR] = r[PC] | 1;
      goTo(core, r, value);
  }
}

function move(core, r, target, value) {
  if (target === PC) branch(core, r, value & ~1);
  else r[target] = target === SP ? value & ~3 : value;
}

/** Loads and stores with a register as the offset, 0x5000 to 0x5fff. */
function withRegister(core, bus, r, op) {
  const address = (r[(op >> 6) & 7] + r[(op >> 3) & 7]) | 0;
  const target = op & 7;
  switch ((op >> 9) & 7) {
    case 0: return store32(core, bus, address, r[target]);
    case 1: return store16(core, bus, address, r[target]);
    case 2: return store8(core, bus, address, r[target]);
    case 3: r[target] = (load8(core, bus, address) << 24) >> 24; return;
    case 4: r[target] = load32(core, bus, address); return;
    case 5: r[target] = load16(core, bus, address); return;
    case 6: r[target] = load8(core, bus, address); return;
    default: r[target] = (load16(core, bus, address) << 16) >> 16;
  }
}

/** 0xb000 to 0xbfff. */
function miscellaneous(core, bus, r, op) {
  if (op & 0x100 && !(op & 0x400)) {
    // CBZ, CBNZ
    const isZero = r[op & 7] === 0;
    if (isZero === ((op & 0x800) === 0)) branch(core, r, r[PC] + 2 + (((op >> 2) & 0x3e) | ((op & 0x200) >> 3)));
    return;
  }
  switch ((op >> 8) & 15) {
    case 0:
      r[SP] += op & 0x80 ? -((op & 0x7f) << 2) : (op & 0x7f) << 2;
      return;
    case 2:
      r[op & 7] = extended(r[(op >> 3) & 7], (op >> 6) & 3);
      return;
    case 4:
    case 5: {
      // PUSH
      const list = (op & 0xff) | (op & 0x100 ? 1 << LR : 0);
      const from = (r[SP] - 4 * count(list)) | 0;
      storeMultiple(core, bus, r, from, list);
      r[SP] = from;
      return;
    }
    case 6:
      if ((op & 0xe8) !== 0x60) break;
      return core.maskInterrupts(op);
    case 10:
      if (((op >> 6) & 3) === 2) break;
      r[op & 7] = reversed(r[(op >> 3) & 7], (op >> 6) & 3);
      return;
    case 12:
    case 13: {
      // POP
      const end = loadMultiple(core, bus, r, r[SP], op & 0xff);
      if (!(op & 0x100)) {
        r[SP] = end;
        return;
      }
      const to = bus.read32(end);
      r[SP] = (end + 4) | 0;
      core.cycles += 1;
      return goTo(core, r, to);
    }
    case 14: // BKPT: in the ROM, one of its functions
      return core.breakpoint(op & 0xff);
    case 15:
      if (op & 15) core.beginBlock(op & 0xff);
      else core.hint((op >> 4) & 15);
      return;
  }
  throw new Fault(`an undefined instruction, ${op.toString(16)}`);
}

export function count(list) {
  let left = list;
  let found = 0;
  for (; left !== 0; left &= left - 1) found += 1;
  return found;
}
