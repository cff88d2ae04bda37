// A run as lines to draw: bounded in number, in the order of time, each with its colour.

import type { Motion, Places } from "../motion";
import type { Tone } from "./tone";

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
  /** Lines that are there, each with its number from 1 in the first free place from that of its hash on. */
  private readonly table = new Int32Array(TABLE);
  readonly made: Segments;
  /** Where the line that gathers begins, and where it has come to; then the ends of a part. Numbers in one place, as objects for every part of a long run
   * would be much to clear away. */
  private readonly from = new Float64Array(3);
  private readonly last = new Float64Array(3).fill(Infinity);
  private readonly begins = new Float64Array(3);
  private readonly ends = new Float64Array(3);
  private rank = -1;
  private end = 0;
  private isOpen = false;

  constructor(low: Places, high: Places, private readonly fine: number) {
    const [places, ranks, ends] = [new Float32Array(6 * SEGMENTS_MAX), new Uint8Array(SEGMENTS_MAX), new Float64Array(SEGMENTS_MAX)];
    this.made = { count: 0, fine, places, ranks, ends, low, high };
  }

  get isFull(): boolean {
    return this.made.count >= SEGMENTS_MAX;
  }

  /** Goes on by a part of a phase. What is shorter than can be seen is drawn with what follows. */
  part(motion: Motion, row: number, from: number, to: number, rank: number): void {
    motion.placesIn(row, from, this.begins);
    motion.placesIn(row, to, this.ends);
    if (rank !== this.rank || !isNear(this.last, this.begins, this.fine)) {
      this.finish();
      this.from.set(this.begins);
    }
    this.last.set(this.ends);
    this.rank = rank;
    this.end = motion.from(row) + to;
    this.isOpen = true;
    if (isNear(this.from, this.ends, this.fine)) return;
    this.finish();
    this.from.set(this.ends);
  }

  /** Draws what has gathered, unless a line of this colour is there already. */
  finish(): void {
    if (!this.isOpen || this.isFull) return;
    this.isOpen = false;
    const { made } = this;
    made.places.set(this.from, 6 * made.count);
    made.places.set(this.last, 6 * made.count + 3);
    made.ranks[made.count] = this.rank;
    made.ends[made.count] = this.end;
    if (!this.isThere(made.count)) made.count++;
  }

  /** Whether a line of the same colour is there already, as far as can be seen. Otherwise it is from now on. */
  private isThere(line: number): boolean {
    const { ranks } = this.made;
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
    return Math.round((this.made.places[6 * line + end] ?? 0) / this.fine);
  }
}

/** Whether two places are so near that nobody sees them apart. */
function isNear(one: Float64Array, other: Float64Array, fine: number): boolean {
  for (let axis = 0; axis < 3; axis++) if (!(Math.abs((one[axis] ?? 0) - (other[axis] ?? 0)) < fine)) return false;
  return true;
}

/** The lines of a run, if it has any; nothing if they are wanted no more. */
export async function segments(motion: Motion, tone: Tone, isWanted: () => boolean): Promise<Segments | undefined> {
  const breath = new Breath();
  const isPath = motion.low[0] <= motion.high[0];
  const [low, high]: [Places, Places] = isPath ? [[...motion.low], [...motion.high]] : [[0, 0, 0], [0, 0, 0]];
  const size = Math.max(...low.map((mm, axis) => (high[axis] ?? mm) - mm), 1e-3);
  for (let fine = size * FINEST; ; fine *= 2) {
    const builder = new Builder(low, high, fine);
    for (let row = 0; row < motion.length && !builder.isFull; row++) {
      if (row % IN_ONE_GO === 0 && breath.isDue) {
        await breath.take();
        if (!isWanted()) return undefined;
      }
      if (!motion.isHoming(row)) tone.parts(motion, row, (from, to, rank) => builder.part(motion, row, from, to, rank));
    }
    builder.finish();
    if (!builder.isFull) return builder.made;
  }
}
