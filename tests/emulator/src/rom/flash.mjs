import { Fault } from '../fault.mjs';
import { PAGE_BYTES, SECTOR_BYTES } from '../flash.mjs';

const SECTOR_ERASE = 0x20;
const IP = 12;
/** Counted in the ROM's source: mostly two delays of 2048 rounds, and ten bytes at 48 cycles. */
const EXIT_CYCLES = 13_000;
/** Estimates. They consist of accesses to registers on the peripheral bus, and of one cycle for each tag of the cache. */
const [CONNECT_CYCLES, FLUSH_CYCLES, ENTER_CYCLES] = [150, 1100, 40];
const EMPTY_CYCLES = 20;

/** Functions with a single trap: code, name, cycles, effect. */
export const FLASH = [
  ['IF', 'connect_internal_flash', CONNECT_CYCLES, () => {}],
  ['EX', 'flash_exit_xip', EXIT_CYCLES, (_, bus) => bus.flash.interface.set({ showsFlash: false })],
  ['FC', 'flash_flush_cache', FLUSH_CYCLES, (_, bus) => bus.flash.flushCache()],
  ['CX', 'flash_enter_cmd_xip', ENTER_CYCLES, (_, bus) => bus.flash.interface.set({ showsFlash: true })],
];

/**
 * Functions with a loop: a first trap checks the arguments, then a trap handles each sector or page until the count in
 * a register is 0.
 */
export const FLASH_LOOPS = [
  { code: 'RE', name: 'flash_range_erase', check: checkErase, step: eraseNext, count: 1 },
  { code: 'RP', name: 'flash_range_program', check: checkProgram, step: programNext, count: 2 },
];

/** @param r r0 the offset, r1 the count of bytes, r2 the size of a block, r3 its command, which goes to r12 as r3 is needed. */
function checkErase(r) {
  r[IP] = r[3] & 0xff;
  checkMultiple('flash_range_erase', r[1], SECTOR_BYTES);
}

/** Erases a block where one fits, otherwise a sector. */
function eraseNext(r, bus) {
  const [address, left, block] = [r[0] >>> 0, r[1] >>> 0, r[2] >>> 0];
  if (left === 0) return EMPTY_CYCLES;
  const fits = address % block === 0 && left >= block;
  const { bytes, cycles } = bus.flash.erase(address, fits ? r[IP] : SECTOR_ERASE);
  if (fits && bytes !== block) throw new Fault(`flash_range_erase of blocks of ${block} bytes by a command that erases ${bytes}`);
  r[0] += bytes;
  r[1] -= bytes;
  return cycles;
}

/** @param r r0 the offset, r1 the data, r2 the count of bytes */
function checkProgram(r) {
  checkMultiple('flash_range_program', r[2], PAGE_BYTES);
}

function programNext(r, bus) {
  if (r[2] === 0) return EMPTY_CYCLES;
  const page = Uint8Array.from({ length: PAGE_BYTES }, (_, index) => bus.read8((r[1] + index) | 0));
  const cycles = bus.flash.program(r[0] >>> 0, page);
  r[0] += PAGE_BYTES;
  r[1] += PAGE_BYTES;
  r[2] -= PAGE_BYTES;
  return cycles;
}

function checkMultiple(name, count, of) {
  if ((count >>> 0) % of !== 0) throw new Fault(`${name} of ${count >>> 0} bytes, which is no multiple of ${of}`);
}
