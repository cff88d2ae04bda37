import { compare, difference, logarithm, ofAngle, product, quotient, squareRoot, sum } from './arithmetic.mjs';
import { clampSigned, clampUnsigned, fixed, returnSigned64, returnUnsigned64, scaled, signed64, stickyLow, unsigned64 } from './integers.mjs';
import { returnDouble, returnSingle, singleFrom } from './numbers.mjs';

/**
 * A sum, product, quotient or root of floats that is rounded to a double and then to a float equals the result of
 * rounding once.
 */
const binary = (operation) => (r) => returnSingle(r, operation(singleFrom(r[0]), singleFrom(r[1])));
const unary = (operation) => (r) => returnSingle(r, operation(singleFrom(r[0])));
const toWord = (convert) => (r) => {
  r[0] = convert(singleFrom(r[0]), r[1]);
};
const fromSigned64 = (r) => signed64(stickyLow(r[0], r[1]), r[1]);
const fromUnsigned64 = (r) => unsigned64(stickyLow(r[0], r[1]), r[1]);

/** Largest angle in either direction, radians. */
const FURTHEST_ANGLE = 128;

/**
 * The table of float functions: offset, name, average cycles from the datasheet (table "soft_float_table", V2), and the
 * effect on the registers.
 */
export const FLOATS = [
  [0x00, 'fadd', 71, binary(sum)],
  [0x04, 'fsub', 74, binary(difference)],
  [0x08, 'fmul', 58, binary(product)],
  [0x0c, 'fdiv', 71, binary(quotient)],
  [0x18, 'fsqrt', 63, unary(squareRoot)],
  [0x1c, 'float_to_int', 40, toWord((a) => clampSigned(fixed(a, 0)))],
  [0x20, 'float_to_fix', 39, toWord((a, bits) => clampSigned(fixed(a, bits)))],
  [0x24, 'float_to_uint', 39, toWord((a) => clampUnsigned(fixed(a, 0)))],
  [0x28, 'float_to_ufix', 38, toWord((a, bits) => clampUnsigned(fixed(a, bits)))],
  [0x2c, 'int_to_float', 55, (r) => returnSingle(r, r[0])],
  [0x30, 'fix_to_float', 53, (r) => returnSingle(r, scaled(r[0], -r[1]))],
  [0x34, 'uint_to_float', 54, (r) => returnSingle(r, r[0] >>> 0)],
  [0x38, 'ufix_to_float', 52, (r) => returnSingle(r, scaled(r[0] >>> 0, -r[1]))],
  [0x3c, 'fcos', 587, unary(ofAngle('fcos', Math.cos, FURTHEST_ANGLE))],
  [0x40, 'fsin', 577, unary(ofAngle('fsin', Math.sin, FURTHEST_ANGLE))],
  [0x44, 'ftan', 653, unary(ofAngle('ftan', Math.tan, FURTHEST_ANGLE))],
  [0x4c, 'fexp', 524, unary(Math.exp)],
  [0x50, 'fln', 789, unary(logarithm)],
  [0x54, 'fcmp', 25, (r) => (r[0] = compare(singleFrom(r[0]), singleFrom(r[1])))],
  [0x58, 'fatan2', 667, binary(Math.atan2)],
  [0x5c, 'int64_to_float', 62, (r) => returnSingle(r, fromSigned64(r))],
  [0x60, 'fix64_to_float', 60, (r) => returnSingle(r, scaled(fromSigned64(r), -r[2]))],
  [0x64, 'uint64_to_float', 58, (r) => returnSingle(r, fromUnsigned64(r))],
  [0x68, 'ufix64_to_float', 57, (r) => returnSingle(r, scaled(fromUnsigned64(r), -r[2]))],
  [0x6c, 'float_to_int64', 54, (r) => returnSigned64(r, fixed(singleFrom(r[0]), 0))],
  [0x70, 'float_to_fix64', 53, (r) => returnSigned64(r, fixed(singleFrom(r[0]), r[1]))],
  [0x74, 'float_to_uint64', 42, (r) => returnUnsigned64(r, fixed(singleFrom(r[0]), 0))],
  [0x78, 'float_to_ufix64', 41, (r) => returnUnsigned64(r, fixed(singleFrom(r[0]), r[1]))],
  [0x7c, 'float_to_double', 15, (r) => returnDouble(r, singleFrom(r[0]))],
];
