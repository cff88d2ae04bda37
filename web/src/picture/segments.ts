// A run as lines to draw: bounded in number, in the order of time, each with its colour.

import { type Motion, Phase, type Places } from "../motion";
import { Parts, type Tone } from "./tone";

/** No picture has more lines than this, however long the program is. */
export const SEGMENTS_MAX = 60_000;
/** Nothing is drawn more finely than this share of the whole: some 20 times as fine as a screen, for those who come nearer. */
const FINEST = 1 / 50_000;
/** The page answers in between, ms. */
const SLICE_MS = 8;
/** Phases between two looks at the clock. */
const IN_ONE_GO = 32;
/** Places for lines that are known already; more than twice as many as there are lines. A power of two. */
const TABLE = 2 ** 17;

export interface Segments {
  count: number;
  /** What is shorter than this is not drawn by itself, mm. */
  fine: number;
  /** From and to: six numbers each, mm. */
  places: Float32Array;
  ranks: Uint8Array;
  /** When each was first made, s. */
  ends: Float64Array;
  /** Where the path is, mm: from and to. Of no path from 0 to 0. */
  low: Places;
  high: Places;
}

/** Lets the page answer when it has not for a while. */
export class Breath {
  private last = performance.now();

  get isDue(): boolean {
    return performance.now() - this.last > SLICE_MS;
  }

  async take(): Promise<void> {
    await new Promise((resolve) => setTimeout(resolve));
    this.last = performance.now();
  }
}

class Builder {
  count = 0;
  private readonly places = new Float32Array(6 * SEGMENTS_MAX);
  private readonly ranks = new Uint8Array(SEGMENTS_MAX);
  private readonly times = new Float64Array(SEGMENTS_MAX);
  /** Lines that are there, each with its number from 1 in the first free place from that of its hash on. */
  private readonly table = new Int32Array(TABLE);
  /** Where the line that gathers begins, and where it has come to; then the ends of a part. Numbers in one place, as objects for every part of a long run
   * would be much to clear away. */
  private readonly from = new Float64Array(3);
  private readonly last = new Float64Array(3);
  private readonly begins = new Float64Array(3);
  private readonly ends = new Float64Array(3);
  private fine = 0;
  private rank = -1;
  private end = 0;
  private isOpen = false;

  /** Begins anew. */
  begin(fine: number): void {
    this.fine = fine;
    [this.count, this.rank, this.isOpen] = [0, -1, false];
    this.last.fill(Infinity);
    this.table.fill(0);
  }

  get isFull(): boolean {
    return this.count >= SEGMENTS_MAX;
  }

  /** What was made, for itself. */
  made(low: Places, high: Places): Segments {
    const { count, fine } = this;
    return { count, fine, places: this.places.slice(0, 6 * count), ranks: this.ranks.slice(0, count), ends: this.times.slice(0, count), low, high };
  }

  /** Goes on by a part of a phase. What is shorter than can be seen is drawn with what follows. */
  part(phase: Phase, parts: Parts, index: number): void {
    const from = parts.from[index] ?? 0;
    const to = parts.to[index] ?? 0;
    const rank = parts.ranks[index] ?? 0;
    for (let axis = 0; axis < 3; axis++) {
      this.begins[axis] = phase.place(axis, from);
      this.ends[axis] = phase.place(axis, to);
    }
    if (rank !== this.rank || !this.isNear(this.last, this.begins)) {
      this.finish();
      this.from.set(this.begins);
    }
    this.last.set(this.ends);
    this.rank = rank;
    this.end = phase.from + to;
    this.isOpen = true;
    if (this.isNear(this.from, this.ends)) return;
    this.finish();
    this.from.set(this.ends);
  }

  /** Draws what has gathered, unless a line of this colour is there already. */
  finish(): void {
    if (!this.isOpen || this.isFull) return;
    this.isOpen = false;
    this.places.set(this.from, 6 * this.count);
    this.places.set(this.last, 6 * this.count + 3);
    this.ranks[this.count] = this.rank;
    this.times[this.count] = this.end;
    if (!this.isThere(this.count)) this.count++;
  }

  /** Whether a line of the same colour is there already, as far as can be seen. Otherwise it is from now on. */
  private isThere(line: number): boolean {
    const { ranks } = this;
    let hash = ranks[line] ?? 0;
    for (let end = 0; end < 6; end++) {
      hash = Math.imul(hash ^ this.cell(line, end), 0x9e3779b1);
      hash ^= hash >>> 15;
    }
    for (let place = hash & (TABLE - 1); ; place = (place + 1) & (TABLE - 1)) {
      const other = (this.table[place] ?? 0) - 1;
      if (other < 0) {
        this.table[place] = line + 1;
        return false;
      }
      let end = 0;
      while (end < 6 && this.cell(other, end) === this.cell(line, end)) end++;
      if (end === 6 && ranks[other] === ranks[line]) return true;
    }
  }

  /** A number of a place of a line, in units of what can be seen. */
  private cell(line: number, end: number): number {
    return Math.round((this.places[6 * line + end] ?? 0) / this.fine);
  }

  /** Whether two places are so near that nobody sees them apart. */
  private isNear(one: Float64Array, other: Float64Array): boolean {
    for (let axis = 0; axis < 3; axis++) if (!(Math.abs((one[axis] ?? 0) - (other[axis] ?? 0)) < this.fine)) return false;
    return true;
  }
}

/** The only one: lines of one run at a time are wanted, and a long run is drawn many times while it goes on. */
const builder = new Builder();
const phase = new Phase();
const parts = new Parts();

/** The lines of a run, if it has any; nothing if they are wanted no more. */
export async function segments(motion: Motion, tone: Tone, isWanted: () => boolean): Promise<Segments | undefined> {
  const breath = new Breath();
  const isPath = motion.low[0] <= motion.high[0];
  const [low, high]: [Places, Places] = isPath ? [[...motion.low], [...motion.high]] : [[0, 0, 0], [0, 0, 0]];
  const size = Math.max(...low.map((mm, axis) => (high[axis] ?? mm) - mm), 1e-3);
  for (let fine = size * FINEST; ; fine *= 2) {
    builder.begin(fine);
    for (let row = 0; row < motion.length && !builder.isFull; row++) {
      if (row % IN_ONE_GO === 0 && breath.isDue) {
        await breath.take();
        if (!isWanted()) return undefined;
      }
      if (motion.read(row, phase).isHoming) continue;
      parts.count = 0;
      tone.divide(motion, phase, parts);
      for (let index = 0; index < parts.count; index++) builder.part(phase, parts, index);
    }
    builder.finish();
    if (!builder.isFull) return builder.made(low, high);
  }
}
