import { FLASH_START } from './flash.mjs';

/** 1024 sets of two ways; a line is two words. */
export const SETS = 1024;
const SET_WORDS = 2 * SETS;
const OFFSET_MASK = 0xffffff;
const WORD_MASK = OFFSET_MASK >>> 2;
/** No word of flash has this number, and no address has this page. */
const NONE = -1;
/** For the first eight bits of an address: whether the cache is looked up, and whether a miss is stored in it. */
const PAGE = FLASH_START >>> 24;
const [LOOKS_UP, ALLOCATES] = [[true, true, false, false], [true, false, true, false]];
/** One set per cycle. */
const FLUSH_CYCLES = SETS;
/**
 * Cycles of a miss in addition to those of the serial clock: the bus, the SSI's FIFOs, chip select and input sampling.
 * With these a load that misses takes 50 cycles with the W25Q080 second stage, as measured on hardware (README).
 */
export const OVERHEAD_CYCLES = 8;
const [ACCESSES, MISSES, STALLS] = [0, 1, 2];

/** Counts of everything that reads flash. They belong to the board and outlive a reset. */
export class FlashCounts {
  constructor() {
    this.values = new Float64Array(3);
  }

  get accesses() {
    return this.values[ACCESSES];
  }

  get misses() {
    return this.values[MISSES];
  }

  get hits() {
    return this.accesses - this.misses;
  }

  /** Cycles for which the core waited. */
  get stallCycles() {
    return this.values[STALLS];
  }
}

/**
 * The cache between the bus and flash (RP2040 datasheet 2.6.3): 16 KiB, two ways, lines of 8 bytes.
 *
 * It stores no contents, because flash does not change while it can be read: for each of its words, each way records
 * only which word of flash it is. A line has one tag but is filled word by word, so the other word of a line is of the
 * same line or invalid. A miss replaces the line that was used longer ago.
 */
export class XipCache {
  /**
   * @param {import('./clock.mjs').MachineClock} clock
   * @param {FlashCounts} counts
   * @param {number | null} missFactor what a miss costs, times this; without one flash reads like RAM, and nothing is cached
   */
  constructor(clock, counts, missFactor) {
    this.clock = clock;
    this.counts = counts;
    this.values = counts.values;
    this.ideal = missFactor === null;
    this.missFactor = missFactor ?? 0;
    this.missCycles = 0;
    this.first = new Int32Array(SET_WORDS).fill(NONE);
    this.second = new Int32Array(SET_WORDS).fill(NONE);
    /** Whether a set's second way was used last. */
    this.secondLast = new Uint8Array(SETS);
    this.enabled = true;
    /** The page whose words are looked up directly; none while the cache is off or busy. */
    this.openPage = PAGE;
    /** The cycle from which it is free: after a flush, or after the other reader's miss. */
    this.readyCycle = 0;
    this.flushedCycle = 0;
  }

  /** The interface to flash has been set up: reading a word of 32 bits takes this many cycles. */
  setWordCycles(cycles) {
    this.missCycles = Math.round((cycles + OVERHEAD_CYCLES) * this.missFactor);
  }

  enable(enabled) {
    this.enabled = enabled;
    this.#open();
    if (this.clock.cycles < this.readyCycle) this.openPage = NONE;
  }

  /** Empties a line: of the first way, or of the second. */
  emptyLine(set, isSecond) {
    const way = isSecond ? this.second : this.first;
    way.fill(NONE, 2 * set, 2 * set + 2);
  }

  /** Empties the cache at once, as if much other code had run meanwhile. */
  empty() {
    this.first.fill(NONE);
    this.second.fill(NONE);
  }

  /** Empties the cache, which keeps it busy for some time. */
  flush() {
    this.empty();
    this.flushedCycle = this.clock.cycles + (this.ideal ? 0 : FLUSH_CYCLES);
    this.#keepBusy(this.flushedCycle);
  }

  /** The core reads. @returns {number} the cycles it has to wait: none for a hit */
  read(address) {
    if (this.ideal) return 0;
    this.values[ACCESSES] += 1;
    return address >>> 24 === this.openPage && this.#holds((address & OFFSET_MASK) >>> 2) ? 0 : this.#readSlowly(address);
  }

  #readSlowly(address) {
    const { cycles } = this.clock;
    const wait = Math.max(0, this.readyCycle - cycles) + this.#fetch(address);
    this.readyCycle = cycles + wait;
    this.values[STALLS] += wait;
    this.#open();
    return wait;
  }

  /** The DMA reads on a cycle. The core has to wait for it. @returns {number} the cycles until the word has been read */
  readBeside(address, cycle) {
    if (this.ideal) return 0;
    this.values[ACCESSES] += 1;
    const wait = Math.max(0, this.readyCycle - cycle) + this.#fetch(address);
    if (wait > 0) this.#keepBusy(cycle + wait);
    return wait;
  }

  /** Looks up a word, and records that its way was used. */
  #holds(word) {
    const index = word & (SET_WORDS - 1);
    if (this.first[index] === word) {
      this.secondLast[index >>> 1] = 0;
      return true;
    }
    if (this.second[index] !== word) return false;
    this.secondLast[index >>> 1] = 1;
    return true;
  }

  /** @returns {number} the cycles to read a word that is not in the cache */
  #fetch(address) {
    const word = (address >>> 2) & WORD_MASK;
    const alias = (address >>> 24) & 3;
    if (this.enabled && LOOKS_UP[alias] && this.#holds(word)) return 0;
    if (this.enabled && ALLOCATES[alias]) this.#keep(word);
    this.values[MISSES] += 1;
    return this.missCycles;
  }

  #keep(word) {
    const index = word & (SET_WORDS - 1);
    const set = index >>> 1;
    const intoSecond = this.#wayOf(word, index, set);
    const way = intoSecond ? this.second : this.first;
    // The line's other word stays only if it is of the same line.
    if (way[index ^ 1] !== (word ^ 1)) way[index ^ 1] = NONE;
    way[index] = word;
    this.secondLast[set] = intoSecond ? 1 : 0;
  }

  /** The way that already has the word's line, otherwise the one used longer ago. */
  #wayOf(word, index, set) {
    const holdsLine = (way) => way[index] === word || way[index ^ 1] === (word ^ 1);
    if (holdsLine(this.first)) return false;
    return holdsLine(this.second) || this.secondLast[set] === 0;
  }

  #keepBusy(until) {
    this.readyCycle = until;
    this.openPage = NONE;
  }

  #open() {
    this.openPage = this.enabled ? PAGE : NONE;
  }
}
