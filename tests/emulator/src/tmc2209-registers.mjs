/** The registers' addresses (data sheet, chapter 5). NODECONF was SLAVECONF in older editions. */
export const REGISTER = {
  GCONF: 0x00,
  GSTAT: 0x01,
  IFCNT: 0x02,
  NODECONF: 0x03,
  OTP_READ: 0x05,
  IOIN: 0x06,
  FACTORY_CONF: 0x07,
  IHOLD_IRUN: 0x10,
  TPOWERDOWN: 0x11,
  TSTEP: 0x12,
  TPWMTHRS: 0x13,
  TCOOLTHRS: 0x14,
  SGTHRS: 0x40,
  SG_RESULT: 0x41,
  COOLCONF: 0x42,
  MSCNT: 0x6a,
  CHOPCONF: 0x6c,
  DRV_STATUS: 0x6f,
  PWMCONF: 0x70,
};

/** What each chip has burnt into it: its clock trimmed to 12 MHz, and all else 0. */
export const CLOCK_TRIM = 14;

const { GCONF, NODECONF, FACTORY_CONF, IHOLD_IRUN, TPOWERDOWN, TPWMTHRS, TCOOLTHRS, SGTHRS, COOLCONF, CHOPCONF, PWMCONF } = REGISTER;

/** Those that keep what is written: their bits, their value at power-up, and whether it can be read again. */
const KEPT = new Map([
  [GCONF, { bits: 0x3ff, reset: 0x101, readable: true }],
  [NODECONF, { bits: 0xf00, reset: 0, readable: false }],
  [FACTORY_CONF, { bits: 0x31f, reset: CLOCK_TRIM, readable: true }],
  [IHOLD_IRUN, { bits: 0xf1f1f, reset: 0x11f10, readable: false }],
  [TPOWERDOWN, { bits: 0xff, reset: 20, readable: false }],
  [TPWMTHRS, { bits: 0xfffff, reset: 0, readable: false }],
  [TCOOLTHRS, { bits: 0xfffff, reset: 0, readable: false }],
  [SGTHRS, { bits: 0xff, reset: 0, readable: false }],
  [COOLCONF, { bits: 0xffff, reset: 0, readable: false }],
  [CHOPCONF, { bits: 0xffffffff, reset: 0x10000053, readable: true }],
  [PWMCONF, { bits: 0xffffffff, reset: 0xc10d0024, readable: true }],
]);

/** The registers that keep what is written into them. */
export class Registers {
  #values = new Map();

  constructor() {
    this.reset();
  }

  reset() {
    for (const [register, { reset }] of KEPT) this.#values.set(register, reset);
  }

  /** Nothing happens to a register that keeps nothing. */
  write(register, value) {
    const kept = KEPT.get(register);
    if (kept !== undefined) this.#values.set(register, (value & kept.bits) >>> 0);
  }

  /** What the wire reads: 0 of a register that can only be written. */
  read(register) {
    return KEPT.get(register)?.readable ? this.#values.get(register) : 0;
  }

  /** What the driver itself sees: `width` bits from `low` on. */
  field(register, low = 0, width = 32) {
    return Math.floor(this.#values.get(register) / 2 ** low) % 2 ** width;
  }
}
