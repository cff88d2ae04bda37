/** The architecture's AddWithCarry: the sum, and all four flags. A subtraction is `a + ~b + 1`. */
export function addWithCarry(core, a, b, carry) {
  const result = (a + b + carry) | 0;
  core.N = result < 0;
  core.Z = result === 0;
  core.C = ((a & b) | ((a | b) & ~result)) < 0;
  core.V = (~(a ^ b) & (a ^ result)) < 0;
  return result;
}

/** The sixteen register-to-register operations, 0x4000 to 0x43ff. */
export function alu(core, r, op) {
  const d = op & 7;
  const a = r[d];
  const b = r[(op >> 3) & 7];
  switch ((op >> 6) & 15) {
    case 0: // ANDS
      return logical(core, r, d, a & b);
    case 1: // EORS
      return logical(core, r, d, a ^ b);
    case 2: // LSLS
      return shift(core, r, d, b & 0xff, (by) => (by < 32 ? a << by : 0), (by) => by <= 32 && bit(a, 32 - by));
    case 3: // LSRS
      return shift(core, r, d, b & 0xff, (by) => (by < 32 ? a >>> by : 0), (by) => by <= 32 && bit(a, by - 1));
    case 4: // ASRS
      return shift(core, r, d, b & 0xff, (by) => a >> Math.min(by, 31), (by) => bit(a, Math.min(by - 1, 31)));
    case 5: // ADCS
      r[d] = addWithCarry(core, a, b, core.C ? 1 : 0);
      return;
    case 6: // SBCS
      r[d] = addWithCarry(core, a, ~b, core.C ? 1 : 0);
      return;
    case 7: // RORS
      return shift(core, r, d, b & 0xff, (by) => (a >>> (by & 31)) | (a << (32 - (by & 31))), (by) => bit(a, (by - 1) & 31));
    case 8: // TST
      return flags(core, a & b);
    case 9: // RSBS
      r[d] = addWithCarry(core, ~b, 0, 1);
      return;
    case 10: // CMP
      addWithCarry(core, a, ~b, 1);
      return;
    case 11: // CMN
      addWithCarry(core, a, b, 0);
      return;
    case 12: // ORRS
      return logical(core, r, d, a | b);
    case 13: // MULS, in one cycle on the RP2040
      return logical(core, r, d, Math.imul(a, b));
    case 14: // BICS
      return logical(core, r, d, a & ~b);
    default: // MVNS
      return logical(core, r, d, ~b);
  }
}

function bit(value, index) {
  return ((value >>> index) & 1) !== 0;
}

function flags(core, result) {
  core.N = result < 0;
  core.Z = result === 0;
}

function logical(core, r, target, result) {
  r[target] = result;
  flags(core, result);
}

/** A shift by a register. A shift by 0 does not change the carry. */
function shift(core, r, target, by, shifted, carry) {
  const result = by === 0 ? r[target] : shifted(by);
  if (by !== 0) core.C = carry(by);
  logical(core, r, target, result | 0);
}
