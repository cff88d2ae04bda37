/** Two flip-flops: a level is seen two cycles after it came, or one cycle with the synchroniser bypassed. */
const SYNC_CYCLES = 2;
const BYPASS_CYCLES = 1;
/** Room for every pin to change on every cycle that a change takes. */
const SLOTS = 128;

/** The levels of the GPIO inputs as a PIO block or SIO sees them, through its synchronisers. */
export class Inputs {
  constructor() {
    this.bypassed = 0;
    this.seen = 0;
    this.outside = 0;
    /**
     * Changes that are not seen yet, as a ring in order: the cycle from which each is seen, and the bit of the pin that
     * toggles.
     */
    this.cycles = new Float64Array(SLOTS);
    this.bits = new Int32Array(SLOTS);
    this.head = 0;
    this.count = 0;
  }

  /** The levels a machine sees on a cycle. */
  at(cycle) {
    while (this.count > 0 && this.cycles[this.head] <= cycle) {
      this.seen ^= this.bits[this.head];
      this.head = (this.head + 1) & (SLOTS - 1);
      this.count -= 1;
    }
    return this.seen;
  }

  /** The cycle on which the next change is seen. */
  get nextChange() {
    return this.count === 0 ? Infinity : this.cycles[this.head];
  }

  /** A pin's level changes. @returns {number} the cycle from which that is seen; Infinity if the level is the same */
  change(pin, high, cycle) {
    const bit = 1 << pin;
    if (((this.outside & bit) !== 0) === high) return Infinity;
    this.outside ^= bit;
    this.at(cycle);
    const seenAt = cycle + (this.bypassed & bit ? BYPASS_CYCLES : SYNC_CYCLES);
    this.#insert(seenAt, bit);
    return seenAt;
  }

  #insert(seenAt, bit) {
    let slot = (this.head + this.count) & (SLOTS - 1);
    this.count += 1;
    for (let left = this.count - 1; left > 0; left--) {
      const before = (slot - 1) & (SLOTS - 1);
      if (this.cycles[before] <= seenAt) break;
      this.cycles[slot] = this.cycles[before];
      this.bits[slot] = this.bits[before];
      slot = before;
    }
    this.cycles[slot] = seenAt;
    this.bits[slot] = bit;
  }
}
