/** Closed while it is pressed, or open while it is pressed. */
export const ESTOP_CONTACTS = ['no', 'nc'];

/** The emergency stop: a contact to ground, and its wire. */
export class Estop {
  #contact;
  #isPressed = false;
  #isCut = false;

  /** @param {'no' | 'nc'} contact */
  constructor(contact) {
    this.#contact = contact;
  }

  /** The level at the input, which has a pull-up. */
  get high() {
    return this.#isCut || this.#isPressed === (this.#contact === 'nc');
  }

  /**
   * @param {{isPressed?: boolean, isCut?: boolean}} change
   * @returns {boolean} whether the input says now that it is pressed, and did not before
   */
  change({ isPressed = this.#isPressed, isCut = this.#isCut }) {
    const before = this.high;
    this.#isPressed = isPressed;
    this.#isCut = isCut;
    return this.high !== before && this.high === (this.#contact === 'nc');
  }
}
