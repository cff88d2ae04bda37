import { BasePeripheral } from 'rp2040js';

const [CTRLR0, SSIENR, SR, IDR, VERSION, DR0, LAST] = [0x00, 0x08, 0x28, 0x58, 0x5c, 0x60, 0xfc];
const [IDENTITY, VERSION_ID] = [0x51535049, 0x3430312a];
/** The transfer mode in CTRLR0: sends and receives, or reads as an EEPROM is read, which is how flash appears in memory. */
const TRANSFER_MODE = 3 << 8;
const EEPROM_READ = 3 << 8;
/** Room to send, nothing left to send, an answer to read; never busy. */
const READY = (1 << 1) | (1 << 2) | (1 << 3);
const READ_STATUS_2 = 0x35;
/** The flash chip's QE bit: its four data lines are in use. */
const QUAD_ENABLED = 0x02;

/**
 * The serial interface to flash, as far as a second-stage bootloader needs it: registers keep what is written, and a command
 * is answered at once: the status registers say ready and QUAD, anything else is answered by zeros. What counts is
 * whether it shows flash in memory, which it does while it is on and in its EEPROM mode.
 */
export class Ssi extends BasePeripheral {
  /** @param {() => void} onChange */
  constructor(chip, name, onChange) {
    super(chip, name);
    this.onChange = onChange;
    this.registers = new Uint32Array(LAST / 4 + 1);
    this.answer = 0;
    this.#setUp(true);
  }

  get showsFlash() {
    return this.registers[SSIENR / 4] === 1 && (this.registers[CTRLR0 / 4] & TRANSFER_MODE) === EEPROM_READ;
  }

  /** Sets it up as the ROM does: for plain commands, or to show flash. */
  set({ showsFlash }) {
    this.#setUp(showsFlash);
    this.onChange();
  }

  readUint32(offset) {
    switch (offset) {
      case SR:
        return READY;
      case IDR:
        return IDENTITY;
      case VERSION:
        return VERSION_ID;
      case DR0:
        return this.answer;
    }
    return this.registers[offset / 4] ?? super.readUint32(offset);
  }

  writeUint32(offset, value) {
    if (offset > LAST) return super.writeUint32(offset, value);
    if (offset === DR0) this.answer = (value & 0xff) === READ_STATUS_2 ? QUAD_ENABLED : 0;
    else this.registers[offset / 4] = value;
    this.onChange();
  }

  #setUp(showsFlash) {
    this.registers[CTRLR0 / 4] = showsFlash ? EEPROM_READ : 0;
    this.registers[SSIENR / 4] = 1;
  }
}
