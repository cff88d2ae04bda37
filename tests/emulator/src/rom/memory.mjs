/**
 * Copying and filling: done at once, so a handler sees all of it or nothing, and charged by the word as the ROM's loops
 * of `ldmia` and `stmia` cost: per 16 bytes 13 cycles to copy and 8 to fill; 7 a byte where source and target are not
 * alike in their last two bits; 4 a byte (2 to fill) below 8 bytes.
 */
export const MEMORY = [
  ['MC', 'memcpy', 0, copy],
  ['C4', 'memcpy44', 0, copy],
  ['MS', 'memset', 0, fill],
  ['S4', 'memset4', 0, fill],
];

const SHORT_BYTES = 8;
const OVERHEAD_CYCLES = 30;
const SHORT_OVERHEAD_CYCLES = 12;

function copy(r, bus) {
  const [target, source, count] = [r[0], r[1], r[2] >>> 0];
  for (let index = 0; index < count; index++) bus.write8((target + index) | 0, bus.read8((source + index) | 0));
  if (count < SHORT_BYTES) return SHORT_OVERHEAD_CYCLES + 4 * count;
  return OVERHEAD_CYCLES + (((target ^ source) & 3) === 0 ? Math.ceil((count * 13) / 16) : 7 * count);
}

function fill(r, bus) {
  const [target, value, count] = [r[0], r[1] & 0xff, r[2] >>> 0];
  for (let index = 0; index < count; index++) bus.write8((target + index) | 0, value);
  return count < SHORT_BYTES ? SHORT_OVERHEAD_CYCLES + 2 * count : OVERHEAD_CYCLES + Math.ceil(count / 2);
}
