import { Inputs } from './pio/inputs.mjs';
import { FUNCTION_PWM } from './pwm.mjs';

const [LEVEL_LOW, LEVEL_HIGH, EDGE_LOW, EDGE_HIGH] = [1 << 0, 1 << 1, 1 << 2, 1 << 3];
const INPUT_ENABLE = 1 << 6;
/** A pad after a reset (datasheet 2.19.6.3): its input enabled, pulled down, 4 mA. rp2040js has the input off. */
const PAD_AT_RESET = 0x56;

/**
 * What the inputs of the pins see: the level from outside, or that of the chip's own output while that is enabled, and
 * what the pin's input override (INOVER) makes of it. The pin's interrupts see it at once; the PIO blocks and SIO see it
 * through their synchronisers.
 */
export class PadInputs {
  /**
   * @param {import('./pio/block.mjs').PioBlock[]} pio
   * @param {import('./clock.mjs').MachineClock} clock
   */
  constructor(chip, pio, clock) {
    this.chip = chip;
    this.pio = pio;
    this.clock = clock;
    this.sio = new Inputs();
    Object.defineProperty(chip, 'gpioValues', { get: () => this.#seenBySio() });
    for (const pin of chip.gpio) this.#attach(pin);
  }

  /** Replaces rp2040js's rules, which use only the level from outside, and for interrupts no override. */
  #attach(pin) {
    const { checkForUpdates } = pin;
    pin.padValue = PAD_AT_RESET;
    /** Whether something stands between what drives the pin and its pad (`PadFaults`). */
    pin.faulty = false;
    let outside = pin.rawInputValue;
    const take = (high) => {
      pin.rawInputValue = high;
      this.#detect(pin, pin.inputValue);
      this.#notify(pin, pin.inputValue);
    };
    const settle = () => {
      const high = pin.outputEnable ? pin.outputValue : outside;
      if (high !== pin.rawInputValue || pin.inputValue !== isHigh(pin)) take(high);
    };
    pin.setInputValue = (high) => {
      outside = high;
      take(pin.outputEnable ? pin.outputValue : high);
    };
    pin.refreshInput = () => take(pin.rawInputValue);
    pin.checkForUpdates = () => {
      checkForUpdates.call(pin);
      settle();
      this.#notify(pin, pin.inputValue);
    };
    pin.follow = (high) => this.#follow(pin, high, take);
  }

  /**
   * The output of a pin without overrides changes. The effect is that of `settle`, but faster where no interrupt is
   * enabled.
   */
  #follow(pin, high, take) {
    if ((pin.irqEnableMask | pin.irqForceMask) !== 0) return take(high);
    pin.rawInputValue = high;
    if ((pin.padValue & INPUT_ENABLE) === 0) return undefined;
    pin.irqStatus = statusOf(pin, high);
    return this.#notify(pin, high);
  }

  /** The edges of PWM are not followed one by one, so its pins are looked at when somebody reads them. */
  #seenBySio() {
    for (const pin of this.chip.gpio) if (pin.functionSelect === FUNCTION_PWM) pin.checkForUpdates();
    return this.sio.at(this.clock.cycles);
  }

  /** The pin's interrupts see a level. */
  #detect(pin, high) {
    const before = pin.irqValue;
    pin.irqStatus = statusOf(pin, high);
    if (pin.irqValue !== before) this.chip.updateIOInterrupt();
  }

  #notify(pin, high) {
    const { cycles } = this.clock;
    this.sio.change(pin.index, high, cycles);
    for (let index = 0; index < this.pio.length; index++) this.pio[index].inputChanged(pin.index, high, cycles);
  }
}

/** The level that the pin's interrupts saw last. */
const isHigh = (pin) => (pin.irqStatus & LEVEL_HIGH) !== 0;

function statusOf({ irqStatus }, high) {
  return high ? (irqStatus & ~LEVEL_LOW) | LEVEL_HIGH | EDGE_HIGH : (irqStatus & ~LEVEL_HIGH) | LEVEL_LOW | EDGE_LOW;
}
