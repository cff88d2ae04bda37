/**
 * Copying and filling are done at once, so a handler sees all of it or nothing. The cycles are those of the ROM's
 * loops: 13 for 16 bytes copied by words and 8 for 16 filled; 7 per byte where source and target differ in their last
 * two bits; and 4 (or 2) per byte below 8 bytes. The code around each loop is added to that.
 */
const SHORT_BYTES = 8;
const SHORT_CYCLES = 13;
const UNLIKE_CYCLES = 9;

/** Code, name, cycles (0: the function returns them), and effect. */
export const MEMORY = [
  ['MC', 'memcpy', 0, copy(38)],
  ['C4', 'memcpy44', 0, copy(25)],
  ['MS', 'memset', 0, fill(38)],
  ['S4', 'memset4', 0, fill(29)],
];

function copy(overheadCycles) {
  return (r, bus) => {
    const [target, source, count] = [r[0], r[1], r[2] >>> 0];
    for (let index = 0; index < count; index++) bus.write8((target + index) | 0, bus.read8((source + index) | 0));
    if (count < SHORT_BYTES) return SHORT_CYCLES + 4 * count;
    return ((target ^ source) & 3) === 0 ? overheadCycles + Math.ceil((count * 13) / 16) : UNLIKE_CYCLES + 7 * count;
  };
}

function fill(overheadCycles) {
  return (r, bus) => {
    const [target, value, count] = [r[0], r[1] & 0xff, r[2] >>> 0];
    for (let index = 0; index < count; index++) bus.write8((target + index) | 0, value);
    return count < SHORT_BYTES ? SHORT_CYCLES + 2 * count : overheadCycles + Math.ceil(count / 2);
  };
}
