import { cyclesOfMicros } from './clock.mjs';

export const SWITCH_MODES = ['normal', 'stuck-open', 'stuck-closed'];

/** A switch to ground with a pull-up: it may stick, and its contact may bounce. */
export class LimitSwitch {
  /**
   * @param {import('./clock.mjs').MachineClock} clock
   * @param {{bounceMicros: number, random: () => number, onLevel: (high: boolean) => void}} options
   */
  constructor(clock, { bounceMicros, random, onLevel }) {
    this.clock = clock;
    this.bounceCycles = cyclesOfMicros(bounceMicros);
    this.random = random;
    this.onLevel = onLevel;
    this.mode = 'normal';
    this.pressed = false;
    this.contact = false;
    this.closures = 0;
    this.bouncing = clock.createOutsideAlarm(() => this.#bounce());
  }

  get closed() {
    return this.mode === 'normal' ? this.contact : this.mode === 'stuck-closed';
  }

  /** Whether something keeps it closed, bouncing or not: the carriage, or a defect. */
  get held() {
    return this.pressed || this.mode === 'stuck-closed';
  }

  /** The carriage presses or leaves the switch. */
  press(pressed) {
    if (pressed === this.pressed) return;
    this.pressed = pressed;
    this.#settle(pressed);
    if (this.bounceCycles === 0) return;
    this.settledAt = this.clock.cycles + this.bounceCycles;
    this.#bounceAgain();
  }

  setMode(mode) {
    const before = this.closed;
    this.mode = mode;
    if (this.closed !== before) this.#report();
  }

  #settle(contact) {
    const before = this.closed;
    this.contact = contact;
    if (this.closed !== before) this.#report();
  }

  #report() {
    if (this.closed) this.closures += 1;
    this.onLevel(!this.closed);
  }

  #bounceAgain() {
    const step = 1 + Math.floor((this.random() * this.bounceCycles) / 4);
    this.bouncing.scheduleAt(Math.min(this.clock.cycles + step, this.settledAt));
  }

  #bounce() {
    if (this.clock.cycles >= this.settledAt) return this.#settle(this.pressed);
    this.#settle(!this.contact);
    this.#bounceAgain();
  }
}

/** A small seeded generator (mulberry32): the same seed, the same bounces. */
export function seededRandom(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let mixed = Math.imul(state ^ (state >>> 15), state | 1);
    mixed ^= mixed + Math.imul(mixed ^ (mixed >>> 7), mixed | 61);
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 2 ** 32;
  };
}
