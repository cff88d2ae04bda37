import { CLOCK_HZ } from './clock.mjs';

const [SOF_RD, INTR, INTE] = [0x48, 0x8c, 0x90];
const DEV_SOF = 1 << 17;
const FRAMES_PER_SECOND = 1000;
const FRAME_MASK = 0x7ff;
const PARTS_PER_MILLION = 1e6;

/**
 * The start-of-frame packets of a USB host, one each millisecond of its own clock, as the chip sees them: SOF_RD has the
 * number of the last one, and DEV_SOF is set by each until SOF_RD is read.
 *
 * The number is computed from the cycle when it is read. Nothing happens on a frame's cycle unless the firmware has
 * enabled its interrupt.
 */
export class UsbFrames {
  #clock;
  #frameCycles;
  #usb = null;
  /** Nothing is received before the cycle on which the host has reset the bus; the last frame whose number was read. */
  #sinceCycle = Infinity;
  #readFrame = 0;
  #alarm;

  /**
   * @param {import('./clock.mjs').MachineClock} clock
   * @param {number} longerPpm how much longer the host's millisecond is than the chip's
   */
  constructor(clock, longerPpm = 0) {
    this.#clock = clock;
    this.#frameCycles = (CLOCK_HZ / FRAMES_PER_SECOND) * (1 + longerPpm / PARTS_PER_MILLION);
    this.#alarm = clock.createOutsideAlarm(() => this.#awaitFrame());
  }

  /** Connects the host to the USB controller of a chip that has just been powered or reset. */
  attach(usb) {
    this.#usb = usb;
    this.#sinceCycle = Infinity;
    this.#alarm.cancel();
    const { readUint32, writeUint32 } = usb;
    usb.readUint32 = (offset) => {
      if (offset === SOF_RD) return this.#read();
      if (offset === INTR) this.#setPending();
      return readUint32.call(usb, offset);
    };
    usb.writeUint32 = (offset, value) => {
      writeUint32.call(usb, offset, value);
      if (offset === INTE) this.#awaitFrame();
    };
  }

  /** The host has reset the bus. The device receives its frames from now on. */
  start() {
    this.#sinceCycle = this.#clock.cycles;
    this.#readFrame = this.#last;
    this.#awaitFrame();
  }

  /** Frames since power-up; the host counts from there. */
  get #last() {
    return Math.floor(this.#clock.cycles / this.#frameCycles);
  }

  get #receives() {
    return this.#clock.cycles >= this.#sinceCycle;
  }

  /** Reading the number clears DEV_SOF. */
  #read() {
    if (!this.#receives) return 0;
    this.#readFrame = this.#last;
    this.#usb.intRaw &= ~DEV_SOF;
    this.#usb.checkInterrupts();
    return this.#readFrame & FRAME_MASK;
  }

  #setPending() {
    if (this.#receives && this.#last !== this.#readFrame) this.#usb.intRaw |= DEV_SOF;
  }

  /** Wakes the chip with each frame, if it has asked for that. */
  #awaitFrame() {
    this.#alarm.cancel();
    if ((this.#usb.intEnable & DEV_SOF) === 0 || !this.#receives) return;
    this.#setPending();
    this.#usb.checkInterrupts();
    // Rounding must not make it this cycle again.
    this.#alarm.scheduleAt(Math.max(this.#clock.cycles + 1, Math.ceil((this.#last + 1) * this.#frameCycles)));
  }
}
