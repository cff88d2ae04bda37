/** Arithmetic with the core's flags. */

/** The architecture's AddWithCarry, without flags but those that `core` gets if `sets`. A subtraction is `a + ~b + 1`. */
export function add(core, a, b, carry, sets) {
  const result = (a + b + carry) | 0;
  if (sets) {
    core.N = result < 0;
    core.Z = result === 0;
    core.C = ((a & b) | ((a | b) & ~result)) < 0;
    core.V = (~(a ^ b) & (a ^ result)) < 0;
  }
  return result;
}

/** The flags of a logical result. */
export function negativeOrZero(core, result) {
  core.N = result < 0;
  core.Z = result === 0;
}

const [LSL, LSR, ASR, ROR] = [0, 1, 2, 3];

/**
 * A shift by any amount, which leaves the carry in `core.carryOut`. A shift by 0 keeps the carry.
 *
 * @param {number} kind LSL, LSR, ASR or ROR, in the order of their codes
 */
export function shift(core, kind, value, by) {
  core.carryOut = core.C;
  if (by === 0) return value;
  switch (kind) {
    case LSL:
      core.carryOut = by <= 32 && bit(value, 32 - by);
      return by < 32 ? value << by : 0;
    case LSR:
      core.carryOut = by <= 32 && bit(value, by - 1);
      return by < 32 ? (value >>> by) | 0 : 0;
    case ASR:
      core.carryOut = bit(value, Math.min(by - 1, 31));
      return value >> Math.min(by, 31);
    default:
      core.carryOut = bit(value, (by - 1) & 31);
      return rotated(value, by & 31);
  }
}

/** A shift by the amount in an instruction: LSR and ASR by 0 are by 32, ROR by 0 takes the carry in from the left (RRX). */
export function shiftByCode(core, kind, value, by) {
  if (by !== 0 || kind === LSL) return shift(core, kind, value, by);
  if (kind !== ROR) return shift(core, kind, value, 32);
  const carry = core.C;
  core.carryOut = (value & 1) !== 0;
  return ((value >>> 1) | (carry ? 0x80000000 : 0)) | 0;
}

export function rotated(value, by) {
  return by === 0 ? value : (value >>> by) | (value << (32 - by));
}

function bit(value, index) {
  return ((value >>> index) & 1) !== 0;
}
