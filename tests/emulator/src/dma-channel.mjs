import { Fault } from './fault.mjs';
import { isFlash } from './flash.mjs';

const [READ_ADDR, WRITE_ADDR, TRANS_COUNT, CTRL] = [0, 1, 2, 3];
/** Which register each of the sixteen words is; the last one of each four triggers. */
const REGISTERS = [
  [READ_ADDR, WRITE_ADDR, TRANS_COUNT, CTRL],
  [CTRL, READ_ADDR, WRITE_ADDR, TRANS_COUNT],
  [CTRL, TRANS_COUNT, READ_ADDR, WRITE_ADDR],
  [CTRL, WRITE_ADDR, TRANS_COUNT, READ_ADDR],
].flat();
/** Those that every chip has in the same places; the others are in its layout. */
const BIT = { enabled: 1 << 0, highPriority: 1 << 1, increasesRead: 1 << 4 };
const ERRORS = { bus: 1 << 31, read: 1 << 30, write: 1 << 29 };
/**
 * Cycles from a request (a free place in a FIFO, a trigger) to the write that answers it: the handshake, the read and the
 * write. An estimate of what the chip takes on an idle bus.
 */
export const LATENCY_CYCLES = 4;
const RAM_START = 0x20000000;

/** One channel of the DMA: its registers, and what one transfer does. */
export class DmaChannel {
  /** @param {import('./dma.mjs').Dma} dma */
  constructor(dma, index) {
    this.dma = dma;
    this.layout = dma.layout;
    this.chip = dma.rp2040;
    this.ram = new Int32Array(this.chip.sram.buffer);
    this.index = index;
    this.readAddress = 0;
    this.writeAddress = 0;
    /** Words left, and the number of words with which a trigger begins. */
    this.count = 0;
    this.reload = 0;
    this.busy = false;
    this.errors = 0;
    /** The cycle on which it may move its next word; Infinity while it waits for a request. */
    this.due = Infinity;
    this.pacedCycle = 0;
    /** Whether its next word has come from flash. */
    this.fetched = false;
    this.enabled = false;
    this.request = 0;
    this.#control(index << this.layout.shifts.chainTo);
  }

  read(offset) {
    switch (REGISTERS[offset >> 2]) {
      case READ_ADDR:
        return this.readAddress >>> 0;
      case WRITE_ADDR:
        return this.writeAddress >>> 0;
      case TRANS_COUNT:
        return this.count;
      default:
        return (this.ctrl | (this.busy ? this.layout.bits.busy : 0) | this.errors) >>> 0;
    }
  }

  write(offset, value, cycle) {
    switch (REGISTERS[offset >> 2]) {
      case READ_ADDR:
        this.readAddress = value >>> 0;
        this.fetched = false;
        break;
      case WRITE_ADDR:
        this.writeAddress = value >>> 0;
        break;
      case TRANS_COUNT:
        this.reload = value;
        break;
      default:
        this.#control(value, cycle);
    }
    if ((offset & 0xc) === 0xc) this.#trigger(value, cycle);
  }

  /** Begins a new run of words, if the channel is enabled and not busy. */
  start(cycle) {
    if (!this.enabled || this.busy) return;
    this.busy = true;
    this.count = this.reload;
    this.pacedCycle = cycle;
    if (this.count === 0) this.schedule(cycle + LATENCY_CYCLES);
    else this.#await(cycle + LATENCY_CYCLES);
  }

  abort() {
    this.busy = false;
    this.fetched = false;
    this.#park(this.request);
  }

  schedule(cycle) {
    this.due = cycle;
    this.dma.expect(cycle);
  }

  /** Moves a word, and then waits for the next request or completes. A run of no words completes at once. */
  move(cycle) {
    this.due = Infinity;
    if (this.count > 0 && isFlash(this.readAddress) && this.#waitsForFlash(cycle)) return;
    if (this.count > 0 && !this.#transfer(cycle)) return;
    if (this.count > 0) this.#await(cycle + 1);
    else this.#complete(cycle);
  }

  #control(word, cycle) {
    const { enabled, request } = this;
    this.#setControl(word);
    if (this.enabled === enabled && this.request === request) return;
    // A busy channel pauses and continues with EN, and follows a new TREQ_SEL.
    this.#park(request);
    if (this.busy && this.enabled) this.#await(cycle + LATENCY_CYCLES);
  }

  #setControl(word) {
    const { bits, shifts, writable } = this.layout;
    if (word & bits.unknown) this.dma.warn('addresses that fall are not emulated');
    this.errors &= ~word;
    this.ctrl = word & writable;
    this.enabled = (word & BIT.enabled) !== 0;
    this.highPriority = (word & BIT.highPriority) !== 0;
    this.bytes = 1 << ((word >> 2) & 3);
    this.readStep = word & BIT.increasesRead ? this.bytes : 0;
    this.writeStep = word & bits.increasesWrite ? this.bytes : 0;
    this.ring = (word >> shifts.ring) & 15;
    this.chainTo = (word >> shifts.chainTo) & 15;
    this.request = (word >> shifts.request) & 63;
  }

  /**
   * A trigger register was written. Zero (a null trigger) starts nothing, but ends a chain with an interrupt if the
   * channel is quiet.
   */
  #trigger(value, cycle) {
    if (value !== 0) this.start(cycle);
    else if (this.ctrl & this.layout.bits.quiet) this.dma.raise(this.index);
  }

  #park(request) {
    this.due = Infinity;
    this.dma.waiting[request] &= ~(1 << this.index);
  }

  /** Schedules the next word: on this cycle if its request is active, otherwise when the request comes. */
  #await(cycle) {
    const { dma, request } = this;
    const pace = dma.pace(request);
    if (pace > 0) {
      this.pacedCycle += pace;
      this.schedule(Math.max(cycle, Math.ceil(this.pacedCycle)));
    } else if (dma.requested(request)) {
      this.schedule(cycle);
    } else {
      dma.waiting[request] |= 1 << this.index;
    }
  }

  /** The word is moved when it has arrived from flash; until then no channel moves a word. */
  #waitsForFlash(cycle) {
    const readable = this.chip.flash.length > 0;
    const wait = this.fetched || !readable ? 0 : this.dma.cache.readBeside(this.readAddress, cycle);
    this.fetched = wait > 0;
    if (!this.fetched) return false;
    this.dma.hold(cycle + wait);
    this.schedule(cycle + wait);
    return true;
  }

  /** @returns {boolean} false if the bus refused it, which halts the channel */
  #transfer(cycle) {
    this.dma.onAccess(this.readAddress, cycle);
    this.dma.onAccess(this.writeAddress, cycle);
    try {
      this.#store(this.#load());
    } catch (error) {
      if (!(error instanceof Fault)) throw error;
      this.errors |= ERRORS.bus | ERRORS.read | ERRORS.write;
      this.busy = false;
      return false;
    }
    const ringsWrite = (this.ctrl & this.layout.bits.ringsWrite) !== 0;
    this.readAddress = this.#stepped(this.readAddress, this.readStep, !ringsWrite);
    this.writeAddress = this.#stepped(this.writeAddress, this.writeStep, ringsWrite);
    this.count -= 1;
    return true;
  }

  #stepped(address, step, inRing) {
    if (this.ring === 0 || !inRing) return (address + step) >>> 0;
    const mask = (1 << this.ring) - 1;
    return ((address & ~mask) | ((address + step) & mask)) >>> 0;
  }

  #load() {
    const { chip, readAddress: address, bytes } = this;
    const swaps = (this.ctrl & this.layout.bits.swaps) !== 0;
    if (bytes === 1) return chip.readUint8(address);
    if (bytes === 2) return swaps ? swapped(chip.readUint16(address)) >>> 16 : chip.readUint16(address);
    const offset = (address - RAM_START) >>> 2;
    const word = offset < this.ram.length ? this.ram[offset] : chip.readUint32(address);
    return (swaps ? swapped(word) : word) >>> 0;
  }

  #store(value) {
    const { chip, writeAddress: address, bytes } = this;
    if (bytes === 4) chip.writeUint32(address, value);
    else if (bytes === 2) chip.writeUint16(address, value);
    else chip.writeUint8(address, value);
  }

  #complete(cycle) {
    this.busy = false;
    if (!(this.ctrl & this.layout.bits.quiet)) this.dma.raise(this.index);
    if (this.chainTo !== this.index) this.dma.channels[this.chainTo]?.start(cycle);
  }
}

function swapped(word) {
  return (word >>> 24) | ((word >>> 8) & 0xff00) | ((word & 0xff00) << 8) | (word << 24);
}
