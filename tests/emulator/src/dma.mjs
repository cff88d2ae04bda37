import { BasePeripheral } from 'rp2040js';
import { DmaChannel, LATENCY_CYCLES } from './dma-channel.mjs';

const CHANNELS = 12;
const CHANNEL_BYTES = 0x40;
const CHANNELS_END = CHANNELS * CHANNEL_BYTES;
const [INTR, INTE0, INTF0, INTS0, INTE1, INTF1, INTS1] = [0x400, 0x404, 0x408, 0x40c, 0x414, 0x418, 0x41c];
const [TIMER0, TIMER3, MULTI_CHAN_TRIGGER, SNIFF_CTRL, SNIFF_DATA] = [0x420, 0x42c, 0x430, 0x434, 0x438];
const [FIFO_LEVELS, CHAN_ABORT, N_CHANNELS, DEBUG, DEBUG_END] = [0x440, 0x444, 0x448, 0x800, 0x800 + CHANNELS_END];
const DBG_TCR = 0x04;
const IRQ_DMA_0 = 11;
const ALL = (1 << CHANNELS) - 1;
/** Requests: 16 of the PIO blocks', the other peripherals', four timers, and none needed. */
const [PIO_REQUESTS, REQUESTS, FIRST_TIMER, UNPACED] = [16, 64, 59, 63];
/**
 * The DMA (datasheet 2.5): twelve channels, of which one moves a word each cycle, those of high priority first, otherwise
 * in turn. A word is read and written on one cycle, LATENCY_CYCLES after its request.
 */
export class Dma extends BasePeripheral {
  /**
   * @param {import('./lockstep.mjs').Lockstep} lockstep
   * @param {import('./xip-cache.mjs').XipCache} cache
   */
  constructor(chip, name, lockstep, cache) {
    super(chip, name);
    this.cache = cache;
    /** All channels wait while a word comes from flash. */
    this.heldUntil = 0;
    /** Called with every address that is read or written, and its cycle. */
    this.onAccess = () => {};
    this.clock = chip.clock;
    this.lockstep = lockstep;
    this.next = Infinity;
    /** The busy channels that wait for each request, one bit each. */
    this.waiting = new Uint16Array(REQUESTS);
    /** The current levels of the requests of peripherals other than PIO. */
    this.levels = new Uint8Array(REQUESTS);
    this.timers = new Uint32Array(4);
    this.channels = Array.from({ length: CHANNELS }, (_, index) => new DmaChannel(this, index));
    /** The channel that moved a word last. */
    this.last = CHANNELS - 1;
    this.raised = 0;
    this.enabled = [0, 0];
    this.forced = [0, 0];
  }

  /** Moves the word of the channel whose turn it is. */
  tick(cycle) {
    const channel = cycle < this.heldUntil ? null : this.#choose(cycle);
    if (channel !== null) {
      this.last = channel.index;
      channel.move(cycle);
    }
    this.#lookAhead(Math.max(cycle + 1, this.heldUntil));
  }

  /** Moves no word before this cycle. */
  hold(cycle) {
    this.heldUntil = cycle;
  }

  /** A channel wants to move a word on this cycle, or later if others go first. */
  expect(cycle) {
    if (cycle >= this.next) return;
    this.next = cycle;
    this.lockstep.expect(cycle);
  }

  /** A request has come: the PIO blocks call this whenever a FIFO may have changed from "no" to "yes". */
  request(number, cycle) {
    const waiting = this.waiting[number];
    if (waiting === 0) return;
    this.waiting[number] = 0;
    for (let left = waiting; left !== 0; left &= left - 1) this.channels[31 - Math.clz32(left & -left)].schedule(cycle + LATENCY_CYCLES);
  }

  /** rp2040js's peripherals call this when they request, and clearDREQ when they no longer do. */
  setDREQ(number) {
    this.levels[number] = 1;
    this.request(number, this.clock.cycles);
  }

  clearDREQ(number) {
    this.levels[number] = 0;
  }

  /** Whether a request is active. */
  requested(number) {
    if (number >= PIO_REQUESTS) return number === UNPACED || this.levels[number] !== 0;
    return this.rp2040.pio[number >> 3].requests(number & 7);
  }

  /** Cycles between two words of a pacing timer (X words in Y cycles); 0 if the request is not a timer. */
  pace(number) {
    if (number < FIRST_TIMER || number >= UNPACED) return 0;
    const timer = this.timers[number - FIRST_TIMER];
    return timer >>> 16 === 0 ? Infinity : Math.max(1, (timer & 0xffff) / (timer >>> 16));
  }

  /** A channel's interrupt, on both lines if they are enabled. */
  raise(index) {
    this.raised |= 1 << index;
    this.#interrupt();
  }

  trigger(channels, cycle) {
    for (const channel of this.channels) if ((channels >> channel.index) & 1) channel.start(cycle);
  }

  readUint32(offset) {
    if (offset < CHANNELS_END) return this.channels[Math.floor(offset / CHANNEL_BYTES)].read(offset % CHANNEL_BYTES);
    if (offset >= TIMER0 && offset <= TIMER3) return this.timers[(offset - TIMER0) >> 2];
    if (offset >= DEBUG && offset < DEBUG_END) return this.#debug(offset - DEBUG);
    switch (offset) {
      case INTR:
        return this.raised;
      case INTE0:
        return this.enabled[0];
      case INTF0:
        return this.forced[0];
      case INTS0:
        return this.#status(0);
      case INTE1:
        return this.enabled[1];
      case INTF1:
        return this.forced[1];
      case INTS1:
        return this.#status(1);
      case MULTI_CHAN_TRIGGER:
      case FIFO_LEVELS:
      case CHAN_ABORT: // an abort is over at once
        return 0;
      case N_CHANNELS:
        return CHANNELS;
    }
    return super.readUint32(offset);
  }

  writeUint32(offset, value) {
    const { cycles } = this.clock;
    if (offset < CHANNELS_END) return this.channels[Math.floor(offset / CHANNEL_BYTES)].write(offset % CHANNEL_BYTES, value, cycles);
    if (offset >= DEBUG && offset < DEBUG_END) return undefined;
    if (offset >= TIMER0 && offset <= TIMER3) {
      this.timers[(offset - TIMER0) >> 2] = value;
      return undefined;
    }
    switch (offset) {
      case INTR:
      case INTS0:
      case INTS1:
        this.raised &= ~this.rawWriteValue;
        return this.#interrupt();
      case INTE0:
      case INTE1:
        this.enabled[offset === INTE1 ? 1 : 0] = value & ALL;
        return this.#interrupt();
      case INTF0:
      case INTF1:
        this.forced[offset === INTF1 ? 1 : 0] = value & ALL;
        return this.#interrupt();
      case MULTI_CHAN_TRIGGER:
        return this.trigger(value, cycles);
      case CHAN_ABORT:
        for (const channel of this.channels) if ((value >> channel.index) & 1) channel.abort();
        return undefined;
      case SNIFF_CTRL:
      case SNIFF_DATA:
        return this.warn('the sniffer is not emulated');
    }
    return super.writeUint32(offset, value);
  }

  /** The first channel after the last one that is due, or the first of high priority. */
  #choose(cycle) {
    const { channels } = this;
    let chosen = null;
    for (let turn = 0, index = this.last; turn < CHANNELS; turn++) {
      index = index === CHANNELS - 1 ? 0 : index + 1;
      const channel = channels[index];
      if (channel.due > cycle) continue;
      if (channel.highPriority) return channel;
      chosen ??= channel;
    }
    return chosen;
  }

  #lookAhead(earliest) {
    const { channels } = this;
    let next = Infinity;
    for (let index = 0; index < CHANNELS; index++) {
      if (channels[index].due < next) next = channels[index].due;
    }
    this.next = Math.max(next, earliest);
  }

  #status(line) {
    return (this.raised & this.enabled[line]) | this.forced[line];
  }

  #interrupt() {
    this.rp2040.setInterrupt(IRQ_DMA_0, this.#status(0) !== 0);
    this.rp2040.setInterrupt(IRQ_DMA_0 + 1, this.#status(1) !== 0);
  }

  /** DBG_TCR: the count with which the next trigger begins. Requests are never stored (DBG_CTDREQ). */
  #debug(offset) {
    const channel = this.channels[Math.floor(offset / CHANNEL_BYTES)];
    return offset % CHANNEL_BYTES === DBG_TCR ? channel.reload : 0;
  }
}
