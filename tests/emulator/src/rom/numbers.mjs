import { Fault } from '../fault.mjs';

/**
 * Floats as the ROM treats them: an argument that is denormal counts as a zero of its sign; a result is never denormal or
 * NaN. A NaN would count as an infinity; nobody checks for one on the way to the ROM, so it is a fault here. In registers
 * they are signed 32-bit words.
 */
const double = new Float64Array(1);
const doubleWords = new Int32Array(double.buffer);
const single = new Float32Array(1);
const singleWord = new Int32Array(single.buffer);
const [DOUBLE_EXPONENT, SINGLE_EXPONENT] = [0x7ff00000, 0x7f800000];

/** The double in a pair of registers. */
export function doubleFrom(low, high) {
  const exponent = high & DOUBLE_EXPONENT;
  if (exponent === 0) return high < 0 ? -0 : 0;
  if (exponent === DOUBLE_EXPONENT) return infinity(high, (high & ~DOUBLE_EXPONENT & 0x7fffffff) | low);
  doubleWords[0] = low;
  doubleWords[1] = high;
  return double[0];
}

/** Returns a double in r0 and r1. */
export function returnDouble(r, value) {
  double[0] = value;
  const high = doubleWords[1];
  const denormal = (high & DOUBLE_EXPONENT) === 0;
  r[0] = denormal ? 0 : doubleWords[0];
  r[1] = denormal ? high & 0x80000000 : high;
}

/** The float in a register. */
export function singleFrom(bits) {
  const exponent = bits & SINGLE_EXPONENT;
  if (exponent === 0) return bits < 0 ? -0 : 0;
  if (exponent === SINGLE_EXPONENT) return infinity(bits, bits & ~SINGLE_EXPONENT & 0x7fffffff);
  singleWord[0] = bits;
  return single[0];
}

/** Returns the float nearest to a double in r0. */
export function returnSingle(r, value) {
  single[0] = value;
  const bits = singleWord[0];
  r[0] = (bits & SINGLE_EXPONENT) === 0 ? bits & 0x80000000 : bits;
}

function infinity(sign, mantissa) {
  if (mantissa !== 0) throw new Fault('the ROM is given a NaN, which it takes for an infinity');
  return sign < 0 ? -Infinity : Infinity;
}
