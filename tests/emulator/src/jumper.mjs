const LOW = 0;
const LAST_GPIO = 29;

/** A wire between two of the chip's pads, both by their GP numbers: while the chip drives the first one low, it pulls the other one low. */
export class Jumper {
  #onChange;

  /**
   * @param {{from: number, to: number}} pads
   * @param {(jumper: Jumper) => void} onChange called when it begins to pull low, or lets go
   */
  constructor({ from, to }, onChange) {
    Object.assign(this, { from, to, low: false });
    this.#onChange = onChange;
  }

  /** Connects it to a chip that has just been powered or reset, and so drives no pad. */
  attach(chip) {
    this.low = false;
    chip.gpio[this.from].addListener((state) => this.#follow(state === LOW));
  }

  #follow(low) {
    if (low === this.low) return;
    this.low = low;
    this.#onChange(this);
  }
}

/** @param {string} text such as 28:9 @returns {{from: number, to: number}} */
export function jumperOption(text) {
  const [from, to, ...more] = text.split(':').map((part) => (/^[0-9]+$/.test(part) ? Number(part) : NaN));
  const isPad = (pad) => pad >= 0 && pad <= LAST_GPIO;
  if (!isPad(from) || !isPad(to) || from === to || more.length > 0) {
    throw new Error(`--jumper ${text}: give two different pads by their GP numbers, from 0 to ${LAST_GPIO}, the one that drives first, such as 28:9`);
  }
  return { from, to };
}
