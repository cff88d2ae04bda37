import { readFileSync, writeFileSync } from 'node:fs';
import { FLASH_BYTES, FLASH_START, SECTOR_BYTES } from './flash.mjs';

const ERASED = 0xff;

/**
 * The content of a flash file: all of flash, from its first byte. The part that the firmware occupies is left erased in
 * it.
 *
 * @returns {Uint8Array | null} null if there is no such file yet
 */
export function readFlashFile(path) {
  const bytes = existing(path);
  if (bytes !== null && bytes.length !== FLASH_BYTES) {
    throw new Error(`--flash ${path}: ${bytes.length} bytes, but flash has ${FLASH_BYTES}; give a file that an earlier run wrote, or a new name`);
  }
  return bytes;
}

function existing(path) {
  try {
    return readFileSync(path);
  } catch (error) {
    if (error.code === 'ENOENT') return null;
    throw new Error(`cannot read --flash ${path} (${error.code}): check the path`);
  }
}

/** @param {{address: number, bytes: Uint8Array}[]} segments the firmware, whose sectors are not kept */
export function writeFlashFile(path, flash, segments) {
  const kept = Uint8Array.from(flash.subarray(0, FLASH_BYTES));
  eraseUnder(kept, segments);
  writeFileSync(path, kept);
}

/** Erases the sectors that segments occupy, as a flashing tool does before it writes them. */
export function eraseUnder(flash, segments) {
  for (const { address, bytes } of segments) {
    const start = address - FLASH_START;
    if (start < 0 || start >= flash.length) continue;
    const end = Math.ceil((start + bytes.length) / SECTOR_BYTES) * SECTOR_BYTES;
    flash.fill(ERASED, start - (start % SECTOR_BYTES), end);
  }
}
