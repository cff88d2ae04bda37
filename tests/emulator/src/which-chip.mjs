import { loadSegments } from './elf.mjs';
import { existsSync, readFileSync } from 'node:fs';

/** By it the RP2350's ROM knows a program: the first word of the block that says what the image is. */
export const IMAGE_MARK = 0xffffded3;
/** Where the ROM looks for it, from the beginning of flash. */
export const MARK_BYTES = 4096;
const FLASH_START = 0x10000000;

/** Whether a firmware is for an RP2350; otherwise it is for an RP2040. */
export function isForRp2350(segments) {
  return segments.some(({ address, bytes }) => {
    const until = Math.min(bytes.length - 3, FLASH_START + MARK_BYTES - address);
    if (address < FLASH_START) return false;
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    for (let at = 0; at < until; at += 4) if (view.getUint32(at, true) === IMAGE_MARK) return true;
    return false;
  });
}

/**
 * The chip that this process emulates: what its ELF file is for. A process emulates one board, so the clock is a constant of it, and is
 * known before anything is built. Tests without a file name the chip in the environment.
 */
export function isRp2350() {
  const at = process.argv.indexOf('--elf');
  const named = process.argv.find((argument) => argument.startsWith('--elf='))?.slice('--elf='.length);
  const file = named ?? (at < 0 ? undefined : process.argv[at + 1]);
  if (file === undefined || !existsSync(file)) return process.env.EMULATED_CHIP === 'rp2350';
  const bytes = readFileSync(file);
  return fileIsForRp2350(bytes);
}

function fileIsForRp2350(file) {
  try {
    return isForRp2350(loadSegments(file));
  } catch {
    // What is wrong with the file is told where it is loaded.
    return false;
  }
}
