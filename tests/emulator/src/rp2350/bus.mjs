import { Bus } from '../bus.mjs';

/** Memory is below; a register is read and written at its own address alone. */
const PERIPHERALS_PAGE = 4;

const isPlain = (address, mask) => (address & mask) === 0 || address >>> 28 >= PERIPHERALS_PAGE;

/** A Cortex-M33 reads and writes words and half-words at any address of memory. */
export class Rp2350Bus extends Bus {
  read32(address) {
    if (isPlain(address, 3)) return super.read32(address);
    return this.read16(address) | (this.read16((address + 2) | 0) << 16);
  }

  read16(address) {
    if (isPlain(address, 1)) return super.read16(address);
    return this.read8(address) | (this.read8((address + 1) | 0) << 8);
  }

  write32(address, value) {
    if (isPlain(address, 3)) return super.write32(address, value);
    this.write16(address, value & 0xffff);
    return this.write16((address + 2) | 0, value >>> 16);
  }

  write16(address, value) {
    if (isPlain(address, 1)) return super.write16(address, value);
    this.write8(address, value & 0xff);
    return this.write8((address + 1) | 0, (value >>> 8) & 0xff);
  }
}
