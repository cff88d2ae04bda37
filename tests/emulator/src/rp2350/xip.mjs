import { BasePeripheral } from 'rp2040js';
import { Fault } from '../fault.mjs';
import { FLASH_BYTES, hiddenFlash } from '../flash.mjs';
import { SETS } from '../xip-cache.mjs';
import { XipControl } from '../xip-control.mjs';

/** Of an RP2040 alone. */
const FLUSH = 0x04;
/** The first six bits of the addresses of flash without the cache, and of those whose writes are orders to the cache. */
const [UNCACHED, MAINTENANCE] = [0x14000000 >>> 26, 0x18000000 >>> 26];
const OFFSET_MASK = 0x3ffffff;
/** The alias of an RP2040 that neither looks into the cache nor fills it: what a read costs is the same. */
const UNCACHED_ON_RP2040 = 0x13000000;
const [LINE_BYTES_LOG2, ORDER_MASK] = [3, 7];
const INVALIDATE_BY_PLACE = 0;

/**
 * What an RP2350 has besides cached flash (datasheet 4.4): flash that is read past the cache, by words, and addresses at which a write empties
 * a line of the cache by its set and way. Other orders to the cache are not emulated.
 */
export class XipSpace {
  constructor(chip, flash, cache) {
    Object.assign(this, { chip, flash, cache });
  }

  /** Whether an address is one of these. */
  has(address) {
    return address >>> 26 === UNCACHED || address >>> 26 === MAINTENANCE;
  }

  read(address) {
    const offset = address & OFFSET_MASK;
    if (address >>> 26 !== UNCACHED || offset >= FLASH_BYTES) throw new Fault(`a read of 0x${(address >>> 0).toString(16)}, where there is no flash`);
    if (!this.flash.readable) throw new Fault(hiddenFlash(address));
    this.chip.core.cycles += this.cache.read(UNCACHED_ON_RP2040 | offset);
    return new DataView(this.flash.bytes.buffer, this.flash.bytes.byteOffset).getUint32(offset & ~3, true);
  }

  write(address) {
    const order = address & ORDER_MASK;
    if (address >>> 26 !== MAINTENANCE || order !== INVALIDATE_BY_PLACE) throw new Fault(`a write to 0x${(address >>> 0).toString(16)}: of the orders to the cache only those that empty a line by its place are emulated`);
    const line = (address & OFFSET_MASK) >>> LINE_BYTES_LOG2;
    this.cache.emptyLine(line % SETS, (line & SETS) !== 0);
  }
}

/** The cache's control registers, without the one that empties it. */
export class Rp2350XipControl extends XipControl {
  readUint32(offset) {
    return offset === FLUSH ? BasePeripheral.prototype.readUint32.call(this, offset) : super.readUint32(offset);
  }

  writeUint32(offset, value) {
    if (offset === FLUSH) BasePeripheral.prototype.writeUint32.call(this, offset, value);
    else super.writeUint32(offset, value);
  }
}
