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
/** X, Y, Z and A. */
const AXES_MAX = 4;
/** Places of numbers of a phase. */
const [FROM, SPAN, PAUSE, LOAD, JUMP, ASKED, NUMBERS] = [0, 1, 2, 3, 4, 5, 6];
const KIND_MASK = 7;
const HOMING = 8;
const SHAPED = 16;

/** A phase of a motion, which is read for one after the other: objects or numbers by themselves for every phase of a long run would be
 * much to clear away. Times are counted from its beginning. */
export class Phase {
  kind: Kind = Kind.Blend;
  isHoming = false;
  isShaped = false;
  axes = 0;
  /** See the names of their places. */
  readonly numbers = new Float64Array(NUMBERS);
  /** Of each axis where it begins, mm and s. */
  readonly places = new Float64Array(AXES_MAX);
  readonly speeds = new Float64Array(AXES_MAX);
  readonly accels = new Float64Array(AXES_MAX);
  /** Throughout. */
  readonly jerks = new Float64Array(AXES_MAX);

  get from(): number {
    return this.numbers[FROM] ?? 0;
  }

  /** How long it takes, s. */
  get span(): number {
    return this.numbers[SPAN] ?? 0;
  }

  /** How long it is from its end to the next, s. */
  get pause(): number {
    return this.numbers[PAUSE] ?? 0;
  }

  /** The largest acceleration of any axis, as a share of its limit. */
  get load(): number {
    return (this.numbers[LOAD] ?? 0) / LOAD_PARTS;
  }

  /** The same of the jump of speed where it begins. */
  get jump(): number {
    return (this.numbers[JUMP] ?? 0) / LOAD_PARTS;
  }

  /** The speed along the path that was asked for, mm/s; infinite where nothing was. */
  get asked(): number {
    return this.numbers[ASKED] ?? 0;
  }

  place(axis: number, after: number): number {
    return (this.places[axis] ?? 0) + after * ((this.speeds[axis] ?? 0) + after * ((this.accels[axis] ?? 0) / 2 + (after * (this.jerks[axis] ?? 0)) / 6));
  }

  speed(axis: number, after: number): number {
    return (this.speeds[axis] ?? 0) + after * ((this.accels[axis] ?? 0) + (after * (this.jerks[axis] ?? 0)) / 2);
  }

  accel(axis: number, after: number): number {
    return (this.accels[axis] ?? 0) + after * (this.jerks[axis] ?? 0);
  }

  jerk(axis: number): number {
    return this.jerks[axis] ?? 0;
  }

  /** The speed along the path, mm/s. */
  speedAlong(after: number): number {
    let squares = 0;
    for (let axis = 0; axis < this.axes; axis++) squares += this.speed(axis, after) ** 2;
    return Math.sqrt(squares);
  }

  /** The part of the time in a place that is lost there against the speed that was asked for. */
  lost(after: number): number {
    return this.asked > 0 && Number.isFinite(this.asked) ? Math.max(0, 1 - this.speedAlong(after) / this.asked) : 0;
  }
}

/** A place, or something of each axis. */
export type Places = [number, number, number];

export class Motion {
  private readonly pieces: Columns[] = [];
  private readonly powerTimes = new Column<Float64Array>(Float64Array);
  private readonly powers = new Column<Float32Array>(Float32Array);
  private readonly lineTimes = new Column<Float64Array>(Float64Array);
  private readonly lines = new Column<Uint32Array>(Uint32Array);
  private readonly phase = new Phase();
  readonly envelope = new Envelope(this);
  /** How many phases there are. */
  length = 0;
  /** When the last one ends, s. */
  end = 0;
  /** What is made before is of no interest, as homing is, s. */
  private begin = -Infinity;
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
    piece.powerTimes.forEach((_, index) => this.powerTimes.push(piece.powerTimes, index));
    piece.powers.forEach((_, index) => this.powers.push(piece.powers, index));
    this.note(from);
    this.envelope.grow();
  }

  /** Adds lines, and when they begin to move the machine. */
  addLines({ times, lines }: LineTimes): void {
    times.forEach((_, index) => this.lineTimes.push(times, index));
    lines.forEach((_, index) => this.lines.push(lines, index));
  }

  /** Looks at all phases from one on. */
  private note(first: number): void {
    for (let row = first; row < this.length; row++) {
      const phase = this.read(row);
      this.isShaped ||= phase.isShaped;
      if (phase.isHoming) continue;
      this.topLoad = Math.max(this.topLoad, phase.load, phase.jump);
      let squares = 0;
      for (let axis = 0; axis < this.axes; axis++) {
        const from = phase.place(axis, 0);
        const to = phase.place(axis, phase.span);
        squares += (to - from) ** 2;
        if (axis >= AXES) continue;
        this.low[axis] = Math.min(this.low[axis] ?? from, from, to);
        this.high[axis] = Math.max(this.high[axis] ?? from, from, to);
      }
      if (phase.span > 0) this.topSpeed = Math.max(this.topSpeed, Math.sqrt(squares) / phase.span);
    }
  }

  /** What was made before a time is of no interest, as homing is. */
  beginAt(time: number): void {
    this.begin = time;
    this.topSpeed = this.topLoad = 0;
    this.low.fill(Infinity);
    this.high.fill(-Infinity);
    this.note(0);
  }

  /** Reads a phase, which is there until the next is read. */
  read(row: number, phase = this.phase): Phase {
    const piece = this.pieces[(row / PHASES) | 0];
    if (!piece) throw new Error(`there is no phase ${row}`);
    const at = row % PHASES;
    const { numbers } = phase;
    copy64(piece.begins, at, numbers, FROM);
    copy16(piece.loads, at, numbers, LOAD);
    copy16(piece.jumps, at, numbers, JUMP);
    copy32(piece.asked, at, numbers, ASKED);
    numbers[SPAN] = this.end;
    numbers[PAUSE] = 0;
    const next = this.pieces[((row + 1) / PHASES) | 0];
    if (next && row + 1 < this.length) {
      copy64(next.begins, (row + 1) % PHASES, numbers, SPAN);
      copy64(next.pauses, (row + 1) % PHASES, numbers, PAUSE);
    }
    numbers[SPAN] = phase.span - phase.pause - phase.from;
    phase.axes = this.axes;
    for (let axis = 0; axis < this.axes; axis++) {
      const { places, speeds, accels, changes } = piece.ofAxes[axis] as OfAxis;
      copy32(places, at, phase.places, axis);
      copy32(speeds, at, phase.speeds, axis);
      copy32(accels, at, phase.accels, axis);
      copy32(changes, at, phase.jerks, axis);
      const change = phase.jerks[axis] ?? 0;
      if (change) phase.jerks[axis] = change / phase.span;
    }
    const kinds = piece.kinds[piece.kinds.length > 1 ? at : 0] ?? 0;
    phase.kind = kinds & KIND_MASK;
    phase.isHoming = (kinds & HOMING) !== 0 || phase.from < this.begin;
    phase.isShaped = (kinds & SHAPED) !== 0;
    return phase;
  }

  from(row: number): number {
    return numberOf(this.pieces[(row / PHASES) | 0]?.begins, row % PHASES);
  }

  to(row: number): number {
    const next = row + 1;
    return next < this.length ? this.from(next) - numberOf(this.pieces[(next / PHASES) | 0]?.pauses, next % PHASES) : this.end;
  }

  /** The last phase that has begun at a time; -1 before the first. */
  rowAt(time: number): number {
    return lastAt(this.length, (row) => this.from(row), time);
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
    const last = lastAt(this.lineTimes.length, (index) => this.lineTimes.at(index), time);
    return last < 0 ? 0 : this.lines.at(last);
  }

  /** When a line begins to move the machine; nothing if it never does. */
  timeOf(line: number): number | undefined {
    return this.firstTime((each) => each === line);
  }

  /** When the first line behind one begins to move the machine; nothing if none does. */
  timeBehind(line: number): number | undefined {
    return this.firstTime((each) => each > line);
  }

  private firstTime(is: (line: number) => boolean): number | undefined {
    for (let index = 0; index < this.lines.length; index++) if (is(this.lines.at(index))) return this.lineTimes.at(index);
    return undefined;
  }

  /** Whether the machine is homing at a time, and so does not know where it is. */
  isHomingAt(time: number): boolean {
    return this.length > 0 && this.read(Math.max(0, this.rowAt(time))).isHoming;
  }

  /** Where the axes are at a time. */
  places(time: number): number[] {
    if (!this.length) return new Array(this.axes).fill(0);
    const phase = this.read(Math.max(0, this.rowAt(time)));
    const after = Math.min(Math.max(0, time - phase.from), phase.span);
    return Array.from({ length: this.axes }, (_, axis) => phase.place(axis, after));
  }

  /** The speed along the path at a time, mm/s. */
  speedAt(time: number): number {
    const row = this.rowAt(time);
    return row < 0 || time >= this.to(row) ? 0 : this.read(row).speedAlong(time - this.from(row));
  }
}

// Copies what a column of a piece has for a phase of it: each of one kind, as what takes several makes an object of each number.
function copy64(column: Float64Array, at: number, into: Float64Array, index: number): void {
  into[index] = column[column.length > 1 ? at : 0] as number;
}

function copy32(column: Float32Array, at: number, into: Float64Array, index: number): void {
  into[index] = column[column.length > 1 ? at : 0] as number;
}

function copy16(column: Uint16Array, at: number, into: Float64Array, index: number): void {
  into[index] = column[column.length > 1 ? at : 0] as number;
}

/** What a column of a piece has for a phase of it. */
function numberOf(column: Float64Array | undefined, at: number): number {
  return column?.[column.length > 1 ? at : 0] ?? 0;
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
