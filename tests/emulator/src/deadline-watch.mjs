import { FLASH_BYTES, FLASH_START } from './flash.mjs';

const [FREE, HANDLER, MASKED] = [0, 1, 2];
const SHOWN = 16;
const INSTRUCTION_BYTES = 2;
const PC = 15;
/** The program counter is past the instruction that masks: CPSID, or the first half of MSR. */
const PASSED_BYTES = 2;

/** The data read from flash in one kind of place, by instructions anywhere. In a handler the core's Thumb bit may be set. */
class DataTally {
  constructor() {
    this.count = 0;
    this.misses = 0;
    this.byPc = new Map();
  }

  add(pc, missed) {
    const at = pc & ~1;
    this.count += 1;
    if (missed) this.misses += 1;
    this.byPc.set(at, (this.byPc.get(at) ?? 0) + 1);
  }

  /** The summary lists the most frequent places first, and places of equal frequency by address. */
  summary() {
    const places = [...this.byPc].sort(([pc, count], [otherPc, otherCount]) => otherCount - count || pc - otherPc);
    return { count: this.count, misses: this.misses, pcs: places.slice(0, SHOWN).map(([pc]) => hex(pc)) };
  }
}

/** The same for instructions. There may be millions, but all are in flash. */
class CodeTally {
  constructor() {
    this.misses = 0;
    this.counts = null;
  }

  add(pc, missed) {
    this.counts ??= new Uint32Array(FLASH_BYTES / INSTRUCTION_BYTES);
    this.counts[(pc & (FLASH_BYTES - 1)) >>> 1] += 1;
    if (missed) this.misses += 1;
  }

  summary() {
    const tally = new DataTally();
    tally.misses = this.misses;
    this.counts?.forEach((count, index) => {
      if (count === 0) return;
      tally.count += count;
      tally.byPc.set(FLASH_START + index * INSTRUCTION_BYTES, count);
    });
    return tally.summary();
  }
}

const hex = (pc) => `0x${(pc >>> 0).toString(16)}`;

/**
 * Watches the code with deadlines: exception handlers, and thread mode with interrupts masked. It counts what this code
 * reads from flash, where a miss of the cache delays it, and the longest time for which interrupts were masked. A core
 * that sleeps while they are masked is not counted: it wakes for whichever comes.
 *
 * The firmware's start does not count. Counting begins with the sender's first bytes after the firmware's first, and
 * restarts in the same way after every reset.
 */
export class DeadlineWatch {
  /** @param {import('./clock.mjs').MachineClock} clock */
  constructor(clock) {
    this.clock = clock;
    this.code = { [HANDLER]: new CodeTally(), [MASKED]: new CodeTally() };
    this.data = { [HANDLER]: new DataTally(), [MASKED]: new DataTally() };
    this.longest = { cycles: 0, pc: null };
    /** Called when `urgent` changes. */
    this.onUrgent = () => {};
  }

  /** A chip starts. */
  attach(core) {
    this.core = core;
    this.heard = false;
    this.counting = false;
    this.context = FREE;
    /** Whether reads of flash count now. The bus checks it at every word. */
    this.urgent = false;
    this.masked = null;
    /** What has been read from flash since interrupts were masked. Whether it counts is known only at the end. */
    this.sinceMasked = [];
  }

  /** The firmware has sent something. */
  firmwareSpoke() {
    this.heard = true;
  }

  /** The sender sends something. */
  senderSpoke() {
    if (!this.heard || this.counting) return;
    this.counting = true;
    this.#consider();
  }

  /** The core has entered or left a handler, or has masked or unmasked interrupts. */
  update() {
    const { core, masked } = this;
    if (core.PM && masked === null) this.masked = { pc: core.registers[PC] - PASSED_BYTES, since: this.clock.awakeCycles, counts: this.counting };
    if (!core.PM && masked !== null) this.#unmask(masked);
    this.context = core.IPSR !== 0 ? HANDLER : core.PM ? MASKED : FREE;
    this.#consider();
  }

  /**
   * The ROM's flash functions must mask interrupts for a long time, which is excluded. Compared with these
   * milliseconds, reads of flash before and after them do not matter.
   */
  exclude(cycles) {
    if (this.masked === null) return;
    this.masked.since += cycles;
    this.masked.programs = true;
  }

  /** An instruction came from flash. */
  fetched(pc, missed) {
    this.#took(this.code[this.context], pc, missed);
  }

  /** The instruction at `pc` read flash. */
  read(pc, missed) {
    this.#took(this.data[this.context], pc, missed);
  }

  summary() {
    if (this.masked !== null) this.#ended(this.masked);
    return {
      flash_in_handlers: this.code[HANDLER].summary(),
      flash_in_handlers_data: this.data[HANDLER].summary(),
      flash_in_critical_sections: this.code[MASKED].summary(),
      flash_in_critical_sections_data: this.data[MASKED].summary(),
      longest_masked_cycles: this.longest.cycles,
      longest_masked_pc: this.longest.pc === null ? null : hex(this.longest.pc),
    };
  }

  #consider() {
    const urgent = this.counting && this.context !== FREE;
    if (urgent === this.urgent) return;
    this.urgent = urgent;
    this.onUrgent();
  }

  #unmask(masked) {
    this.#ended(masked);
    this.masked = null;
  }

  #took(tally, pc, missed) {
    if (this.context === MASKED) this.sinceMasked.push({ tally, pc, missed });
    else tally.add(pc, missed);
  }

  #ended(masked) {
    this.#measure(masked);
    if (masked.programs !== true) for (const { tally, pc, missed } of this.sinceMasked) tally.add(pc, missed);
    this.sinceMasked = [];
  }

  #measure({ pc, since, counts }) {
    const cycles = this.clock.awakeCycles - since;
    if (counts && cycles > this.longest.cycles) this.longest = { cycles, pc };
  }
}
