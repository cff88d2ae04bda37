import assert from 'node:assert/strict';
import test from 'node:test';
import { loadSegments } from '../src/elf.mjs';

const HEADER_BYTES = 52;
const ENTRY_BYTES = 32;

/** An ELF with the given program headers: [type, physical address, bytes]. */
function elf(headers, { machine = 40 } = {}) {
  const table = HEADER_BYTES + headers.length * ENTRY_BYTES;
  const file = new Uint8Array(table + headers.reduce((sum, [, , bytes]) => sum + bytes.length, 0));
  const view = new DataView(file.buffer);
  file.set([0x7f, 0x45, 0x4c, 0x46, 1, 1]);
  view.setUint16(18, machine, true);
  view.setUint32(28, HEADER_BYTES, true);
  view.setUint16(42, ENTRY_BYTES, true);
  view.setUint16(44, headers.length, true);
  let offset = table;
  headers.forEach(([type, address, bytes], index) => {
    const words = [type, offset, 0xdead0000, address, bytes.length];
    words.forEach((word, field) => view.setUint32(HEADER_BYTES + index * ENTRY_BYTES + field * 4, word, true));
    file.set(bytes, offset);
    offset += bytes.length;
  });
  return file;
}

test('segments go to their physical addresses; empty and other ones are left out', () => {
  const file = elf([[1, 0x10000100, [1, 2, 3]], [1, 0x20000000, []], [4, 0, [9]], [1, 0x10000200, [4]]]);
  const segments = loadSegments(file).map(({ address, bytes }) => [address, [...bytes]]);
  assert.deepEqual(segments, [[0x10000100, [1, 2, 3]], [0x10000200, [4]]]);
});

test('what is no firmware is refused in words', () => {
  assert.throws(() => loadSegments(new Uint8Array(100)), /not an ELF/);
  assert.throws(() => loadSegments(elf([[1, 0, [1]]], { machine: 62 })), /thumbv6m/);
  assert.throws(() => loadSegments(elf([])), /nothing to load/);
  assert.throws(() => loadSegments(elf([[1, 0x10000000, [1, 2, 3]]]).slice(0, -1)), /cut short/);
});
