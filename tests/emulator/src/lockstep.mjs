/**
 * What runs beside the core, cycle by cycle: the PIO blocks and the DMA, in the order in which they were added within a cycle.
 *
 * Only cycles on which one of them acts are visited. The core runs an instruction, then these catch up with it. Each
 * action has its own cycle on the clock, so an edge is reported with the cycle of the edge.
 */
export class Lockstep {
  /** @param {import('./clock.mjs').MachineClock} clock */
  constructor(clock) {
    this.clock = clock;
    this.parts = [];
    /** The earliest cycle on which a part is due. */
    this.next = Infinity;
  }

  /** @param {{next: number, tick: (cycle: number) => void}} part */
  add(part) {
    this.parts.push(part);
  }

  /** A part is due on this cycle, which may be earlier than expected so far. */
  expect(cycle) {
    if (cycle < this.next) this.next = cycle;
  }

  /** Visits all cycles up to and including the core's, but none after the next alarm's. */
  catchUp() {
    const { clock } = this;
    const { past, core } = clock;
    while (this.next < core.cycles + 1 && this.next < clock.next + 1) {
      clock.past = Math.floor(this.next);
      this.tick(clock.past);
    }
    clock.past = past;
  }

  tick(cycle) {
    const { parts } = this;
    const end = cycle + 1;
    // If a part makes an earlier part due, that calls `expect`.
    this.next = Infinity;
    for (let index = 0; index < parts.length; index++) {
      const part = parts[index];
      if (part.next < end) part.tick(cycle);
      if (part.next < this.next) this.next = part.next;
    }
  }
}
