// A run as lines to draw: bounded in number, in the order of time, each with its colour.

import type { Motion } from "../motion";
import type { Tone } from "./tone";

/** No picture has more lines than this, however long the program is. */
export const SEGMENTS_MAX = 60_000;
/** Nothing is drawn more finely than this share of the whole. */
const FINE = 1 / 3000;
/** The page answers in between, ms. */
const SLICE_MS = 8;

export interface Segments {
  count: number;
  /** From and to: six numbers each, mm. */
  places: Float32Array;
  ranks: Uint8Array;
  /** When each was first made, s. */
  ends: Float64Array;
  /** Where the path is, mm: from and to. Of no path from 0 to 0. */
  low: [number, number, number];
  high: [number, number, number];
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
  private readonly seen = new Set<string>();
  readonly made: Segments;
  private from: number[] = [];
  private last: number[] = [];
  private rank = -1;
  private end = 0;
  private isOpen = false;

  constructor(low: [number, number, number], high: [number, number, number], private readonly fine: number) {
    const [places, ranks, ends] = [new Float32Array(6 * SEGMENTS_MAX), new Uint8Array(SEGMENTS_MAX), new Float64Array(SEGMENTS_MAX)];
    this.made = { count: 0, places, ranks, ends, low, high };
  }

  get isFull(): boolean {
    return this.made.count >= SEGMENTS_MAX;
  }

  /** Goes on to a place. What is shorter than can be seen is drawn with what follows. */
  line(from: number[], to: number[], rank: number, end: number): void {
    if (rank !== this.rank || this.far(this.last, from) >= this.fine) {
      this.finish();
      this.from = from;
    }
    [this.last, this.rank, this.end, this.isOpen] = [to, rank, end, true];
    if (this.far(this.from, to) < this.fine) return;
    this.finish();
    this.from = to;
  }

  /** Draws what has gathered, unless a line of this colour is there already. */
  finish(): void {
    if (!this.isOpen || this.isFull) return;
    this.isOpen = false;
    const both = [...this.from, ...this.last];
    const key = `${this.rank} ${both.map((mm) => Math.round(mm / this.fine)).join(" ")}`;
    if (this.seen.has(key)) return;
    this.seen.add(key);
    const { made } = this;
    made.places.set(both, 6 * made.count);
    made.ranks[made.count] = this.rank;
    made.ends[made.count] = this.end;
    made.count++;
  }

  private far(one: number[], other: number[]): number {
    return Math.max(...one.map((mm, axis) => Math.abs(mm - (other[axis] ?? Infinity))));
  }
}

/** The lines of a run, if it has any; nothing if they are wanted no more. */
export async function segments(motion: Motion, tone: Tone, isWanted: () => boolean): Promise<Segments | undefined> {
  const breath = new Breath();
  const bounds = await boundsOf(motion, breath, isWanted);
  if (!bounds) return undefined;
  const size = Math.max(...bounds.high.map((high, axis) => high - (bounds.low[axis] ?? 0)), 1e-3);
  for (let fine = size * FINE; ; fine *= 2) {
    const builder = new Builder(bounds.low, bounds.high, fine);
    for (let row = 0; row < motion.length && !builder.isFull; row++) {
      if (breath.isDue) {
        await breath.take();
        if (!isWanted()) return undefined;
      }
      if (!motion.isHoming(row)) add(builder, motion, tone, row);
    }
    builder.finish();
    if (!builder.isFull) return builder.made;
  }
}

function add(builder: Builder, motion: Motion, tone: Tone, row: number): void {
  const begin = motion.from(row);
  tone.parts(motion, row, (from, to, rank) => {
    builder.line(motion.placesIn(row, from), motion.placesIn(row, to), rank, begin + to);
  });
}

async function boundsOf(motion: Motion, breath: Breath, isWanted: () => boolean): Promise<Pick<Segments, "low" | "high"> | undefined> {
  const low: [number, number, number] = [Infinity, Infinity, Infinity];
  const high: [number, number, number] = [-Infinity, -Infinity, -Infinity];
  for (let row = 0; row < motion.length; row++) {
    if (breath.isDue) {
      await breath.take();
      if (!isWanted()) return undefined;
    }
    if (motion.isHoming(row)) continue;
    for (const after of [0, motion.to(row) - motion.from(row)]) {
      motion.placesIn(row, after).forEach((mm, axis) => {
        low[axis] = Math.min(low[axis] ?? mm, mm);
        high[axis] = Math.max(high[axis] ?? mm, mm);
      });
    }
  }
  return low[0] <= high[0] ? { low, high } : { low: [0, 0, 0], high: [0, 0, 0] };
}
