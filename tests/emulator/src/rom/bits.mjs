/** The bit functions: code, name, average cycles from the datasheet, and the effect on the registers. */
export const BITS = [
  ['P3', 'popcount32', 18, (r) => (r[0] = ones(r[0]))],
  ['R3', 'reverse32', 21, (r) => (r[0] = reversed(r[0]))],
  ['L3', 'clz32', 13, (r) => (r[0] = Math.clz32(r[0]))],
  ['T3', 'ctz32', 12, (r) => (r[0] = r[0] === 0 ? 32 : 31 - Math.clz32(r[0] & -r[0]))],
];

function ones(value) {
  let count = 0;
  for (let left = value; left !== 0; left &= left - 1) count += 1;
  return count;
}

function reversed(value) {
  let result = 0;
  for (let bit = 0; bit < 32; bit++) result = (result << 1) | ((value >>> bit) & 1);
  return result;
}
