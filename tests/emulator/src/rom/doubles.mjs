import { compare, difference, logarithm, ofAngle, product, quotient, squareRoot, sum } from './arithmetic.mjs';
import { clampSigned, clampUnsigned, fixed, returnSigned64, returnUnsigned64, scaled, signed64, unsigned64 } from './integers.mjs';
import { doubleFrom, returnDouble, returnSingle } from './numbers.mjs';

/** The first argument is in r0 and r1, the second in r2 and r3. */
const binary = (operation) => (r) => returnDouble(r, operation(doubleFrom(r[0], r[1]), doubleFrom(r[2], r[3])));
/** The divider has its result, and nobody waits for it. */
const READY = 1;
/** By the chip's divider, which forgets what it has computed for others. */
const divide = (r, bus) => {
  Object.assign(bus.chip.sio, { divQuotient: 0, divRemainder: 0, divCSR: READY });
  binary(quotient)(r);
};
const unary = (operation) => (r) => returnDouble(r, operation(doubleFrom(r[0], r[1])));
const toWord = (convert) => (r) => {
  r[0] = convert(doubleFrom(r[0], r[1]), r[2]);
};

/** Largest angle in either direction, radians. */
const FURTHEST_ANGLE = 1024;

/**
 * The table of double functions: offset, name, average cycles from the datasheet (table "soft_double_table", V2), and
 * the effect on the registers.
 */
export const DOUBLES = [
  [0x00, 'dadd', 91, binary(sum)],
  [0x04, 'dsub', 95, binary(difference)],
  [0x08, 'dmul', 155, binary(product)],
  [0x0c, 'ddiv', 183, divide],
  [0x18, 'dsqrt', 169, unary(squareRoot)],
  [0x1c, 'double_to_int', 75, toWord((a) => clampSigned(fixed(a, 0)))],
  [0x20, 'double_to_fix', 74, toWord((a, bits) => clampSigned(fixed(a, bits)))],
  [0x24, 'double_to_uint', 63, toWord((a) => clampUnsigned(fixed(a, 0)))],
  [0x28, 'double_to_ufix', 62, toWord((a, bits) => clampUnsigned(fixed(a, bits)))],
  [0x2c, 'int_to_double', 69, (r) => returnDouble(r, r[0])],
  [0x30, 'fix_to_double', 68, (r) => returnDouble(r, scaled(r[0], -r[1]))],
  [0x34, 'uint_to_double', 64, (r) => returnDouble(r, r[0] >>> 0)],
  [0x38, 'ufix_to_double', 62, (r) => returnDouble(r, scaled(r[0] >>> 0, -r[1]))],
  [0x3c, 'dcos', 1617, unary(ofAngle('dcos', Math.cos, FURTHEST_ANGLE))],
  [0x40, 'dsin', 1618, unary(ofAngle('dsin', Math.sin, FURTHEST_ANGLE))],
  [0x44, 'dtan', 1891, unary(ofAngle('dtan', Math.tan, FURTHEST_ANGLE))],
  [0x4c, 'dexp', 804, unary(Math.exp)],
  [0x50, 'dln', 428, unary(logarithm)],
  [0x54, 'dcmp', 39, (r) => (r[0] = compare(doubleFrom(r[0], r[1]), doubleFrom(r[2], r[3])))],
  [0x58, 'datan2', 2168, binary(Math.atan2)],
  [0x5c, 'int64_to_double', 55, (r) => returnDouble(r, signed64(r[0], r[1]))],
  [0x60, 'fix64_to_double', 53, (r) => returnDouble(r, scaled(signed64(r[0], r[1]), -r[2]))],
  [0x64, 'uint64_to_double', 50, (r) => returnDouble(r, unsigned64(r[0], r[1]))],
  [0x68, 'ufix64_to_double', 49, (r) => returnDouble(r, scaled(unsigned64(r[0], r[1]), -r[2]))],
  [0x6c, 'double_to_int64', 64, (r) => returnSigned64(r, fixed(doubleFrom(r[0], r[1]), 0))],
  [0x70, 'double_to_fix64', 63, (r) => returnSigned64(r, fixed(doubleFrom(r[0], r[1]), r[2]))],
  [0x74, 'double_to_uint64', 53, (r) => returnUnsigned64(r, fixed(doubleFrom(r[0], r[1]), 0))],
  [0x78, 'double_to_ufix64', 52, (r) => returnUnsigned64(r, fixed(doubleFrom(r[0], r[1]), r[2]))],
  [0x7c, 'double_to_float', 23, (r) => returnSingle(r, doubleFrom(r[0], r[1]))],
];
