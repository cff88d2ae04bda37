export const CSR = { enable: 1 << 0, phaseCorrect: 1 << 1, invertA: 1 << 2, invertB: 1 << 3, divMode: 3 << 4, retard: 1 << 6, advance: 1 << 7 };
const COUNTER_MASK = 0xffff;
const DIVIDER_MASK = 0xfff;
const SIXTEENTHS = 16;
/** A whole part of 0 in DIV divides by 256. */
const LARGEST_DIVIDER = 256 * SIXTEENTHS;
const CHANNELS = 2;

/**
 * A slice of the PWM (datasheet 4.5), free-running and trailing-edge. Its counter is computed from the cycle, so a
 * slice that nobody changes costs nothing. It sets an alarm only for a wrap that matters, or for every edge if edges
 * are shown.
 */
export class PwmSlice {
  #clock;
  #alarm;
  #onChange;
  /** The cycle to which the stored counter and the stored phase of the divider, in sixteenths of a cycle, belong. */
  #sinceCycle;
  #counter = 0;
  #phase = SIXTEENTHS - 1;
  #csr = 0;
  #div = SIXTEENTHS;
  /** The values as written, and those in force since the last wrap. */
  #cc = 0;
  #top = COUNTER_MASK;
  #latchedCc = 0;
  #latchedTop = COUNTER_MASK;
  /** The levels of the outputs A and B while the slice is halted. */
  #held = [false, false];
  #wrapped = false;
  #wrapAwaited = false;
  #edgesShown = false;

  /**
   * @param {import('./clock.mjs').MachineClock} clock
   * @param {() => void} onChange called on the cycle of every latch, awaited wrap, shown edge and written register
   */
  constructor(clock, onChange) {
    this.#clock = clock;
    this.#onChange = onChange;
    this.#sinceCycle = clock.cycles;
    this.#alarm = clock.createAlarm(() => this.#reach(clock.cycles));
  }

  get enabled() {
    return (this.#csr & CSR.enable) !== 0;
  }

  get csr() {
    return this.#csr;
  }

  get div() {
    return this.#div;
  }

  get counter() {
    return this.#counterAfter(this.#ticksTo(this.#clock.cycles));
  }

  get cc() {
    return this.#cc >>> 0;
  }

  get top() {
    return this.#top;
  }

  /** Whether the counter has wrapped since this flag was last cleared. */
  get wrapped() {
    return this.#wrapped || this.#ticksTo(this.#clock.cycles) >= this.#ticksToWrap;
  }

  /** The level of an output, 0 for A and 1 for B. */
  level(channel) {
    return this.#rawLevel(channel) !== this.#inverted(channel);
  }

  /** The fraction of time during which an output is high, with the compare value in force; 0 or 1 while the slice is halted. */
  duty(channel) {
    const duty = this.enabled ? Math.min(1, this.#compare(channel) / (this.#latchedTop + 1)) : Number(this.#held[channel]);
    return this.#inverted(channel) ? 1 - duty : duty;
  }

  writeCsr(value) {
    this.#change(() => {
      if (this.enabled && (value & CSR.enable) === 0) this.#held = this.#held.map((_, channel) => this.#rawLevel(channel));
      this.#csr = value & (CSR.enable | CSR.invertA | CSR.invertB);
    });
  }

  /** Eight bits of the whole part, four of the fraction. */
  writeDiv(value) {
    this.#change(() => {
      this.#div = value & DIVIDER_MASK;
      this.#phase = Math.min(this.#phase, this.#divider - 1);
    });
  }

  writeCounter(value) {
    this.#change(() => (this.#counter = value & COUNTER_MASK));
  }

  writeCc(value) {
    this.#change(() => (this.#cc = value));
  }

  writeTop(value) {
    this.#change(() => (this.#top = value & COUNTER_MASK));
  }

  clearWrapped() {
    this.#change(() => (this.#wrapped = false));
  }

  /** Sets whether the next wrap is reported on its cycle. */
  awaitWrap(awaited) {
    this.#change(() => (this.#wrapAwaited = awaited));
  }

  /** Reports every edge of the outputs on its cycle from now on. */
  showEdges() {
    this.#change(() => (this.#edgesShown = true));
  }

  /** Sixteenths of a cycle between two ticks. */
  get #divider() {
    return this.#div < SIXTEENTHS ? LARGEST_DIVIDER + this.#div : this.#div;
  }

  /** The counter wraps after TOP. If it is above TOP, it counts on through all sixteen bits. */
  get #ticksToWrap() {
    return (this.#counter <= this.#latchedTop ? this.#latchedTop : COUNTER_MASK) + 1 - this.#counter;
  }

  get #pending() {
    return this.#cc !== this.#latchedCc || this.#top !== this.#latchedTop;
  }

  #inverted(channel) {
    return (this.#csr & (channel === 0 ? CSR.invertA : CSR.invertB)) !== 0;
  }

  #compare(channel) {
    return channel === 0 ? this.#latchedCc & COUNTER_MASK : this.#latchedCc >>> 16;
  }

  #rawLevel(channel) {
    return this.enabled ? this.counter < this.#compare(channel) : this.#held[channel];
  }

  /** First does what is due before this cycle, even if the core has passed it within an instruction. */
  #change(write) {
    const { cycles } = this.#clock;
    this.#catchUp(cycles);
    this.#settle(cycles);
    write();
    if (!this.enabled) this.#latch();
    this.#lookAhead();
    this.#onChange();
  }

  #catchUp(cycle) {
    while (this.#alarm.scheduled && this.#alarm.dueCycle <= cycle) {
      const { dueCycle } = this.#alarm;
      this.#alarm.cancel();
      this.#clock.at(dueCycle, () => this.#reach(dueCycle));
    }
  }

  #reach(cycle) {
    this.#settle(cycle);
    this.#lookAhead();
    this.#onChange();
  }

  /** Advances the counter to a cycle. A wrap on the way makes the written values effective. */
  #settle(cycle) {
    const ticks = this.#ticksTo(cycle);
    const wraps = ticks >= this.#ticksToWrap;
    if (this.enabled) this.#phase = this.#elapsed(cycle) % this.#divider;
    this.#counter = this.#counterAfter(ticks);
    this.#sinceCycle = Math.max(cycle, this.#sinceCycle);
    if (!wraps) return;
    this.#wrapped = true;
    this.#latch();
  }

  #latch() {
    this.#latchedCc = this.#cc;
    this.#latchedTop = this.#top;
  }

  /** Sixteenths of a cycle since the last tick. */
  #elapsed(cycle) {
    return Math.max(0, cycle - this.#sinceCycle) * SIXTEENTHS + this.#phase;
  }

  #ticksTo(cycle) {
    return this.enabled ? Math.floor(this.#elapsed(cycle) / this.#divider) : 0;
  }

  #counterAfter(ticks) {
    const toWrap = this.#ticksToWrap;
    return ticks < toWrap ? this.#counter + ticks : (ticks - toWrap) % (this.#latchedTop + 1);
  }

  #lookAhead() {
    const ticks = this.enabled ? this.#ticksToNext() : Infinity;
    if (ticks < Infinity) this.#alarm.scheduleAt(this.#sinceCycle + Math.ceil((ticks * this.#divider - this.#phase) / SIXTEENTHS));
    else this.#alarm.cancel();
  }

  /** Ticks until something has to be done: a wrap that makes values effective or is awaited, or an edge. */
  #ticksToNext() {
    let ticks = this.#pending || this.#edgesShown || (this.#wrapAwaited && !this.#wrapped) ? this.#ticksToWrap : Infinity;
    for (let channel = 0; this.#edgesShown && channel < CHANNELS; channel++) {
      const fall = this.#compare(channel) - this.#counter;
      if (fall > 0) ticks = Math.min(ticks, fall);
    }
    return ticks;
  }
}
