import { cyclesOfMicros, cyclesOfMillis, IS_RP2350 } from './clock.mjs';
import { Fault } from './fault.mjs';
import { Ssi } from './ssi.mjs';

export const FLASH_START = 0x10000000;
/** A Pico's W25Q16JV, a Pico 2's W25Q32JV. */
export const FLASH_BYTES = (IS_RP2350 ? 4 : 2) * 1024 * 1024;
export const SECTOR_BYTES = 4096;
export const PAGE_BYTES = 256;
const ERASED = 0xff;
/** Its erase commands, with the typical times from its datasheet. */
const ERASES = {
  0x20: { bytes: SECTOR_BYTES, cycles: cyclesOfMillis(45) },
  0x52: { bytes: 32 * 1024, cycles: cyclesOfMillis(120) },
  0xd8: { bytes: 64 * 1024, cycles: cyclesOfMillis(150) },
};
/** The typical time to program a page, from the same datasheet. */
const PROGRAM_CYCLES = cyclesOfMicros(400);
/** The ROM sends a bit in six cycles. */
const BYTE_CYCLES = 48;
/** A command and its address. */
const COMMAND_CYCLES = 4 * BYTE_CYCLES;
/** Flash appears four times in memory, up to 0x13ffffff. The first six bits of these addresses are the same. */
const ALIASES = FLASH_START >>> 26;
const NOTHING = new Uint8Array(0);

const hex = (value) => `0x${value.toString(16)}`;

export const isFlash = (address) => address >>> 26 === ALIASES;

/** The error for reading flash while it cannot be read. */
export function hiddenFlash(address) {
  return `flash is read at ${hex(address >>> 0)} while it is being programmed (by an interrupt? by code or data that is not in RAM?)`;
}

/** The flash chip behind its serial interface: its content, and whether it can be read as memory. */
export class Flash {
  /**
   * @param {import('./xip-cache.mjs').XipCache} cache
   * @param {(onChange: () => void) => {showsFlash: boolean, wordCycles: number, set: (to: {showsFlash: boolean}) => void}} makeInterface
   */
  constructor(chip, cache, makeInterface = (onChange) => new Ssi(chip, 'SSI', onChange)) {
    this.chip = chip;
    this.cache = cache;
    this.bytes = chip.flash;
    this.interface = makeInterface(() => this.update());
    this.selected = false;
    /** Called when that changes. */
    this.onReadable = () => {};
    this.update();
  }

  get readable() {
    return this.chip.flash.length > 0;
  }

  /** After a command the ROM leaves the chip selected by hand. That hides flash too, until the ROM flushes the cache. */
  select(selected) {
    this.selected = selected;
    this.update();
  }

  /** The ROM flushes and enables the cache, and deselects the chip. */
  flushCache() {
    this.cache.flush();
    this.cache.enable(true);
    this.select(false);
  }

  /** Shows or hides flash and sets its read time, according to its interface. */
  update() {
    this.cache.setWordCycles(this.interface.wordCycles);
    const readable = !this.selected && this.interface.showsFlash;
    if (readable === this.readable) return;
    this.chip.flash = readable ? this.bytes : NOTHING;
    this.onReadable(readable);
  }

  /** Erases what this command erases. @returns {{bytes: number, cycles: number}} */
  erase(address, command) {
    const erase = ERASES[command];
    if (erase === undefined) throw new Fault(`flash has no erase command ${hex(command)}: it has ${Object.keys(ERASES).map(Number).map(hex).join(', ')}`);
    this.#check('erases', address, erase.bytes);
    this.bytes.fill(ERASED, address, address + erase.bytes);
    this.select(true);
    return { bytes: erase.bytes, cycles: erase.cycles + COMMAND_CYCLES };
  }

  /** Programs a page. Bits can change from 1 to 0 only. @returns {number} the cycles it takes */
  program(address, page) {
    this.#check('programs', address, PAGE_BYTES);
    page.forEach((byte, index) => (this.bytes[address + index] &= byte));
    this.select(true);
    return PROGRAM_CYCLES + COMMAND_CYCLES + PAGE_BYTES * BYTE_CYCLES;
  }

  #check(verb, address, bytes) {
    if (this.interface.showsFlash) throw new Fault(`the ROM ${verb} flash while it is memory: call connect_internal_flash and flash_exit_xip first`);
    const what = `the ROM ${verb} flash at offset ${hex(address)}`;
    if (address % bytes !== 0) throw new Fault(`${what}, which is no multiple of ${bytes}`);
    if (address + bytes > FLASH_BYTES) throw new Fault(`${what}, outside its ${FLASH_BYTES} bytes (offsets count from 0, not from ${hex(FLASH_START)})`);
  }
}
