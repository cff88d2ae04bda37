/**
 * Converts integers and fixed-point numbers from floats and back. Results are rounded towards minus infinity and
 * clamped to their range.
 */
const WORD = 2 ** 32;
/** A shift by more than this exceeds the range of any float in either direction. */
const FURTHEST = 2200;
/**
 * Low bits of a 64-bit number that may not fit in a double, and the bit among them that represents all (the sum has 53
 * bits).
 */
const [LOST_BITS, STICKY_BIT] = [0xfff, 0x800];

/** `value` * 2^`exponent`, rounded at most once. */
export function scaled(value, exponent) {
  let left = Math.max(-FURTHEST, Math.min(FURTHEST, exponent));
  let result = value;
  for (; left > 1000; left -= 1000) result *= 2 ** 1000;
  for (; left < -1000; left += 1000) result *= 2 ** -1000;
  return result * 2 ** left;
}

/** `value` * 2^`bits` as a fixed-point number. Any negative value, however small, becomes at most -1. */
export function fixed(value, bits) {
  const result = Math.floor(scaled(value, bits));
  return result === 0 && value < 0 ? -1 : result;
}

export function clampSigned(value) {
  return Math.max(-(2 ** 31), Math.min(2 ** 31 - 1, value));
}

export function clampUnsigned(value) {
  return Math.max(0, Math.min(WORD - 1, value)) | 0;
}

/** Returns a whole number in r0 and r1, clamped to 64 bits with sign. */
export function returnSigned64(r, value) {
  if (value >= 2 ** 63) returnPair(r, -1, 0x7fffffff);
  else if (value < -(2 ** 63)) returnPair(r, 0, 0x80000000);
  else returnWhole(r, value);
}

/** The same, unsigned. */
export function returnUnsigned64(r, value) {
  if (value >= 2 ** 64) returnPair(r, -1, -1);
  else if (value < 0) returnPair(r, 0, 0);
  else returnWhole(r, value);
}

function returnWhole(r, value) {
  const high = Math.floor(value / WORD);
  returnPair(r, value - high * WORD, high);
}

/** Numbers larger than 31 bits wrap in their register. */
function returnPair(r, low, high) {
  r[0] = low | 0;
  r[1] = high | 0;
}

/** The double nearest to a pair of registers. Both parts are exact, so the sum is rounded once. */
export function signed64(low, high) {
  return high * WORD + (low >>> 0);
}

export function unsigned64(low, high) {
  return (high >>> 0) * WORD + (low >>> 0);
}

/**
 * Changes a pair of registers so that its conversion to float via double rounds once: the bits that a double cannot
 * hold become one.
 */
export function stickyLow(low, high) {
  const short = high >> 21 === 0 || high >> 21 === -1;
  return short || (low & LOST_BITS) === 0 ? low : (low & ~LOST_BITS) | STICKY_BIT;
}
