import { OffTimes } from './off-times.mjs';
import { OnTime } from './on-time.mjs';
import { TOOL_OUTPUTS } from './pins.mjs';
import { FUNCTION_PWM } from './pwm.mjs';

const OVERRIDE = { none: 0, invert: 1, low: 2 };
/** A duty is reported to a millionth. */
const PARTS = 1e6;

/** The tool's outputs as devices connected to the chip's pads see them. A pad that the chip does not drive is off. */
export class ToolOutputs {
  #clock;
  #pins;
  #chip = null;
  #changes = 0;
  #values = Object.fromEntries(TOOL_OUTPUTS.map((output) => [output, 0]));
  #onTime = new OnTime();

  /**
   * @param {import('./clock.mjs').MachineClock} clock
   * @param {Record<string, number>} pins of the board, by output
   */
  constructor(clock, pins) {
    this.#clock = clock;
    this.#pins = pins;
    this.offTimes = new OffTimes(clock);
    /** Called with (cycle, output, value) at every change: a duty from 0 to 1, or 0 or 1. */
    this.watchers = new Set();
  }

  /** Connects the tool to a chip that has just been powered or reset. */
  attach(chip) {
    this.#chip = chip;
    for (const [output, index] of Object.entries(this.#pins)) this.#follow(output, chip.gpio[index]);
  }

  /** A rising edge of STEP. */
  step(cycle) {
    this.#onTime.step(cycle);
  }

  /** The values as they are now, by name. */
  get values() {
    return { ...this.#values };
  }

  summary() {
    return { changes: this.#changes, ...this.#onTime.summary(this.#clock.cycles), ...this.#values };
  }

  /** The level of a pin may stay the same when its duty changes, so the pin is read whenever either may have changed. */
  #follow(output, pin) {
    const { checkForUpdates } = pin;
    const look = () => this.#look(output, pin);
    pin.checkForUpdates = () => {
      checkForUpdates.call(pin);
      look();
    };
    // PIO sets levels without calling checkForUpdates.
    pin.addListener(look);
    look();
  }

  #look(output, pin) {
    const value = Math.round(this.#dutyOf(pin) * PARTS) / PARTS;
    if (value === this.#values[output]) return;
    const { cycles } = this.#clock;
    this.#values[output] = value;
    this.#changes += 1;
    if (output === 'pwm') this.#onTime.set(value > 0, cycles);
    this.offTimes.set(Object.values(this.#values).some((each) => each > 0), cycles);
    for (const watch of this.watchers) watch(cycles, output, value);
  }

  #dutyOf(pin) {
    if (!pin.outputEnable || pin.outputDisable) return 0;
    if (pin.functionSelect !== FUNCTION_PWM) return Number(pin.outputValue);
    const duty = this.#chip.pwm.dutyOf(pin.index);
    if (pin.outputOverride === OVERRIDE.none) return duty;
    return pin.outputOverride === OVERRIDE.invert ? 1 - duty : Number(pin.outputOverride !== OVERRIDE.low);
  }
}
