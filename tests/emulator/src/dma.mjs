import { BasePeripheral } from 'rp2040js';
import { DmaChannel, LATENCY_CYCLES } from './dma-channel.mjs';
import { RP2040 } from './dma-layout.mjs';

const CHANNEL_BYTES = 0x40;
const [INTR, INTE0, INTF0, INTS0, INTE1, INTF1, INTS1] = [0x400, 0x404, 0x408, 0x40c, 0x414, 0x418, 0x41c];
const DEBUG = 0x800;
const TIMERS = 4;
const DBG_TCR = 0x04;
/** Requests: the PIO blocks', the other peripherals', four timers, and none needed. */
const [REQUESTS, FIRST_TIMER, UNPACED] = [64, 59, 63];
/**
 * The DMA (datasheet 2.5): channels, of which one moves a word each cycle, those of high priority first, otherwise
 * in turn. A word is read and written on one cycle, LATENCY_CYCLES after its request.
 */
export class Dma extends BasePeripheral {
  /**
   * @param {import('./lockstep.mjs').Lockstep} lockstep
   * @param {import('./xip-cache.mjs').XipCache} cache
   * @param {import('./dma-layout.mjs').DmaLayout} layout that of the chip
   */
  constructor(chip, name, lockstep, cache, layout = RP2040) {
    super(chip, name);
    this.layout = layout;
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
    this.timers = new Uint32Array(TIMERS);
    this.channels = Array.from({ length: layout.channels }, (_, index) => new DmaChannel(this, index));
    this.all = (1 << layout.channels) - 1;
    this.channelsEnd = layout.channels * CHANNEL_BYTES;
    /** The channel that moved a word last. */
    this.last = layout.channels - 1;
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
    if (number >= this.layout.pioRequests) return number === UNPACED || this.levels[number] !== 0;
    return this.rp2040.pio[number >> 3]?.requests(number & 7) ?? false;
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
    const { registers } = this.layout;
    if (offset < this.channelsEnd) return this.channels[Math.floor(offset / CHANNEL_BYTES)].read(offset % CHANNEL_BYTES);
    if (offset >= registers.timer0 && offset < registers.timer0 + 4 * TIMERS) return this.timers[(offset - registers.timer0) >> 2];
    if (offset >= DEBUG && offset < DEBUG + this.channelsEnd) return this.#debug(offset - DEBUG);
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
      case registers.multiChanTrigger:
      case registers.fifoLevels:
      case registers.chanAbort: // an abort is over at once
        return 0;
      case registers.nChannels:
        return this.layout.channels;
    }
    return super.readUint32(offset);
  }

  writeUint32(offset, value) {
    const { cycles } = this.clock;
    const { registers } = this.layout;
    if (offset < this.channelsEnd) return this.channels[Math.floor(offset / CHANNEL_BYTES)].write(offset % CHANNEL_BYTES, value, cycles);
    if (offset >= DEBUG && offset < DEBUG + this.channelsEnd) return undefined;
    if (offset >= registers.timer0 && offset < registers.timer0 + 4 * TIMERS) {
      this.timers[(offset - registers.timer0) >> 2] = value;
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
        this.enabled[offset === INTE1 ? 1 : 0] = value & this.all;
        return this.#interrupt();
      case INTF0:
      case INTF1:
        this.forced[offset === INTF1 ? 1 : 0] = value & this.all;
        return this.#interrupt();
      case registers.multiChanTrigger:
        return this.trigger(value, cycles);
      case registers.chanAbort:
        for (const channel of this.channels) if ((value >> channel.index) & 1) channel.abort();
        return undefined;
      case registers.sniffCtrl:
      case registers.sniffData:
        return this.warn('the sniffer is not emulated');
    }
    return super.writeUint32(offset, value);
  }

  /** The first channel after the last one that is due, or the first of high priority. */
  #choose(cycle) {
    const { channels } = this;
    const { length } = channels;
    let chosen = null;
    for (let turn = 0, index = this.last; turn < length; turn++) {
      index = index === length - 1 ? 0 : index + 1;
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
    for (let index = 0; index < channels.length; index++) {
      if (channels[index].due < next) next = channels[index].due;
    }
    this.next = Math.max(next, earliest);
  }

  #status(line) {
    return (this.raised & this.enabled[line]) | this.forced[line];
  }

  #interrupt() {
    this.layout.interrupts.forEach((irq, line) => this.rp2040.setInterrupt(irq, this.#status(line) !== 0));
  }

  /** DBG_TCR: the count with which the next trigger begins. Requests are never stored (DBG_CTDREQ). */
  #debug(offset) {
    const channel = this.channels[Math.floor(offset / CHANNEL_BYTES)];
    return offset % CHANNEL_BYTES === DBG_TCR ? channel.reload : 0;
  }
}
