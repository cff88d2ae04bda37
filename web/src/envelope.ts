// The lowest and highest speed, acceleration and jerk of each axis in blocks of phases, so that a long run can be drawn at once.

import { Column } from "./column";
import { AXES, type Motion } from "./motion";

/** Phases of a block. */
export const BLOCK = 64;
/** Speed, acceleration and jerk. */
export const QUANTITIES = 3;
const NUMBERS = AXES * QUANTITIES;

export class Envelope {
  private readonly lows = new Column<Float32Array>(new Float32Array(1024));
  private readonly highs = new Column<Float32Array>(new Float32Array(1024));
  private done = 0;

  constructor(private readonly motion: Motion) {}

  /** Takes those blocks in that are whole by now. */
  grow(): void {
    for (; this.done + BLOCK <= this.motion.length; this.done += BLOCK) {
      const [low, high] = [new Float32Array(NUMBERS), new Float32Array(NUMBERS)];
      for (let row = this.done; row < this.done + BLOCK; row++) this.take(row, low, high);
      this.lows.push(low);
      this.highs.push(high);
    }
  }

  /** Blocks that are whole. */
  get length(): number {
    return this.done / BLOCK;
  }

  /** The lowest and highest value of an axis in a block. */
  range(block: number, axis: number, quantity: number): [number, number] {
    const at = block * NUMBERS + axis * QUANTITIES + quantity;
    return [this.lows.at(at), this.highs.at(at)];
  }

  private take(row: number, low: Float32Array, high: Float32Array): void {
    if (this.motion.isHoming(row)) return;
    const span = this.motion.to(row) - this.motion.from(row);
    for (let axis = 0; axis < AXES; axis++) {
      for (const after of [0, span / 2, span]) {
        const { speed, accel, jerk } = this.motion.axis(row, axis, after);
        [speed, accel, jerk].forEach((value, quantity) => {
          const at = axis * QUANTITIES + quantity;
          low[at] = Math.min(low[at] ?? 0, value);
          high[at] = Math.max(high[at] ?? 0, value);
        });
      }
    }
  }
}
