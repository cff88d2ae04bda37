import { BasePeripheral } from 'rp2040js';
import { FlashCommand } from './flash-command.mjs';

const [CTRLR0, SSIENR, BAUDR, SR, IDR, VERSION, DR0, SPI_CTRLR0, LAST] = [0x00, 0x08, 0x14, 0x28, 0x58, 0x5c, 0x60, 0xf4, 0xfc];
const [IDENTITY, VERSION_ID] = [0x51535049, 0x3430312a];
/** The transfer mode in CTRLR0: sends and receives, or reads like an EEPROM, which makes flash appear in memory. */
const TRANSFER_MODE = 3 << 8;
const EEPROM_READ = 3 << 8;
/** The bits of a frame less one, in CTRLR0: a word of memory, or a byte of a command. */
const [FRAME, WORD_FRAME, BYTE_FRAME] = [0x1f << 16, 31 << 16, 7 << 16];
/** Status: room to send, nothing left to send, an answer to read. The interface is never busy. */
const READY = (1 << 1) | (1 << 2) | (1 << 3);
const READ_STATUS_2 = 0x35;
/** The flash chip's QE bit, which enables its four data lines. */
const QUAD_ENABLED = 0x02;
/** Data lines by CTRLR0's SPI_FRF, and bits of the instruction by SPI_CTRLR0's INST_L. */
const LINES = [1, 2, 4, 4];
const INSTRUCTION_BITS = [0, 4, 8, 16];
/** The contents of the registers, depending on who has set them up. */
const SET_UPS = {
  /** The ROM, for plain commands: frames of 8 bits. */
  commands: { ctrlr0: 0x00070000, spiCtrlr0: 0, baud: 6 },
  /** The ROM, to show flash: reads by command 03 over one line. */
  slowFlash: { ctrlr0: 0x001f0300, spiCtrlr0: 0x03000218, baud: 6 },
  /** The second stage for the W25Q080, with its usual divider: reads by four lines that need no command. */
  quickFlash: { ctrlr0: 0x005f0300, spiCtrlr0: 0xa0002022, baud: 2 },
};

/**
 * The serial interface to flash, as far as a second-stage bootloader and reading the unique identifier need it.
 * Registers keep what is written. A command is answered at once: status registers with ready and QUAD; in EEPROM mode
 * with frames of a byte as `FlashCommand` says; everything else with zeros. What matters is whether it shows flash in
 * memory, which it does while it is on and in its EEPROM mode with frames of a word, and how long a read then takes.
 */
export class Ssi extends BasePeripheral {
  /** @param {() => void} onChange */
  constructor(chip, name, onChange) {
    super(chip, name);
    this.onChange = onChange;
    this.registers = new Uint32Array(LAST / 4 + 1);
    this.answer = 0;
    this.command = new FlashCommand();
    this.#setUp(SET_UPS.quickFlash);
  }

  /** Without a divider there is no clock. */
  get showsFlash() {
    return this.#reads(WORD_FRAME);
  }

  /** Cycles of the system clock for one word of flash: instruction, address with its mode bits, wait and data. */
  get wordCycles() {
    const control = this.registers[CTRLR0 / 4];
    const transfer = this.registers[SPI_CTRLR0 / 4];
    const lines = LINES[(control >>> 21) & 3];
    const kind = transfer & 3;
    const instruction = INSTRUCTION_BITS[(transfer >>> 8) & 3] / (kind === 2 ? lines : 1);
    const address = (4 * ((transfer >>> 2) & 15)) / (kind === 0 ? 1 : lines);
    const wait = (transfer >>> 11) & 31;
    const data = (((control >>> 16) & 31) + 1) / lines;
    return (instruction + address + wait + data) * this.#divider;
  }

  /** Sets the interface up like the ROM: for plain commands, or to show flash. */
  set({ showsFlash }) {
    this.#setUp(showsFlash ? SET_UPS.slowFlash : SET_UPS.commands);
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
        return this.#reads(BYTE_FRAME) ? this.command.receive() : this.answer;
    }
    return this.registers[offset / 4] ?? super.readUint32(offset);
  }

  writeUint32(offset, value) {
    if (offset > LAST) return super.writeUint32(offset, value);
    if (offset === DR0) this.#send(value & 0xff);
    else this.registers[offset / 4] = value;
    // Switching the interface off deselects the chip.
    if (offset === SSIENR) this.command.begin();
    this.onChange();
  }

  #send(byte) {
    if (this.#reads(BYTE_FRAME)) this.command.send(byte);
    this.answer = byte === READ_STATUS_2 ? QUAD_ENABLED : 0;
  }

  /** Whether it is on, and sends a command and then reads in frames of this size. */
  #reads(frame) {
    const control = this.registers[CTRLR0 / 4];
    return this.registers[SSIENR / 4] === 1 && this.#divider > 0 && (control & TRANSFER_MODE) === EEPROM_READ && (control & FRAME) === frame;
  }

  /** The last bit of the divider is ignored. */
  get #divider() {
    return this.registers[BAUDR / 4] & 0xfffe;
  }

  #setUp({ ctrlr0, spiCtrlr0, baud }) {
    this.registers[CTRLR0 / 4] = ctrlr0;
    this.registers[SPI_CTRLR0 / 4] = spiCtrlr0;
    this.registers[BAUDR / 4] = baud;
    this.registers[SSIENR / 4] = 1;
  }
}
