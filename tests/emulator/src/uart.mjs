import { BasePeripheral } from 'rp2040js';

const [DR, RSR, FR, IBRD, FBRD, LCR_H, CR, IFLS] = [0x00, 0x04, 0x18, 0x24, 0x28, 0x2c, 0x30, 0x34];
const [IMSC, RIS, MIS, ICR, DMACR] = [0x38, 0x3c, 0x40, 0x44, 0x48];
const FLAG = { busy: 1 << 3, rxEmpty: 1 << 4, txFull: 1 << 5, rxFull: 1 << 6, txEmpty: 1 << 7 };
const INTERRUPT = { rx: 1 << 4, tx: 1 << 5, rxTimeout: 1 << 6, overrun: 1 << 10 };
const FIFO_DEPTH = 32;
const BITS_PER_BYTE = 10;
const RX_TIMEOUT_BITS = 32;
/** IFLS: the level at which a FIFO raises its interrupt, in bytes. */
const LEVELS = [4, 8, 16, 24, 28];
const OVERRUN_ERROR = 1 << 11;

/**
 * A UART, a PL011 (datasheet 4.2): FIFOs, interrupt levels, the receive time-out and bytes that take their time on the
 * wire. rp2040js's sends at once and keeps its transmit interrupt raised, under which a buffered driver never returns.
 * Frames are 8N1; there are no line errors other than an overrun.
 */
export class Uart extends BasePeripheral {
  /** @param {(byte: number) => void} onByte a byte has left the chip */
  constructor(chip, name, irq, onByte) {
    super(chip, name);
    this.irq = irq;
    this.onByte = onByte;
    /** A byte begins to leave the chip. @type {(byte: number) => void} */
    this.onStart = () => {};
    this.registers = new Map([[IBRD, 0], [FBRD, 0], [LCR_H, 0], [CR, 0x300], [IFLS, 0x12], [DMACR, 0]]);
    this.mask = 0;
    this.raised = 0;
    this.rx = [];
    this.tx = [];
    this.overrunPending = false;
    this.shifting = null;
    this.shiftAlarm = chip.clock.createAlarm(() => this.#shifted());
    this.rxTimeoutAlarm = chip.clock.createAlarm(() => this.#raise(INTERRUPT.rxTimeout));
  }

  /** Cycles a bit takes on the wire; 0 while the firmware has not set the baud rate. */
  get bitCycles() {
    return 16 * (this.registers.get(IBRD) + this.registers.get(FBRD) / 64);
  }

  get byteCycles() {
    return Math.round(BITS_PER_BYTE * this.bitCycles);
  }

  /** Whether bytes leave the chip. */
  get sends() {
    return (this.registers.get(CR) & 0x101) === 0x101;
  }

  get ready() {
    return (this.registers.get(CR) & 0x201) === 0x201 && this.bitCycles > 0;
  }

  /** A byte arrives on the wire. */
  receive(byte) {
    if (this.rx.length >= FIFO_DEPTH) {
      this.overrunPending = true;
      return this.#raise(INTERRUPT.overrun);
    }
    this.rx.push(this.overrunPending ? byte | OVERRUN_ERROR : byte);
    this.overrunPending = false;
    this.rxTimeoutAlarm.scheduleAt(this.rp2040.clock.cycles + Math.round(RX_TIMEOUT_BITS * this.bitCycles));
    if (this.rx.length >= this.#level(3)) this.#raise(INTERRUPT.rx);
  }

  readUint32(offset) {
    switch (offset) {
      case DR:
        return this.#read();
      case RSR:
        return 0;
      case FR:
        return this.#flags();
      case IMSC:
        return this.mask;
      case RIS:
        return this.raised;
      case MIS:
        return this.raised & this.mask;
    }
    return this.registers.get(offset) ?? super.readUint32(offset);
  }

  writeUint32(offset, value) {
    if (offset === DR) {
      this.#write(value & 0xff);
    } else if (offset === IMSC) {
      this.mask = value & 0x7ff;
      this.#interrupt();
    } else if (offset === ICR) {
      this.raised &= ~this.rawWriteValue;
      this.#interrupt();
    } else if (this.registers.has(offset)) {
      this.registers.set(offset, value);
    } else if (offset !== RSR) {
      super.writeUint32(offset, value);
    }
  }

  #level(shift) {
    return LEVELS[(this.registers.get(IFLS) >> shift) & 7] ?? LEVELS[2];
  }

  #flags() {
    return (
      (this.shifting === null ? 0 : FLAG.busy) |
      (this.rx.length === 0 ? FLAG.rxEmpty : 0) |
      (this.rx.length >= FIFO_DEPTH ? FLAG.rxFull : 0) |
      (this.tx.length === 0 ? FLAG.txEmpty : 0) |
      (this.tx.length >= FIFO_DEPTH ? FLAG.txFull : 0)
    );
  }

  #read() {
    const byte = this.rx.shift() ?? 0;
    if (this.rx.length < this.#level(3)) this.raised &= ~INTERRUPT.rx;
    if (this.rx.length === 0) {
      this.rxTimeoutAlarm.cancel();
      this.raised &= ~INTERRUPT.rxTimeout;
    }
    this.#interrupt();
    return byte;
  }

  #write(byte) {
    if (this.shifting === null) this.#shift(byte);
    else if (this.tx.length < FIFO_DEPTH) this.tx.push(byte);
  }

  #shift(byte) {
    this.shifting = byte;
    this.shiftAlarm.scheduleAt(this.rp2040.clock.cycles + Math.max(1, this.byteCycles));
    this.onStart(byte);
  }

  #shifted() {
    const byte = this.shifting;
    this.shifting = null;
    if (this.tx.length > 0) {
      this.#shift(this.tx.shift());
      // The interrupt marks the passing of the level, not the level.
      if (this.tx.length === this.#level(0)) this.#raise(INTERRUPT.tx);
    }
    this.onByte(byte);
  }

  #raise(interrupt) {
    this.raised |= interrupt;
    this.#interrupt();
  }

  #interrupt() {
    this.rp2040.setInterrupt(this.irq, (this.raised & this.mask) !== 0);
  }
}
