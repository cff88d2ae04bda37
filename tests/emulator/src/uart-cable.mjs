import { cyclesOfMillis } from './clock.mjs';

const NOT_READY_CYCLES = cyclesOfMillis(1);

/** A serial cable to UART0. Bytes go out one after another, at the baud rate that the firmware has set. */
export class UartCable {
  /** @param {{onData: (bytes: Uint8Array) => void, onDelivered: (bytes: Uint8Array) => void}} listener from and to the chip */
  constructor(clock, listener) {
    this.clock = clock;
    this.listener = listener;
    this.queue = [];
    this.wire = clock.createOutsideAlarm(() => this.#arrived());
  }

  attach(_chip, uart) {
    this.uart = uart;
  }

  write(bytes) {
    this.queue.push(...bytes);
    this.#pump();
  }

  /** Bytes that have not reached the chip yet. */
  get unsent() {
    return this.queue.length;
  }

  setDtr() {
    throw new Error('three wires have no DTR: use --console usb');
  }

  setLineCoding() {
    throw new Error('the rate of a UART is not reported on its wires: use --console usb');
  }

  setReading() {
    throw new Error('a UART sends whether anyone reads or not: use --console usb');
  }

  /** A byte from the chip. */
  received(byte) {
    this.listener.onData(Uint8Array.of(byte));
  }

  #pump() {
    if (this.wire.scheduled || this.queue.length === 0) return;
    this.wire.scheduleAt(this.clock.cycles + (this.uart.ready ? this.uart.byteCycles : NOT_READY_CYCLES));
  }

  #arrived() {
    if (this.uart.ready) this.#deliver(this.queue.shift());
    this.#pump();
  }

  #deliver(byte) {
    this.uart.receive(byte);
    this.listener.onDelivered(Uint8Array.of(byte));
  }
}
