// The motion of a run, phase by phase, and what it is at any time.

import { AXES } from "./axes";
import { Column } from "./column";
import { Envelope } from "./envelope";
import type { Columns, LineTimes, OfAxis } from "./messages";

/** Phases of each piece but the last, a power of two: see `piece` in crates/web. */
const PHASES = 4_096;
/** Shares of limits are in such parts: see `LOAD_PARTS` there. */
const LOAD_PARTS = 256;

export enum Kind {
  Blend = 0,
  Accelerate = 1,
  Cruise = 2,
  Decelerate = 3,
}
const KIND_MASK = 7;
const HOMING = 8;
const SHAPED = 16;

/** Place, speed, acceleration and jerk of an axis, in mm and s. */
export interface AxisMotion {
  place: number;
  speed: number;
  accel: number;
  jerk: number;
}

/** A place, or something of each axis. */
export type Places = [number, number, number];

export class Motion {
  private readonly pieces: Columns[] = [];
  private readonly powerTimes = new Column<Float64Array>(Float64Array);
  private readonly powers = new Column<Float32Array>(Float32Array);
  readonly envelope = new Envelope(this);
  /** How many phases there are. */
  length = 0;
  /** When the last one ends, s. */
  end = 0;
  /** What is made before is of no interest, as homing is, s. */
  private begin = -Infinity;
  lines: LineTimes = { times: new Float64Array(), lines: new Uint32Array() };
  isShaped = false;
  topSpeed = 0;
  /** As many as the machine has that made it. */
  axes = AXES;
  /** Whether A is in degrees. */
  isRotary = true;
  /** The largest acceleration of any axis, or jump of its speed, as a share of its limit. */
  topLoad = 0;
  /** Where the path is, mm: from and to. Without a path from Infinity to -Infinity. */
  low: Places = [Infinity, Infinity, Infinity];
  high: Places = [-Infinity, -Infinity, -Infinity];

  /** Adds a piece. Only the last is not whole. */
  add(piece: Columns): void {
    const from = this.length;
    this.pieces.push(piece);
    this.length += piece.phases;
    [this.end, this.axes] = [piece.end, piece.ofAxes.length];
    piece.powerTimes.forEach((time) => this.powerTimes.push(time));
    piece.powers.forEach((share) => this.powers.push(share));
    for (let row = from; row < this.length; row++) {
      this.isShaped ||= (this.kindsOf(row) & SHAPED) !== 0;
      this.note(row);
    }
    this.envelope.grow();
  }

  private note(row: number): void {
    if (this.isHoming(row)) return;
    this.topSpeed = Math.max(this.topSpeed, this.speed(row));
    this.topLoad = Math.max(this.topLoad, this.load(row), this.jump(row));
    const span = this.to(row) - this.from(row);
    for (let axis = 0; axis < AXES; axis++) {
      const from = this.place(row, axis, 0);
      const to = this.place(row, axis, span);
      this.low[axis] = Math.min(this.low[axis] ?? from, from, to);
      this.high[axis] = Math.max(this.high[axis] ?? from, from, to);
    }
  }

  /** What was made before a time is of no interest, as homing is. */
  beginAt(time: number): void {
    this.begin = time;
    this.topSpeed = this.topLoad = 0;
    this.low.fill(Infinity);
    this.high.fill(-Infinity);
    for (let row = 0; row < this.length; row++) this.note(row);
  }

  private pieceOf(row: number): Columns | undefined {
    return this.pieces[(row / PHASES) | 0];
  }

  from(row: number): number {
    return numberOf(this.pieceOf(row)?.begins, row);
  }

  to(row: number): number {
    return row + 1 < this.length ? this.from(row + 1) - numberOf(this.pieceOf(row + 1)?.pauses, row + 1) : this.end;
  }

  private kindsOf(row: number): number {
    return numberOf(this.pieceOf(row)?.kinds, row);
  }

  kind(row: number): Kind {
    return this.kindsOf(row) & KIND_MASK;
  }

  isHoming(row: number): boolean {
    return (this.kindsOf(row) & HOMING) !== 0 || this.from(row) < this.begin;
  }

  /** The mean speed along the path in a phase, mm/s. */
  speed(row: number): number {
    const span = this.to(row) - this.from(row);
    let squares = 0;
    for (let axis = 0; axis < this.axes; axis++) {
      squares += (this.place(row, axis, span) - this.place(row, axis, 0)) ** 2;
    }
    return span > 0 ? Math.sqrt(squares) / span : 0;
  }

  /** An axis in a phase, so long after its beginning. */
  axis(row: number, axis: number, after: number): AxisMotion {
    const [place, speed] = [this.place(row, axis, after), this.speedOf(row, axis, after)];
    return { place, speed, accel: this.accelOf(row, axis, after), jerk: this.jerkOf(row, axis) };
  }

  private ofAxis(row: number, axis: number): OfAxis | undefined {
    return this.pieceOf(row)?.ofAxes[axis];
  }

  /** The place of an axis in a phase, so long after its beginning, mm. */
  place(row: number, axis: number, after: number): number {
    const of = this.ofAxis(row, axis);
    const jerk = this.jerkOf(row, axis);
    return numberOf(of?.places, row) + after * (numberOf(of?.speeds, row) + after * (numberOf(of?.accels, row) / 2 + (after * jerk) / 6));
  }

  /** The speed of an axis in a phase, so long after its beginning, mm/s. */
  speedOf(row: number, axis: number, after: number): number {
    const of = this.ofAxis(row, axis);
    return numberOf(of?.speeds, row) + after * (numberOf(of?.accels, row) + (after * this.jerkOf(row, axis)) / 2);
  }

  /** Its acceleration, mm/s². */
  accelOf(row: number, axis: number, after: number): number {
    return numberOf(this.ofAxis(row, axis)?.accels, row) + after * this.jerkOf(row, axis);
  }

  /** Its jerk, mm/s³. */
  jerkOf(row: number, axis: number): number {
    const change = numberOf(this.ofAxis(row, axis)?.changes, row);
    return change && change / (this.to(row) - this.from(row));
  }

  /** Writes where X, Y and Z are in a phase, so long after its beginning, mm. */
  placesIn(row: number, after: number, into: Float64Array): void {
    for (let axis = 0; axis < AXES; axis++) into[axis] = this.place(row, axis, after);
  }

  /** The last phase that has begun at a time; -1 before the first. */
  rowAt(time: number): number {
    return lastAt(this.length, (row) => this.from(row), time);
  }

  /** The largest acceleration of any axis in a phase, as a share of its limit. */
  load(row: number): number {
    return numberOf(this.pieceOf(row)?.loads, row) / LOAD_PARTS;
  }

  /** The same of the jump of speed where a phase begins. */
  jump(row: number): number {
    return numberOf(this.pieceOf(row)?.jumps, row) / LOAD_PARTS;
  }

  /** The speed along the path that was asked for in a phase, mm/s; infinite where nothing was. */
  askedIn(row: number): number {
    return numberOf(this.pieceOf(row)?.asked, row);
  }

  /** The part of the time in a place that is lost there against the speed that was asked for, so long after the beginning of a phase. */
  lostIn(row: number, after: number): number {
    const asked = this.askedIn(row);
    return asked > 0 && Number.isFinite(asked) ? Math.max(0, 1 - this.speedIn(row, after) / asked) : 0;
  }

  /** Whether the tool was ever given power. */
  get hasPower(): boolean {
    return this.powers.length > 0;
  }

  /** What the tool is given, from 0 to 1, from a time until another. */
  power(time: number): { share: number; until: number } {
    const change = lastAt(this.powerTimes.length, (index) => this.powerTimes.at(index), time);
    const next = change + 1 < this.powerTimes.length ? this.powerTimes.at(change + 1) : Infinity;
    return { share: change < 0 ? 0 : this.powers.at(change), until: next };
  }

  /** The line of the program that moves the machine at a time; 0 for none. */
  lineAt(time: number): number {
    const { times, lines } = this.lines;
    return lines[lastAt(times.length, (index) => times[index] ?? 0, time)] ?? 0;
  }

  /** When a line begins to move the machine; nothing if it never does. */
  timeOf(line: number): number | undefined {
    return this.lines.times[this.lines.lines.indexOf(line)];
  }

  /** Whether the machine is homing at a time, and so does not know where it is. */
  isHomingAt(time: number): boolean {
    return this.length > 0 && this.isHoming(Math.max(0, this.rowAt(time)));
  }

  /** Where the axes are at a time. */
  places(time: number): number[] {
    const row = Math.max(0, this.rowAt(time));
    if (!this.length) return new Array(this.axes).fill(0);
    const after = Math.min(Math.max(0, time - this.from(row)), this.to(row) - this.from(row));
    return Array.from({ length: this.axes }, (_, axis) => this.place(row, axis, after));
  }

  /** The speed along the path at a time, mm/s. */
  speedAt(time: number): number {
    const row = this.rowAt(time);
    return row < 0 || time >= this.to(row) ? 0 : this.speedIn(row, time - this.from(row));
  }

  /** The speed along the path in a phase, so long after its beginning, mm/s. */
  speedIn(row: number, after: number): number {
    let squares = 0;
    for (let axis = 0; axis < this.axes; axis++) squares += this.speedOf(row, axis, after) ** 2;
    return Math.sqrt(squares);
  }
}

/** What a column of a piece has for a phase. */
function numberOf(column: Float64Array | Float32Array | Uint16Array | Uint8Array | undefined, row: number): number {
  return column?.[column.length > 1 ? row % PHASES : 0] ?? 0;
}

/** The last of so many, in order, that is not above a value; -1 if there is none. */
function lastAt(length: number, of: (index: number) => number, value: number): number {
  let [low, high] = [0, length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (of(middle) <= value) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}
