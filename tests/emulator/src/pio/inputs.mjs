/** Two flip-flops: a level is seen two cycles after it came; one with the synchroniser bypassed. */
const SYNC_CYCLES = 2;
const BYPASS_CYCLES = 1;

/** The levels of the GPIO inputs as a PIO block sees them, through its synchronisers. */
export class Inputs {
  constructor() {
    this.bypassed = 0;
    this.seen = 0;
    this.outside = 0;
    /** Changes on their way: the cycle from which each is seen, the pin's bit, its level. In order of those cycles. */
    this.coming = [];
  }

  /** The levels a machine sees on a cycle. */
  at(cycle) {
    while (this.nextChange <= cycle) {
      const { bit, high } = this.coming.shift();
      this.seen = high ? this.seen | bit : this.seen & ~bit;
    }
    return this.seen;
  }

  /** The cycle on which the next change is seen. */
  get nextChange() {
    return this.coming.length === 0 ? Infinity : this.coming[0].cycle;
  }

  /** A pin's level changes. @returns {number | null} the cycle from which that is seen; null if it is no change */
  change(pin, high, cycle) {
    const bit = 1 << pin;
    if (((this.outside & bit) !== 0) === high) return null;
    this.outside ^= bit;
    const seenAt = cycle + (this.bypassed & bit ? BYPASS_CYCLES : SYNC_CYCLES);
    this.coming.push({ cycle: seenAt, bit, high });
    this.coming.sort((one, other) => one.cycle - other.cycle);
    return seenAt;
  }
}
