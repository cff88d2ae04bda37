import { Fault, FetchFault } from './fault.mjs';
import { FLASH_START, hiddenFlash, isFlash } from './flash.mjs';
import { ROM_BYTES } from './rom/image.mjs';

/** Flash and its three aliases share the first six bits of an address. */
const FLASH_PAGES = FLASH_START >>> 26;
/** A value that no address has in these bits. */
const NO_PAGES = -1;
/** An odd address, at which there is neither an instruction nor a word. */
export const NOWHERE = 1;
const FLASH_MASK = 0xffffff;
const RAM_START = 0x20000000;
const PC = 15;
/** Four banks hold consecutive words in turn, on an RP2350 twice; above them are two small banks. */
const STRIPED_BYTES = 0x40000;
const [STRIPED_BANKS, SMALL_BANK_BYTES] = [4, 0x1000];
const SMALL_BYTES = 2 * SMALL_BANK_BYTES;
const FIRST_SMALL_BANK = 8;
const NO_BANK = -1;
/** An instruction's own accesses are on its last cycles; before them it may have waited for flash. */
const RAM_CYCLES = 2;
const SIO_PAGE = 0xd;
const APB_PAGE = 0x4;

/**
 * What the core reads and writes: flash and RAM through typed arrays, everything else through rp2040js. An
 * unaligned access is a fault, as on a Cortex-M0+.
 *
 * Registers, words and addresses are signed 32-bit numbers here: V8 keeps those unboxed from function to function.
 */
export class Bus {
  /**
   * @param {import('./flash.mjs').Flash} flash
   * @param {import('./xip-cache.mjs').XipCache} cache
   * @param {import('./deadline-watch.mjs').DeadlineWatch} watch
   */
  constructor(chip, flash, cache, watch) {
    this.chip = chip;
    this.flash = flash;
    this.cache = cache;
    this.watch = watch;
    this.flashPages = FLASH_PAGES;
    flash.onReadable = (readable) => (this.flashPages = readable ? FLASH_PAGES : NO_PAGES);
    /**
     * The address of the half-word of flash that was fetched together with the last one, as the second half of its
     * word. While every instruction is counted its bits are inverted, so that no address equals it.
     */
    this.secondHalf = NOWHERE;
    watch.onUrgent = () => (this.secondHalf = ~this.secondHalf);
    /** The address of the first half of a wide instruction that has been counted. */
    this.wideCounted = NOWHERE;
    /** Where the current instruction has read or written RAM; NOWHERE if it has not. */
    this.dataAddress = NOWHERE;
    /** The instruction whose fetch the DMA has already delayed. */
    this.heldUpAt = NOWHERE;
    this.core = chip.core;
    this.lockstep = chip.clock.lockstep;
    this.registers = new Int32Array(chip.core.registers.buffer);
    this.flash8 = chip.flash;
    this.flash16 = new Uint16Array(chip.flash.buffer);
    this.flash32 = new Int32Array(chip.flash.buffer);
    this.rom16 = new Uint16Array(chip.bootrom.buffer);
    this.ram8 = chip.sram;
    this.ram16 = new Uint16Array(chip.sram.buffer);
    this.ram32 = new Int32Array(chip.sram.buffer);
    this.ramSize = chip.sram.length;
  }

  /** The instruction at an address. */
  fetch(address) {
    // Code that must be fast runs mostly from RAM.
    const offset = (address - RAM_START) | 0;
    if (offset >= 0 && offset < this.ramSize) return this.ram16[offset >>> 1];
    if (address >>> 26 === this.flashPages) {
      if (address === this.secondHalf) this.secondHalf = NOWHERE;
      else this.fetchFlash(address);
      return this.flash16[(address & FLASH_MASK) >>> 1];
    }
    if (address >>> 0 < ROM_BYTES) return this.rom16[address >>> 1];
    if (isFlash(address)) throw new FetchFault(hiddenFlash(address));
    throw new FetchFault(`there is no program at ${name(address)}`);
  }

  read32(address) {
    const offset = (address - RAM_START) | 0;
    if ((address & 3) !== 0) throw unaligned('read', address);
    if (offset >= 0 && offset < this.ramSize) {
      this.dataAddress = address;
      return this.ram32[offset >>> 2];
    }
    if (address >>> 26 === this.flashPages) {
      this.readFlash(address);
      return this.flash32[(address & FLASH_MASK) >>> 2];
    }
    this.#beforeRead(address);
    return this.chip.readUint32(address >>> 0) | 0;
  }

  read16(address) {
    const offset = (address - RAM_START) | 0;
    if ((address & 1) !== 0) throw unaligned('read', address);
    if (offset >= 0 && offset < this.ramSize) {
      this.dataAddress = address;
      return this.ram16[offset >>> 1];
    }
    if (address >>> 26 === this.flashPages) {
      this.readFlash(address);
      return this.flash16[(address & FLASH_MASK) >>> 1];
    }
    this.#beforeRead(address);
    return this.chip.readUint16(address >>> 0);
  }

  read8(address) {
    const offset = (address - RAM_START) | 0;
    if (offset >= 0 && offset < this.ramSize) {
      this.dataAddress = address;
      return this.ram8[offset];
    }
    if (address >>> 26 === this.flashPages) {
      this.readFlash(address);
      return this.flash8[address & FLASH_MASK];
    }
    this.#beforeRead(address);
    return this.chip.readUint8(address >>> 0);
  }

  write32(address, value) {
    const offset = (address - RAM_START) | 0;
    if ((address & 3) !== 0) throw unaligned('write', address);
    if (offset >= 0 && offset < this.ramSize) {
      this.dataAddress = address;
      this.ram32[offset >>> 2] = value;
      return;
    }
    this.#beforeWrite(address);
    this.chip.writeUint32(address >>> 0, value >>> 0);
  }

  write16(address, value) {
    const offset = (address - RAM_START) | 0;
    if ((address & 1) !== 0) throw unaligned('write', address);
    if (offset >= 0 && offset < this.ramSize) {
      this.dataAddress = address;
      this.ram16[offset >>> 1] = value;
      return;
    }
    this.#beforeWrite(address);
    this.chip.writeUint16(address >>> 0, value & 0xffff);
  }

  write8(address, value) {
    const offset = (address - RAM_START) | 0;
    if (offset >= 0 && offset < this.ramSize) {
      this.dataAddress = address;
      this.ram8[offset] = value;
      return;
    }
    this.#beforeWrite(address);
    this.chip.writeUint8(address >>> 0, value & 0xff);
  }

  /** The core fetches instructions in words. This one begins a word, is the target of a branch, or must be counted. */
  fetchFlash(address) {
    if (this.watch.urgent) {
      this.#fetchCounted(address);
      return;
    }
    this.secondHalf = (address & 2) === 0 ? address + 2 : NOWHERE;
    this.#wait(address);
  }

  /** An exception discards what was fetched ahead; it is fetched again afterwards. */
  emptyPipeline() {
    this.secondHalf = this.watch.urgent ? ~NOWHERE : NOWHERE;
  }

  /** The core reads data, and waits if the word is not in the cache. */
  readFlash(address) {
    if (this.watch.urgent) this.watch.read(this.registers[PC] - 2, this.#waitCounted(address));
    else this.#wait(address);
  }

  /** Reads the vector of the handler that is being entered. */
  readVector(address) {
    if (this.watch.urgent) this.watch.read(address, this.#waitCounted(address));
    else this.#wait(address);
  }

  #fetchCounted(address) {
    const cameWithWord = address === ~this.secondHalf;
    this.secondHalf = ~(cameWithWord || (address & 2) !== 0 ? NOWHERE : address + 2);
    this.#count(address, !cameWithWord && this.#waitCounted(address));
  }

  /** The second half of a wide instruction does not count as an instruction. */
  #count(address, missed) {
    const isSecond = address === this.wideCounted + 2;
    this.wideCounted = !isSecond && isWide(this.flash16[(address & FLASH_MASK) >>> 1]) ? address : NOWHERE;
    if (!isSecond) this.watch.fetched(address, missed);
  }

  /** @returns {boolean} whether it was not in the cache */
  #waitCounted(address) {
    const { misses } = this.cache.counts;
    this.#wait(address);
    return this.cache.counts.misses > misses;
  }

  #wait(address) {
    const wait = this.cache.read(address);
    if (wait !== 0) this.core.cycles += wait;
  }

  /** The DMA uses a word of RAM on a cycle. If the core wants the same bank, it waits a cycle, once for each access. */
  contend(address, cycle) {
    const { core } = this;
    if (core.waiting || core.cycles - cycle >= RAM_CYCLES) return;
    const bank = this.#bankOf(address);
    if (bank === NO_BANK) return;
    const next = this.registers[PC];
    if (bank === this.#bankOf(this.dataAddress)) {
      this.dataAddress = NOWHERE;
      core.cycles += 1;
    } else if ((next & 2) === 0 && next !== this.heldUpAt && bank === this.#bankOf(next)) {
      this.heldUpAt = next;
      core.cycles += 1;
    }
  }

  #bankOf(address) {
    const offset = (address - RAM_START) | 0;
    if (offset < 0 || offset >= this.ramSize) return NO_BANK;
    const small = offset - (this.ramSize - SMALL_BYTES);
    if (small >= 0) return FIRST_SMALL_BANK + Math.floor(small / SMALL_BANK_BYTES);
    return Math.floor(offset / STRIPED_BYTES) * STRIPED_BANKS + ((offset >>> 2) & (STRIPED_BANKS - 1));
  }

  #beforeRead(address) {
    if (isFlash(address)) throw new Fault(hiddenFlash(address));
    this.catchUp();
  }

  #beforeWrite(address) {
    if (isFlash(address) || address >>> 0 < ROM_BYTES) throw new Fault(`a write to ${name(address)}, which is read-only`);
    this.catchUp();
  }

  /** A register shows what PIO and DMA have done up to the instruction's own cycle, and is written after it. */
  catchUp() {
    if (this.lockstep.next <= this.core.cycles) this.lockstep.catchUp();
  }
}

/** Cycles a load takes beyond its first: none on the single-cycle I/O bus, three on the peripherals' (APB). */
export function readCycles(address) {
  const page = address >>> 28;
  return page === SIO_PAGE ? 0 : page === APB_PAGE ? 3 : 1;
}

/** Cycles a store takes beyond its first. */
export function writeCycles(address) {
  const page = address >>> 28;
  return page === SIO_PAGE ? 0 : page === APB_PAGE ? 4 : 1;
}

const isWide = (op) => op >> 11 >= 0b11101;

const name = (address) => `0x${(address >>> 0).toString(16)}`;

function unaligned(verb, address) {
  return new Fault(`an unaligned ${verb} of address ${name(address)}`);
}
