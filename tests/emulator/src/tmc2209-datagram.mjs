const SYNC = 0x05;
const SYNC_BITS = 0x0f;
export const WRITE = 0x80;
/** The address of answers: the controller's. */
const CONTROLLER = 0xff;
const [REQUEST_BYTES, DATA_BYTES] = [4, 8];
const BITS_PER_BYTE = 10;
/** Between the starts of two bytes of a datagram at most; and idle before the next one, after an error. In bit times. */
const [LONGEST_GAP_BITS, RECOVERY_BITS] = [63, 12];
const POLYNOMIAL = 0x07;

/** CRC8-ATM of a datagram without its last byte, each byte from its lowest bit (data sheet 4.2). @param {number[]} bytes */
export function crc8(bytes) {
  let crc = 0;
  for (const byte of bytes) {
    for (let bit = 0; bit < 8; bit++) {
      const carry = (crc >> 7) ^ ((byte >> bit) & 1);
      crc = ((crc << 1) & 0xff) ^ (carry ? POLYNOMIAL : 0);
    }
  }
  return crc;
}

/** The answer to a read request: eight bytes. */
export function answer(register, value) {
  const bytes = [SYNC, CONTROLLER, register, value >>> 24, (value >>> 16) & 0xff, (value >>> 8) & 0xff, value & 0xff];
  return [...bytes, crc8(bytes)];
}

/** Finds the datagrams among the bytes on the wire, by the data sheet's rules of time and recovery (4.1.1). */
export class DatagramReader {
  #bytes = [];
  #lastEnd = -Infinity;
  /** After an error nothing is taken until the wire has been idle. */
  #lost = false;

  /**
   * A byte has ended on this cycle.
   *
   * @returns {{address: number, register: number, write: boolean, value: number, intact: boolean} | null} the datagram that it completes
   */
  hear(byte, cycle, bitCycles) {
    const idleBits = (cycle - this.#lastEnd) / bitCycles - BITS_PER_BYTE;
    this.#lastEnd = cycle;
    if (this.#lost && idleBits < RECOVERY_BITS) return null;
    if (idleBits + BITS_PER_BYTE > LONGEST_GAP_BITS) this.#bytes = [];
    this.#lost = false;
    this.#bytes.push(byte);
    if ((this.#bytes[0] & SYNC_BITS) !== SYNC) return this.#fail();
    return this.#bytes.length === this.#length() ? this.#complete() : null;
  }

  #length() {
    const [, address, register] = this.#bytes;
    return address === CONTROLLER || (register & WRITE) !== 0 ? DATA_BYTES : REQUEST_BYTES;
  }

  #complete() {
    const [, address, register, ...data] = this.#bytes;
    const crc = data.pop();
    const intact = crc === crc8(this.#bytes.slice(0, -1));
    this.#bytes = [];
    this.#lost = !intact;
    const value = data.reduce((sum, byte) => ((sum << 8) | byte) >>> 0, 0);
    return { address, register: register & ~WRITE, write: (register & WRITE) !== 0, value, intact };
  }

  #fail() {
    this.#bytes = [];
    this.#lost = true;
    return null;
  }
}
