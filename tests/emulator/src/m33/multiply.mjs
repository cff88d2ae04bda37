import { undefinedOf } from './thumb32.mjs';

const PC = 15;
const TWO_TO_32 = 2 ** 32;

/** The high and low words of a product. Doubles hold 53 bits, so it is made of halves. */
export function product(a, b, isSigned) {
  const [unsignedA, unsignedB] = [a >>> 0, b >>> 0];
  const low = Math.imul(a, b);
  const [aLow, aHigh, bLow, bHigh] = [unsignedA & 0xffff, unsignedA >>> 16, unsignedB & 0xffff, unsignedB >>> 16];
  const middle = aHigh * bLow + (aLow * bLow >>> 16);
  const other = aLow * bHigh + (middle % 0x10000);
  let high = (aHigh * bHigh + Math.floor(middle / 0x10000) + Math.floor(other / 0x10000)) | 0;
  if (isSigned) high = (high - (a < 0 ? b : 0) - (b < 0 ? a : 0)) | 0;
  return { low, high };
}

/** MUL, MLA, MLS, and those of which halves or the upper word count. */
export function multiply(core, r, op, second) {
  const [n, m, a] = [r[op & 15], r[second & 15], (second >> 12) & 15];
  const target = (second >> 8) & 15;
  const by = (second >> 4) & 3;
  switch ((op >> 4) & 7) {
    case 0:
      if (by > 1) break;
      r[target] = by === 1 ? r[a] - Math.imul(n, m) : Math.imul(n, m) + (a === PC ? 0 : r[a]);
      return;
    case 1: {
      // SMULxy, SMLAxy
      const result = Math.imul(half(n, by & 2), half(m, by & 1)) + (a === PC ? 0 : r[a]);
      if (result !== (result | 0)) core.Q = true;
      r[target] = result;
      return;
    }
    case 3: {
      // SMULWy, SMLAWy
      const { low, high } = product(n, half(m, by & 1), true);
      const result = ((high << 16) | (low >>> 16)) + (a === PC ? 0 : r[a]);
      if (result !== (result | 0)) core.Q = true;
      r[target] = result;
      return;
    }
    case 5: // SMMUL, SMMLA
      r[target] = upper(a === PC ? 0 : r[a], product(n, m, true), false, by & 1);
      return;
    case 6: // SMMLS
      r[target] = upper(r[a], product(n, m, true), true, by & 1);
      return;
  }
  throw undefinedOf(op, second);
}

/** The upper word of an accumulator with a product added or subtracted; rounded by half of the lower word. */
function upper(accumulator, { low, high }, subtracts, rounds) {
  const sign = subtracts ? -1 : 1;
  const lowest = sign * (low >>> 0) + (rounds ? 0x80000000 : 0);
  return (accumulator + sign * high + Math.floor(lowest / TWO_TO_32)) | 0;
}

function half(value, isUpper) {
  return isUpper ? value >> 16 : (value << 16) >> 16;
}

/** Products of 64 bits, and divisions. */
export function multiplyLong(core, r, op, second) {
  const [n, m] = [r[op & 15], r[second & 15]];
  const [lowTo, highTo] = [(second >> 12) & 15, (second >> 8) & 15];
  const by = (second >> 4) & 15;
  const kind = (op >> 4) & 7;
  switch ((kind << 4) | by) {
    case 0x00: // SMULL
    case 0x20: // UMULL
      return keep(r, lowTo, highTo, product(n, m, kind === 0));
    case 0x1f: // SDIV
      r[highTo] = divided(core, n, m);
      return;
    case 0x3f: // UDIV
      r[highTo] = divided(core, n >>> 0, m >>> 0);
      return;
    case 0x40: // SMLAL
    case 0x60: // UMLAL
      return keep(r, lowTo, highTo, sum(product(n, m, kind === 4), r[lowTo], r[highTo]));
    case 0x66: // UMAAL
      return keep(r, lowTo, highTo, sum(sum(product(n, m, false), r[lowTo], 0), r[highTo], 0));
    case 0x48: // SMLALxy
    case 0x49:
    case 0x4a:
    case 0x4b: {
      const low = Math.imul(half(n, by & 2), half(m, by & 1));
      return keep(r, lowTo, highTo, sum({ low, high: low >> 31 }, r[lowTo], r[highTo]));
    }
  }
  throw undefinedOf(op, second);
}

function sum({ low, high }, lowToo, highToo) {
  const lows = (low >>> 0) + (lowToo >>> 0);
  return { low: lows | 0, high: (high + highToo + (lows >= TWO_TO_32 ? 1 : 0)) | 0 };
}

function keep(r, lowTo, highTo, { low, high }) {
  r[lowTo] = low;
  r[highTo] = high;
}

/** A quotient towards 0; by 0 it is 0. It takes 2 to 11 cycles, by its length: an assumption. */
function divided(core, n, m) {
  const bits = Math.max(0, Math.clz32(Math.abs(m)) - Math.clz32(Math.abs(n)));
  core.cycles += 1 + Math.ceil((bits * 9) / 32);
  return m === 0 ? 0 : Math.trunc(n / m) | 0;
}
