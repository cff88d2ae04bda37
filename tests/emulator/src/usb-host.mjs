import { bulkEndpoints } from './usb-descriptors.mjs';
import { UsbFrames } from './usb-frames.mjs';

const AVAILABLE = 1 << 10;
const STALL = 1 << 11;
const FULL = 1 << 15;
const LENGTH_MASK = 0x3ff;
const [BUFFER_CONTROL_START, BUFFER_CONTROL_END] = [0x80, 0x100];
const PACKET_BYTES = 64;
/** Full speed: 12 Mbit/s, and some 13 bytes of token, header, check and handshake around a packet's data. */
const NANOS_PER_WIRE_BYTE = 8e9 / 12e6;
const OVERHEAD_BYTES = 13;
/** The 10 ms for which a host leaves a device alone after a bus reset. */
const RESET_RECOVERY_NANOS = 10e6;
const CONFIGURATION = 2;
const CONFIGURATION_HEADER_BYTES = 9;
const DTR_AND_RTS = 3;
const USUAL_BAUD = 115200;
/** Length of SET_LINE_CODING's data; 8N1 is used. */
const LINE_CODING_BYTES = 7;

const setup = (type, request, value, index, length) =>
  Uint8Array.of(type, request, value & 0xff, value >> 8, index & 0xff, index >> 8, length & 0xff, length >> 8);
const getDescriptor = (length) => setup(0x80, 6, CONFIGURATION << 8, 0, length);

/**
 * A USB host with a CDC-ACM driver, on the other end of rp2040js's controller.
 *
 * There is one transaction at a time on the wire, and each takes its time. A buffer belongs to the controller
 * (AVAILABLE) until its transaction has ended; that is how a driver learns that there is something to read. rp2040js's
 * own helper returns every buffer at once, padded with zeros.
 */
export class UsbHost {
  /**
   * @param {{onData: (bytes: Uint8Array) => void, onDelivered: (bytes: Uint8Array) => void}} listener from and to the chip
   * @param {number} framePpm how much longer its frames are than the chip's milliseconds
   */
  constructor(clock, listener, framePpm = 0) {
    this.clock = clock;
    this.listener = listener;
    this.frames = new UsbFrames(clock, framePpm);
    this.wire = clock.createOutsideAlarm(() => this.#transacted());
    this.recovery = clock.createOutsideAlarm(() => this.#start());
  }

  /** Plugs the cable into a chip that has just been powered or reset. */
  attach(chip) {
    this.chip = chip;
    this.usb = chip.usbCtrl;
    this.armed = new Set();
    this.queue = [];
    this.endpoints = null;
    this.control = null;
    this.transaction = null;
    this.requests = null;
    this.waiting = [];
    this.reading = true;
    this.dtr = false;
    this.wire.cancel();
    this.recovery.cancel();
    this.usb.onUSBEnabled = () => this.usb.resetDevice();
    this.frames.attach(this.usb);
    this.usb.onResetReceived = () => {
      this.frames.start();
      this.recovery.schedule(RESET_RECOVERY_NANOS);
    };
    this.usb.DPRAMUpdated = (offset, value) => this.#bufferControl(offset, value);
  }

  /** Bytes that have not reached the chip yet. */
  get unsent() {
    return this.queue.reduce((sum, { length }) => sum + length, 0);
  }

  /** Whether the port is set up and no request is under way, so that DTR may be changed. */
  get settled() {
    return this.endpoints !== null && !this.control;
  }

  /** Queues bytes for the device. They are sent in packets when it asks for them. */
  write(bytes) {
    for (let at = 0; at < bytes.length; at += PACKET_BYTES) this.queue.push(bytes.slice(at, at + PACKET_BYTES));
    this.#pump();
  }

  #start() {
    this.armed.clear();
    this.requests = this.#enumerate();
    this.#continue();
  }

  /** Opens or closes the port, as a program on the host does. */
  setDtr(open) {
    this.#request(this.#lineState(open ? DTR_AND_RTS : 0));
  }

  /** Sets the baud rate. On a USB port only the firmware gives it a meaning. */
  setLineCoding(baud) {
    this.#request(this.#lineCoding(baud));
  }

  /** Sends a request to the serial port, after those that are already queued. */
  #request(request) {
    if (this.endpoints === null) throw new Error('the host has not set the port up yet: wait for the welcome line first');
    this.waiting.push(request);
    if (!this.control) this.#continue();
  }

  /** Whether the host's program reads what the device has to say. */
  setReading(reading) {
    this.reading = reading;
    this.#pump();
  }

  *#enumerate() {
    yield { setup: setup(0x00, 5, 1, 0, 0) };
    const header = yield { setup: getDescriptor(CONFIGURATION_HEADER_BYTES) };
    const descriptors = yield { setup: getDescriptor(header[2] | (header[3] << 8)) };
    this.endpoints = bulkEndpoints(descriptors);
    yield { setup: setup(0x00, 9, 1, 0, 0) };
    yield this.#lineCoding(USUAL_BAUD);
    yield this.#lineState(DTR_AND_RTS);
  }

  #lineCoding(baud) {
    const data = new Uint8Array(LINE_CODING_BYTES);
    new DataView(data.buffer).setUint32(0, baud, true);
    data[LINE_CODING_BYTES - 1] = 8;
    return { setup: setup(0x21, 0x20, 0, this.endpoints.interface, data.length), data };
  }

  #lineState(lines) {
    this.dtr = lines !== 0;
    return { setup: setup(0x21, 0x22, lines, this.endpoints.interface, 0) };
  }

  /** Begins the next control transfer, if there is one, and passes on the result of the last one. */
  #continue(received) {
    const { value, done } = this.requests.next(received);
    const request = done ? this.waiting.shift() : value;
    this.control = request === undefined ? null : { ...request, stage: 'setup', received: [], expected: request.setup[6] | (request.setup[7] << 8) };
    this.#pump();
  }

  /** The firmware wrote a buffer control register. */
  #bufferControl(offset, value) {
    if (offset < BUFFER_CONTROL_START || offset >= BUFFER_CONTROL_END) return;
    const endpoint = (offset - BUFFER_CONTROL_START) >> 3;
    if (value & STALL && endpoint === 0 && this.control) {
      throw new Error(`the firmware refused a USB control request (bytes ${this.control.setup})`);
    }
    if (!(value & AVAILABLE)) return;
    this.armed.add(offset & 4 ? endpoint : endpoint | 0x80);
    this.#pump();
  }

  /** Puts the next transaction on the wire, if it is free and there is one. */
  #pump() {
    if (this.wire.scheduled) return;
    this.transaction = this.#next();
    if (this.transaction === null) return;
    this.wire.schedule((this.transaction.bytes.length + OVERHEAD_BYTES) * NANOS_PER_WIRE_BYTE);
  }

  #next() {
    return this.#nextControl() ?? this.#nextBulk();
  }

  #nextControl() {
    const { control } = this;
    switch (control?.stage) {
      case 'setup':
        return { kind: 'setup', bytes: control.setup };
      case 'data-in':
      case 'status-in':
        return this.#in(0);
      case 'data-out':
        return this.#out(0, control.data);
      case 'status-out':
        return this.#out(0, new Uint8Array(0));
    }
    return null;
  }

  /** Alternates with bytes to the device, so that a flood in one direction does not starve the other. */
  #nextBulk() {
    if (this.endpoints === null) return null;
    const fromDevice = () => (this.reading ? this.#in(this.endpoints.in) : null);
    const toDevice = () => (this.queue.length > 0 ? this.#out(this.endpoints.out, this.queue[0]) : null);
    this.outFirst = !this.outFirst;
    return this.outFirst ? (toDevice() ?? fromDevice()) : (fromDevice() ?? toDevice());
  }

  #in(endpoint) {
    if (!this.armed.has(endpoint | 0x80)) return null;
    const length = this.#register(endpoint, false) & LENGTH_MASK;
    const start = this.usb.getEndpointBufferOffset(endpoint, false);
    return { kind: 'in', endpoint, bytes: this.chip.usbDPRAM.slice(start, start + length) };
  }

  #out(endpoint, bytes) {
    return this.armed.has(endpoint) ? { kind: 'out', endpoint, bytes } : null;
  }

  /** The transaction on the wire is over. */
  #transacted() {
    const { kind, endpoint, bytes } = this.transaction;
    if (kind === 'setup') {
      this.#sendSetup(bytes);
    } else if (kind === 'in') {
      this.#release(endpoint, false, 0, bytes.length);
      if (endpoint === 0) this.#controlIn(bytes);
      else this.listener.onData(bytes);
    } else {
      this.chip.usbDPRAM.set(bytes, this.usb.getEndpointBufferOffset(endpoint, true));
      this.#release(endpoint, true, FULL, bytes.length);
      if (endpoint === 0) this.#controlOut();
      else this.listener.onDelivered(this.queue.shift());
    }
    this.#pump();
  }

  #sendSetup(bytes) {
    const { control } = this;
    this.armed.delete(0x80);
    this.armed.delete(0);
    control.stage = control.expected === 0 ? 'status-in' : control.data ? 'data-out' : 'data-in';
    this.usb.sendSetupPacket(bytes);
  }

  #controlIn(bytes) {
    const { control } = this;
    if (control.stage === 'status-in') return this.#continue();
    control.received.push(...bytes);
    if (bytes.length < PACKET_BYTES || control.received.length >= control.expected) control.stage = 'status-out';
  }

  #controlOut() {
    const { control } = this;
    if (control.stage === 'status-out') this.#continue(control.received);
    else control.stage = 'status-in';
  }

  #register(endpoint, out) {
    return this.chip.usbDPRAMView.getUint32(BUFFER_CONTROL_START + endpoint * 8 + (out ? 4 : 0), true);
  }

  /** Returns a buffer to the firmware and raises its interrupt. */
  #release(endpoint, out, full, length) {
    const kept = this.#register(endpoint, out) & ~(AVAILABLE | FULL | LENGTH_MASK);
    this.chip.usbDPRAMView.setUint32(BUFFER_CONTROL_START + endpoint * 8 + (out ? 4 : 0), kept | full | length, true);
    this.armed.delete(out ? endpoint : endpoint | 0x80);
    this.usb.indicateBufferReady(endpoint, out);
  }
}
