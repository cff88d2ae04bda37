import { nanosOf } from './clock.mjs';
import { Vfd } from './vfd.mjs';

const FUNCTION_UART = 2;
/** The silence that ends a frame, and after which a VFD answers at the soonest, characters. */
const SILENCE = 3.5;

/**
 * RS-485 between the chip's UART0 and a VFD, with a module whose driver is on while a pad is high, and its receiver otherwise. Nothing
 * holds the wire while nobody drives it: when the chip lets go of it, the receiver hears a character that nobody sent.
 */
export class VfdWire {
  #frame = [];
  #lastEnd = 0;
  #drives = false;
  /** Characters that left the chip while it did not drive the wire, or answers that came while it did. */
  violations = 0;
  #releasedNanosMax = 0;

  /**
   * @param {import('./clock.mjs').MachineClock} clock
   * @param {{tx: number, rx: number, sends: number, enable: number}} pads
   */
  constructor(clock, pads) {
    Object.assign(this, { clock, pads, vfd: new Vfd(clock) });
    this.silence = clock.createOutsideAlarm(() => this.#ended());
  }

  /** Connects it to a chip that has just been powered or reset. */
  attach(chip) {
    const uart = chip.uart0;
    Object.assign(this, { chip, uart, violations: 0 });
    [this.#frame, this.#drives, this.#releasedNanosMax] = [[], false, 0];
    uart.onStart = (byte) => this.#began(byte);
    chip.gpio[this.pads.sends].addListener((state) => this.#turned(state === 1));
    chip.gpio[this.pads.enable].addListener((state) => this.vfd.enable(state === 1));
    this.vfd.enable(false);
  }

  #turned(drives) {
    if (this.#drives && !drives) {
      this.#releasedNanosMax = Math.max(this.#releasedNanosMax, nanosOf(this.clock.cycles - this.#lastEnd));
      this.#after(1, () => this.#toChip(0));
    }
    this.#drives = drives;
  }

  #began(byte) {
    if (!this.uart.sends || this.chip.gpio[this.pads.tx].functionSelect !== FUNCTION_UART) return;
    const drove = this.#drives;
    this.silence.cancel();
    this.#after(1, () => {
      this.#lastEnd = this.clock.cycles;
      if (drove && this.#drives) this.#frame.push(byte);
      else this.violations += 1;
      this.silence.scheduleAt(this.clock.cycles + Math.round(SILENCE * this.uart.byteCycles));
    });
  }

  #ended() {
    const reply = this.vfd.answer(this.#frame);
    this.#frame = [];
    if (reply === null) return;
    if (this.#drives) this.violations += 1;
    const say = (index) => {
      this.#after(1, () => {
        if (!this.#drives) this.#toChip(reply[index]);
        if (index + 1 < reply.length) say(index + 1);
      });
    };
    say(0);
  }

  #toChip(byte) {
    const { uart } = this;
    if (uart.ready && this.chip.gpio[this.pads.rx].functionSelect === FUNCTION_UART) uart.receive(byte);
  }

  #after(characters, act) {
    this.clock.createOutsideAlarm(act).scheduleAt(this.clock.cycles + Math.max(1, Math.round(characters * this.uart.byteCycles)));
  }

  summary() {
    return { ...this.vfd.summary(), violations: this.violations, released_ns_max: this.#releasedNanosMax };
  }
}
