const MAGIC = 0x464c457f;
const CLASS_32 = 1;
const LITTLE_ENDIAN = 1;
const MACHINE_ARM = 40;
const LOAD = 1;

/**
 * The bytes that an ELF file puts into memory, by physical address, where a flashing tool would write them.
 *
 * @param {Uint8Array} file
 * @returns {{address: number, bytes: Uint8Array}[]}
 */
export function loadSegments(file) {
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  if (file.length < 52 || view.getUint32(0, true) !== MAGIC) throw new Error('not an ELF file');
  if (file[4] !== CLASS_32 || file[5] !== LITTLE_ENDIAN || view.getUint16(18, true) !== MACHINE_ARM) {
    throw new Error('an ELF file, but not for a 32-bit little-endian ARM: was it built for thumbv6m-none-eabi?');
  }
  const [tableOffset, entrySize, entries] = [view.getUint32(28, true), view.getUint16(42, true), view.getUint16(44, true)];
  const segments = [];
  for (let index = 0; index < entries; index++) {
    const at = tableOffset + index * entrySize;
    const [type, offset, , address, size] = [0, 4, 8, 12, 16].map((field) => view.getUint32(at + field, true));
    if (type !== LOAD || size === 0) continue;
    if (offset + size > file.length) throw new Error(`the ELF file is cut short: segment ${index} ends at byte ${offset + size} of ${file.length}`);
    segments.push({ address, bytes: file.subarray(offset, offset + size) });
  }
  if (segments.length === 0) throw new Error('the ELF file has nothing to load');
  return segments;
}
