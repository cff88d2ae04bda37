import { FLASH_START } from './flash.mjs';

/** Size of what the ROM reads from the beginning of flash. It runs it at the end of RAM, above the ROM's own stack. */
const STAGE_BYTES = 256;
const RAM_START = 0x20000000;
export const STAGE_ADDRESS = 0x20041f00;
/** The vector table follows it. */
export const VECTORS = FLASH_START + STAGE_BYTES;
const CHECKSUM_AT = STAGE_BYTES - 4;
const POLYNOMIAL = 0x04c11db7;
const ERASED = 0xff;

const hex = (value) => `0x${(value >>> 0).toString(16).padStart(8, '0')}`;

/**
 * Starts the program in flash like the ROM (datasheet 2.8.1.3). The ROM checks the second-stage bootloader, copies it
 * to RAM and runs it there. The bootloader sets up the interface to flash and, entered with 0 in LR, continues with the
 * vector table. A program without one is started by its vector table at once, with the interface set as by the
 * W25Q080's stage.
 */
export function boot(chip, flash) {
  const stage = flash.bytes.subarray(0, STAGE_BYTES);
  if (stage.every((byte) => byte === ERASED)) startProgram(chip);
  else startStage(chip, flash, stage);
}

function startProgram(chip) {
  const { core } = chip;
  core.VTOR = VECTORS;
  core.SP = chip.readUint32(VECTORS);
  core.PC = chip.readUint32(VECTORS + 4) & ~1;
}

function startStage(chip, flash, stage) {
  const { core } = chip;
  const [found, expected] = [checksum(stage.subarray(0, CHECKSUM_AT)), new DataView(stage.buffer).getUint32(CHECKSUM_AT, true)];
  if (found !== expected) {
    throw new Error(`the second-stage bootloader in the first ${STAGE_BYTES} bytes of flash has the checksum ${hex(found)}, but says ${hex(expected)}: the ROM would not start it`);
  }
  flash.interface.set({ showsFlash: false });
  chip.sram.set(stage, STAGE_ADDRESS - RAM_START);
  core.SP = STAGE_ADDRESS;
  core.LR = 0;
  core.PC = STAGE_ADDRESS;
}

/** CRC-32 with bits not reflected, initial value all ones, and no final inversion. */
export function checksum(bytes) {
  let sum = -1;
  for (const byte of bytes) {
    sum ^= byte << 24;
    // The value is signed, so it is negative if its first bit is set.
    for (let bit = 0; bit < 8; bit++) sum = sum < 0 ? (sum << 1) ^ POLYNOMIAL : sum << 1;
  }
  return sum >>> 0;
}
