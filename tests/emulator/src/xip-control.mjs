import { BasePeripheral } from 'rp2040js';

const [CTRL, FLUSH, STAT, CTR_HIT, CTR_ACC, STREAM_ADDR, STREAM_CTR] = [0x00, 0x04, 0x08, 0x0c, 0x10, 0x14, 0x18];
const [ENABLED, ERRORS, POWERED_DOWN] = [1 << 0, 1 << 1, 1 << 3];
const [FLUSHED, STREAM_EMPTY] = [1 << 0, 1 << 1];
const MOST = 0xffffffff;

/** The cache's control registers. Streaming from flash in the background is not emulated: its FIFO is empty. */
export class XipControl extends BasePeripheral {
  /** @param {import('./xip-cache.mjs').XipCache} cache */
  constructor(chip, name, cache) {
    super(chip, name);
    this.core = chip.core;
    this.clock = chip.clock;
    this.cache = cache;
    /** Without the bit that enables the cache, which the ROM changes too. */
    this.ctrl = ERRORS;
    /** The board's counts at the time at which the chip's own counters were cleared. */
    this.clearedAt = { hits: cache.counts.hits, accesses: cache.counts.accesses };
  }

  readUint32(offset) {
    switch (offset) {
      case CTRL:
        return this.ctrl | (this.cache.enabled ? ENABLED : 0);
      case FLUSH:
        return this.#waitForFlush();
      case STAT:
        return STREAM_EMPTY | (this.clock.cycles < this.cache.flushedCycle ? 0 : FLUSHED);
      case CTR_HIT:
        return this.#counted('hits');
      case CTR_ACC:
        return this.#counted('accesses');
      case STREAM_ADDR:
      case STREAM_CTR:
        return 0;
    }
    return super.readUint32(offset);
  }

  writeUint32(offset, value) {
    if (offset === CTRL) this.#control(value);
    else if (offset === FLUSH) this.#flush(value);
    else if (offset === CTR_HIT) this.clearedAt.hits = this.cache.counts.hits;
    else if (offset === CTR_ACC) this.clearedAt.accesses = this.cache.counts.accesses;
    // A stream of no words is a stopped stream.
    else if (offset > CTR_ACC && value !== 0) super.writeUint32(offset, value);
  }

  /** The cache cannot be enabled without power. */
  #control(value) {
    this.ctrl = value & (ERRORS | POWERED_DOWN);
    this.cache.enable((value & (ENABLED | POWERED_DOWN)) === ENABLED);
  }

  #flush(value) {
    if (value & 1) this.cache.flush();
  }

  /** Reading the register waits until the flush has ended. */
  #waitForFlush() {
    this.core.cycles += Math.max(0, this.cache.flushedCycle - this.clock.cycles);
    return 0;
  }

  #counted(what) {
    return Math.min(MOST, this.cache.counts[what] - this.clearedAt[what]);
  }
}
