const LF = 0x0a;
const CR = 0x0d;
const isLineEnd = (byte) => byte === LF || byte === CR;

/** Bytes as text that prints: control and non-ASCII bytes escaped. */
export function printable(bytes) {
  const escaped = (byte) => (byte >= 0x20 && byte < 0x7f ? String.fromCharCode(byte) : `\\x${byte.toString(16).padStart(2, '0')}`);
  return Array.from(bytes, escaped).join('');
}

/** A line's text without its end. */
export function trimmedText(bytes) {
  let end = bytes.length;
  while (end > 0 && isLineEnd(bytes[end - 1])) end--;
  return printable(bytes.subarray(0, end));
}

export function lineEnds(bytes) {
  return bytes.reduce((ends, byte) => ends + (isLineEnd(byte) ? 1 : 0), 0);
}

/**
 * A program's lines byte for byte, their ends included; a last line without one gets it.
 *
 * @param {Uint8Array} file
 * @returns {Uint8Array[]}
 */
export function programLines(file) {
  const lines = [];
  for (let start = 0; start < file.length; ) {
    const end = file.indexOf(LF, start) + 1;
    const line = end > 0 ? file.subarray(start, end) : Uint8Array.from([...file.subarray(start), LF]);
    lines.push(line);
    start += line.length;
  }
  return lines;
}

/** The axes that a line homes: `$H` all of them but A, which homes only if a setting says so; `$HX` one; comments and spaces aside. */
export function homedAxes(text) {
  const match = /^\$H([XYZA]?)$/i.exec(text.replace(/\(.*?\)|;.*$|\s/g, ''));
  if (match === null) return [];
  return match[1] === '' ? ['X', 'Y', 'Z'] : [match[1].toUpperCase()];
}
