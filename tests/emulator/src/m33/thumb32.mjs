import { readCycles } from '../bus.mjs';
import { Fault } from '../fault.mjs';
import { extended, holds, reversed } from '../thumb.mjs';
import { coprocessor } from './coprocessor.mjs';
import { add, negativeOrZero, rotated, shift, shiftByCode } from './flags.mjs';
import { multiply, multiplyLong } from './multiply.mjs';
import { branch, count, goTo, load16, load32, load8, loadMultiple, store16, store32, store8, storeMultiple } from './thumb16.mjs';

const [SP, LR, PC] = [13, 14, 15];
const [AND, BIC, ORR, ORN, EOR, PKH, ADD, ADC, SBC, SUB, RSB] = [0, 1, 2, 3, 4, 6, 8, 10, 11, 13, 14];

/** Carries out an instruction of 32 bits, of which `op` is the first half and `r[PC]` is the address of the second. */
export function execute32(core, bus, r, op) {
  const second = bus.fetch(r[PC]);
  r[PC] += 2;
  switch ((op >> 9) & 15) {
    case 0b0100:
      return op & 0x40 ? dualOrExclusive(core, bus, r, op, second) : multiple(core, bus, r, op, second);
    case 0b0101: // by a shifted register
      return process(core, r, op, second, shiftByCode(core, (second >> 4) & 3, r[second & 15], ((second >> 10) & 0x1c) | ((second >> 6) & 3)));
    case 0b0110:
    case 0b0111:
    case 0b1110:
    case 0b1111:
      return coprocessor(core, r, op, second);
    case 0b1000:
    case 0b1010:
      return second & 0x8000 ? branches(core, r, op, second) : process(core, r, op, second, modified(core, immediate(op, second)));
    case 0b1001:
    case 0b1011:
      return second & 0x8000 ? branches(core, r, op, second) : plain(core, r, op, second, immediate(op, second));
    case 0b1100:
      return single(core, bus, r, op, second);
    case 0b1101:
      if (!(op & 0x100)) return registers(core, r, op, second);
      return op & 0x80 ? multiplyLong(core, r, op, second) : multiply(core, r, op, second);
  }
  throw undefinedOf(op, second);
}

export function undefinedOf(op, second) {
  const text = ((op << 16) | second) >>> 0;
  return new Fault(`an undefined instruction, ${text.toString(16)}`);
}

/** i:imm3:imm8 */
function immediate(op, second) {
  return ((op & 0x400) << 1) | ((second >> 4) & 0x700) | (second & 0xff);
}

/** The constants that an instruction can have: a byte, repeated or rotated. */
function modified(core, code) {
  core.carryOut = core.C;
  const byte = code & 0xff;
  switch (code >> 8) {
    case 0: return byte;
    case 1: return (byte << 16) | byte;
    case 2: return (byte << 24) | (byte << 8);
    case 3: return Math.imul(byte, 0x01010101);
  }
  const value = rotated((code & 0x7f) | 0x80, code >> 7);
  core.carryOut = value < 0;
  return value;
}

/** Data processing with an operand that has been made already. */
function process(core, r, op, second, operand) {
  const sets = (op & 0x10) !== 0;
  const source = op & 15;
  const target = (second >> 8) & 15;
  const kind = (op >> 5) & 15;
  const a = r[source];
  switch (kind) {
    case AND: return logical(core, r, target, sets, a & operand);
    case BIC: return logical(core, r, target, sets, a & ~operand);
    case ORR: return logical(core, r, target, sets, source === PC ? operand : a | operand);
    case ORN: return logical(core, r, target, sets, source === PC ? ~operand : a | ~operand);
    case EOR: return logical(core, r, target, sets, a ^ operand);
    case PKH:
      r[target] = second & 0x20 ? (a & 0xffff0000) | (operand & 0xffff) : (operand & 0xffff0000) | (a & 0xffff);
      return;
    case ADD: return keep(r, target, sets, add(core, a, operand, 0, sets));
    case ADC: return keep(r, target, sets, add(core, a, operand, core.C ? 1 : 0, sets));
    case SBC: return keep(r, target, sets, add(core, a, ~operand, core.C ? 1 : 0, sets));
    case SUB: return keep(r, target, sets, add(core, a, ~operand, 1, sets));
    case RSB: return keep(r, target, sets, add(core, ~a, operand, 1, sets));
  }
  throw undefinedOf(op, second);
}

/** Without a target it is a comparison. */
function keep(r, target, sets, result) {
  if (target !== PC || !sets) r[target] = result;
}

function logical(core, r, target, sets, result) {
  if (sets) {
    negativeOrZero(core, result);
    core.C = core.carryOut;
  }
  keep(r, target, sets, result);
}

/** With a number as it stands in the instruction, and bit fields. */
function plain(core, r, op, second, number) {
  const source = op & 15;
  const target = (second >> 8) & 15;
  const least = ((second >> 10) & 0x1c) | ((second >> 6) & 3);
  const width = (second & 31) + 1;
  switch ((op >> 4) & 31) {
    case 0: // ADDW, ADR
      r[target] = (source === PC ? r[PC] & ~3 : r[source]) + number;
      return;
    case 10: // SUBW, ADR
      r[target] = (source === PC ? r[PC] & ~3 : r[source]) - number;
      return;
    case 4: // MOVW
      r[target] = (source << 12) | number;
      return;
    case 12: // MOVT
      r[target] = (source << 28) | (number << 16) | (r[target] & 0xffff);
      return;
    case 16: // SSAT
    case 18:
      // Without a shift it would be SSAT16.
      if (op & 0x20 && least === 0) break;
      r[target] = saturated(core, shiftByCode(core, (op >> 4) & 2, r[source], least), -(2 ** (width - 1)), 2 ** (width - 1) - 1);
      return;
    case 24: // USAT
    case 26:
      if (op & 0x20 && least === 0) break;
      r[target] = saturated(core, shiftByCode(core, (op >> 4) & 2, r[source], least), 0, 2 ** (width - 1) - 1);
      return;
    case 20: // SBFX
      r[target] = (r[source] << (32 - least - width)) >> (32 - width);
      return;
    case 28: // UBFX
      r[target] = (r[source] << (32 - least - width)) >>> (32 - width);
      return;
    case 22: {
      // BFI, BFC
      const mask = (0xffffffff >>> (31 - (width - 1 - least))) << least;
      r[target] = (r[target] & ~mask) | (source === PC ? 0 : (r[source] << least) & mask);
      return;
    }
  }
  throw undefinedOf(op, second);
}

function saturated(core, value, low, high) {
  const result = Math.min(high, Math.max(low, value));
  if (result !== value) core.Q = true;
  return result;
}

/** BL, B, MRS, MSR, hints and barriers. */
function branches(core, r, op, second) {
  const sign = (op >> 10) & 1;
  if (second & 0x1000) {
    const [i1, i2] = [~((second >> 13) ^ sign) & 1, ~((second >> 11) ^ sign) & 1];
    const offset = (-sign << 24) | (i1 << 23) | (i2 << 22) | ((op & 0x3ff) << 12) | ((second & 0x7ff) << 1);
    const next = r[PC];
    if (second & 0x4000) r[LR] = next | 1;
    return branch(core, r, next + offset);
  }
  if (second & 0x4000) throw undefinedOf(op, second);
  if ((op & 0x380) !== 0x380) {
    const offset = (-sign << 20) | ((second & 0x800) << 8) | ((second & 0x2000) << 5) | ((op & 0x3f) << 12) | ((second & 0x7ff) << 1);
    if (holds(core, (op >> 6) & 15)) branch(core, r, r[PC] + offset);
    return;
  }
  switch ((op >> 4) & 0x7f) {
    case 0b0111000:
    case 0b0111001:
      return core.writeSpecialRegister(second & 0xff, r[op & 15]);
    case 0b0111010:
      return core.hint(second & 0xff);
    case 0b0111011:
      // CLREX, DSB, DMB, ISB: nothing is out of order here.
      if (((second >> 4) & 15) === 2) core.exclusive = false;
      return;
    case 0b0111110:
    case 0b0111111:
      r[(second >> 8) & 15] = core.readSpecialRegister(second & 0xff);
      return;
  }
  throw undefinedOf(op, second);
}

/** Loads and stores of one register. */
function single(core, bus, r, op, second) {
  const base = op & 15;
  const target = (second >> 12) & 15;
  let address;
  let end = null;
  if (base === PC) {
    address = ((r[PC] & ~3) + (op & 0x80 ? second & 0xfff : -(second & 0xfff))) | 0;
  } else if (op & 0x80) {
    address = (r[base] + (second & 0xfff)) | 0;
  } else if (second & 0x800) {
    const moved = (r[base] + (second & 0x200 ? second & 0xff : -(second & 0xff))) | 0;
    address = second & 0x400 ? moved : r[base];
    if (second & 0x100) end = moved;
  } else {
    address = (r[base] + (r[second & 15] << ((second >> 4) & 3))) | 0;
  }
  const kind = ((op >> 4) & 0x10) | ((op >> 4) & 7);
  switch (kind) {
    case 0: store8(core, bus, address, r[target]); break;
    case 2: store16(core, bus, address, r[target]); break;
    case 4: store32(core, bus, address, r[target]); break;
    case 1: // PLD, PLI and others that read nothing name no target.
      if (target !== PC) r[target] = load8(core, bus, address);
      break;
    case 3:
      if (target !== PC) r[target] = load16(core, bus, address);
      break;
    case 0x11:
      if (target !== PC) r[target] = (load8(core, bus, address) << 24) >> 24;
      break;
    case 0x13:
      if (target !== PC) r[target] = (load16(core, bus, address) << 16) >> 16;
      break;
    case 5: {
      const value = load32(core, bus, address);
      if (end !== null) r[base] = end;
      if (target === PC) goTo(core, r, value);
      else r[target] = value;
      return;
    }
    default:
      throw undefinedOf(op, second);
  }
  if (end !== null) r[base] = end;
}

/** LDM, STM, upwards and downwards. */
function multiple(core, bus, r, op, second) {
  const base = op & 15;
  const isDown = (op & 0x100) !== 0;
  const bytes = 4 * count(second);
  const from = isDown ? (r[base] - bytes) | 0 : r[base];
  if (((op >> 7) & 3) % 3 === 0) throw undefinedOf(op, second);
  const writesBack = (op & 0x20) !== 0;
  const after = isDown ? from : (from + bytes) | 0;
  if (!(op & 0x10)) {
    storeMultiple(core, bus, r, from, second);
    if (writesBack) r[base] = after;
    return;
  }
  const end = loadMultiple(core, bus, r, from, second & 0x7fff);
  if (writesBack) r[base] = after;
  if (!(second & 0x8000)) return;
  core.cycles += 1;
  goTo(core, r, bus.read32(end));
}

/** LDRD, STRD; tables of branches; loads and stores that acquire, release, or are exclusive. */
function dualOrExclusive(core, bus, r, op, second) {
  const base = op & 15;
  if ((op & 0x120) === 0) return op & 0x80 ? orderedOrTable(core, bus, r, op, second) : exclusiveWord(core, bus, r, op, second);
  const offset = (second & 0xff) << 2;
  const moved = ((base === PC ? r[PC] & ~3 : r[base]) + (op & 0x80 ? offset : -offset)) | 0;
  const address = op & 0x100 ? moved : r[base];
  const [one, two] = [(second >> 12) & 15, (second >> 8) & 15];
  core.cycles += 1;
  if (op & 0x10) {
    const [low, high] = [load32(core, bus, address), bus.read32((address + 4) | 0)];
    if (op & 0x20) r[base] = moved;
    r[one] = low;
    r[two] = high;
  } else {
    store32(core, bus, address, r[one]);
    store32(core, bus, (address + 4) | 0, r[two]);
    if (op & 0x20) r[base] = moved;
  }
}

/** LDREX, STREX of a word. */
function exclusiveWord(core, bus, r, op, second) {
  const address = (r[op & 15] + ((second & 0xff) << 2)) | 0;
  const target = (second >> 12) & 15;
  if (op & 0x10) {
    r[target] = load32(core, bus, address);
    core.exclusive = true;
  } else {
    // TT, of security, has no target here.
    if (target === PC) throw undefinedOf(op, second);
    r[(second >> 8) & 15] = ifExclusive(core, () => store32(core, bus, address, r[target]));
  }
}

/** @returns {number} what STREX says: 0 if it has stored */
function ifExclusive(core, store) {
  if (!core.exclusive) return 1;
  core.exclusive = false;
  store();
  return 0;
}

const LOADS = [load8, load16, load32];
const STORES = [store8, store16, store32];

function orderedOrTable(core, bus, r, op, second) {
  const target = (second >> 12) & 15;
  const kind = (second >> 4) & 15;
  const address = r[op & 15];
  const isLoad = (op & 0x10) !== 0;
  if (isLoad && kind < 2) {
    // TBB, TBH
    const from = (op & 15) === PC ? r[PC] : address;
    const at = (from + (r[second & 15] << kind)) | 0;
    core.cycles += readCycles(at);
    return branch(core, r, r[PC] + 2 * (kind === 1 ? bus.read16(at) : bus.read8(at)));
  }
  const size = kind & 3;
  const isExclusive = (kind & 4) !== 0;
  if (kind < 4 || size === 3) throw undefinedOf(op, second);
  if (isLoad) {
    r[target] = LOADS[size](core, bus, address);
    if (isExclusive) core.exclusive = true;
  } else if (isExclusive) {
    r[second & 15] = ifExclusive(core, () => STORES[size](core, bus, address, r[target]));
  } else {
    STORES[size](core, bus, address, r[target]);
  }
}

/** Shifts by a register, extensions, and what is done to the bits of one register. */
function registers(core, r, op, second) {
  const target = (second >> 8) & 15;
  const kind = (op >> 4) & 15;
  const by = (second >> 4) & 15;
  if ((second & 0xf000) !== 0xf000) throw undefinedOf(op, second);
  if (kind < 8 && by === 0) {
    const result = shift(core, kind >> 1, r[op & 15], r[second & 15] & 0xff);
    if (kind & 1) {
      negativeOrZero(core, result);
      core.C = core.carryOut;
    }
    r[target] = result;
    return;
  }
  if (kind < 6 && by >= 8) {
    const value = rotated(r[second & 15], (by & 3) * 8);
    const extension = kind === 2 || kind === 3 ? pairOfBytes(value, kind === 2) : extended(value, (kind & 1 ? 2 : 0) | (kind >= 4 ? 1 : 0));
    const source = op & 15;
    if (source !== PC && (kind === 2 || kind === 3)) throw undefinedOf(op, second);
    r[target] = source === PC ? extension : (r[source] + extension) | 0;
    return;
  }
  switch ((kind << 4) | by) {
    case 0x98: // REV
    case 0x99: // REV16
      r[target] = reversed(r[second & 15], by & 3);
      return;
    case 0x9a: // RBIT
      r[target] = bitsReversed(r[second & 15]);
      return;
    case 0x9b: // REVSH
      r[target] = reversed(r[second & 15], 3);
      return;
    case 0xb8: // CLZ
      r[target] = Math.clz32(r[second & 15]);
      return;
    case 0x88: // QADD
      r[target] = saturated(core, r[second & 15] + r[op & 15], -(2 ** 31), 2 ** 31 - 1);
      return;
    case 0x8a: // QSUB
      r[target] = saturated(core, r[second & 15] - r[op & 15], -(2 ** 31), 2 ** 31 - 1);
      return;
  }
  throw undefinedOf(op, second);
}

function pairOfBytes(value, isSigned) {
  if (!isSigned) return value & 0x00ff00ff;
  return (((value << 8) >> 24) << 16) | (((value << 24) >> 24) & 0xffff);
}

function bitsReversed(value) {
  let result = 0;
  for (let index = 0; index < 32; index++) result |= ((value >>> index) & 1) << (31 - index);
  return result;
}
