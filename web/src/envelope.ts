// The lowest and highest speed, acceleration and jerk of each axis in equal parts of time, so that a run of any length is drawn at
// once, and right at every zoom.

import { Column } from "./column";
import type { Motion, Phase } from "./motion";

/** Speed, acceleration and jerk. */
export const QUANTITIES = 3;
/** Phases of a block, of which the extremes are kept. */
const BLOCK = 16;
/** A pause that is longer than this, s, is one: the machine is at rest in it. */
const PAUSE_S = 1e-6;

/** The extremes in equal parts of a span of time. */
export class Bins {
  /** Of each part, QUANTITIES of each axis. Without motion from Infinity to -Infinity. */
  readonly lows: Float32Array;
  readonly highs: Float32Array;

  constructor(
    private readonly from: number,
    to: number,
    readonly count: number,
    /** Of each part: so many quantities of so many axes. */
    readonly numbers: number,
  ) {
    this.width = (to - from) / count;
    this.lows = new Float32Array(count * numbers);
    this.highs = new Float32Array(count * numbers);
    this.clear();
  }

  clear(): void {
    this.lows.fill(Infinity);
    this.highs.fill(-Infinity);
  }

  readonly width: number;

  /** The part that a time is in, which may be before the first or behind the last. */
  at(time: number): number {
    return Math.floor((time - this.from) / this.width);
  }

  /** The middle of a part. */
  middle(bin: number): number {
    return this.from + (bin + 0.5) * this.width;
  }

  /** Where a part ends, and the next begins. */
  end(bin: number): number {
    return this.from + (bin + 1) * this.width;
  }

  take(bin: number, number: number, low: number, high = low): void {
    if (bin < 0 || bin >= this.count) return;
    const at = bin * this.numbers + number;
    this.lows[at] = Math.min(this.lows[at] ?? low, low);
    this.highs[at] = Math.max(this.highs[at] ?? high, high);
  }

  /** The lowest value of an axis in a part, or the highest; 0 where nothing is known. */
  value(bin: number, axis: number, quantity: number, isHigh: boolean): number {
    const value = (isHigh ? this.highs : this.lows)[bin * this.numbers + axis * QUANTITIES + quantity] ?? 0;
    return Number.isFinite(value) ? value : 0;
  }
}

export class Envelope {
  /** Of each block, in each number of it. */
  private readonly lows: Column<Float32Array>[] = [];
  private readonly highs: Column<Float32Array>[] = [];
  private done = 0;
  /** The instants between which a phase is taken in, counted from its beginning, s. */
  private readonly cut = new Float64Array(2);

  constructor(private readonly motion: Motion) {}

  /** Takes those blocks in that are whole by now. */
  grow(): void {
    const whole = new Bins(0, 1, 1, this.numbers);
    this.cut[0] = 0;
    for (; this.done + BLOCK <= this.motion.length; this.done += BLOCK) {
      whole.clear();
      for (let row = this.done; row < this.done + BLOCK; row++) {
        const phase = this.motion.read(row);
        this.cut[1] = phase.span;
        this.takePhase(whole, 0, phase);
        if (phase.pause > PAUSE_S && row < this.done + BLOCK - 1) this.takeRest(whole, 0, 0);
      }
      // Each number by itself, because what stays 0 takes no room then.
      for (let number = 0; number < this.numbers; number++) {
        (this.lows[number] ??= new Column<Float32Array>(Float32Array)).push(whole.lows, number);
        (this.highs[number] ??= new Column<Float32Array>(Float32Array)).push(whole.highs, number);
      }
    }
  }

  /** The extremes in so many parts of a span of time. */
  bins(from: number, to: number, count: number): Bins {
    const { motion } = this;
    const bins = new Bins(from, to, count, this.numbers);
    let ended = from;
    for (let row = Math.max(0, motion.rowAt(from)); row < motion.length && motion.from(row) < to; ) {
      if (motion.from(row) - ended > PAUSE_S) this.takeRest(bins, ended, motion.from(row));
      const next = this.takeBlock(bins, row) || this.takeRow(bins, row);
      ended = Math.max(ended, motion.to(next - 1));
      row = next;
    }
    if (ended < to) this.takeRest(bins, ended, to);
    return bins;
  }

  private get numbers(): number {
    return this.motion.axes * QUANTITIES;
  }

  /** Takes a whole block in if it lies in one part. Returns the row behind it; 0 if it does not. */
  private takeBlock(bins: Bins, row: number): number {
    const next = row + BLOCK;
    if (row % BLOCK || next > this.done) return 0;
    const bin = bins.at(this.motion.from(row));
    if (bin !== bins.at(this.motion.to(next - 1))) return 0;
    const block = row / BLOCK;
    for (let number = 0; number < this.numbers; number++) bins.take(bin, number, this.lows[number]?.at(block) ?? 0, this.highs[number]?.at(block) ?? 0);
    return next;
  }

  private takeRow(bins: Bins, row: number): number {
    const phase = this.motion.read(row);
    const { from, span } = phase;
    const last = Math.min(bins.at(this.motion.to(row)), bins.count - 1);
    for (let bin = Math.max(0, bins.at(from)); bin <= last; bin++) {
      this.cut[0] = Math.max(0, bins.end(bin - 1) - from);
      this.cut[1] = Math.min(span, bins.end(bin) - from);
      if (this.cut[1] >= this.cut[0]) this.takePhase(bins, bin, phase);
    }
    return row + 1;
  }

  private takeRest(bins: Bins, from: number, to: number): void {
    const last = Math.min(bins.at(to), bins.count - 1);
    for (let bin = Math.max(0, bins.at(from)); bin <= last; bin++) {
      for (let number = 0; number < bins.numbers; number++) bins.take(bin, number, 0);
    }
  }

  /** Takes in a phase from one instant to another: see `cut`. */
  private takePhase(bins: Bins, bin: number, phase: Phase): void {
    if (phase.span <= 0) return;
    const from = this.cut[0] ?? 0;
    const to = this.cut[1] ?? 0;
    const still = phase.isHoming ? 0 : 1;
    for (let axis = 0; axis < phase.axes; axis++) {
      const jerk = phase.jerk(axis);
      const speed = phase.speed(axis, from);
      const last = phase.speed(axis, to);
      const accel = phase.accel(axis, from);
      const lastAccel = phase.accel(axis, to);
      // Speed is highest or lowest where the acceleration is 0.
      const turn = jerk ? from - accel / jerk : from;
      const turned = turn > from && turn < to ? phase.speed(axis, turn) : speed;
      const at = axis * QUANTITIES;
      bins.take(bin, at, still * Math.min(speed, last, turned), still * Math.max(speed, last, turned));
      bins.take(bin, at + 1, still * Math.min(accel, lastAccel), still * Math.max(accel, lastAccel));
      bins.take(bin, at + 2, still * jerk);
    }
  }
}
