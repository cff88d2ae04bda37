import { Inputs } from './pio/inputs.mjs';

const [LEVEL_LOW, LEVEL_HIGH, EDGE_LOW, EDGE_HIGH] = [1 << 0, 1 << 1, 1 << 2, 1 << 3];
const INPUT_ENABLE = 1 << 6;

/**
 * What the inputs of the pins see: the level from outside, or that of the chip's own output while that is enabled. The
 * pin's interrupts see it at once; the PIO blocks and SIO see it through their synchronisers.
 */
export class PadInputs {
  /**
   * @param {import('./pio/block.mjs').PioBlock[]} pio
   * @param {import('./clock.mjs').MachineClock} clock
   */
  constructor(chip, pio, clock) {
    this.pio = pio;
    this.clock = clock;
    this.sio = new Inputs();
    Object.defineProperty(chip, 'gpioValues', { get: () => this.sio.at(clock.cycles) });
    for (const pin of chip.gpio) this.#attach(pin);
  }

  /** Replaces rp2040js's rules, which use only the level from outside. */
  #attach(pin) {
    const { setInputValue, checkForUpdates } = pin;
    let outside = pin.rawInputValue;
    const take = (high) => {
      setInputValue.call(pin, high);
      this.#notify(pin, pin.inputValue);
    };
    const settle = () => {
      const high = pin.outputEnable ? pin.outputValue : outside;
      if (high !== pin.rawInputValue) take(high);
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
    pin.irqStatus = high ? (pin.irqStatus & ~LEVEL_LOW) | LEVEL_HIGH | EDGE_HIGH : (pin.irqStatus & ~LEVEL_HIGH) | LEVEL_LOW | EDGE_LOW;
    return this.#notify(pin, high);
  }

  #notify(pin, high) {
    const { cycles } = this.clock;
    this.sio.change(pin.index, high, cycles);
    this.pio[0].inputChanged(pin.index, high, cycles);
    this.pio[1].inputChanged(pin.index, high, cycles);
  }
}
