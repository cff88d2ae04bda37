// What the curves show of a span of time: points of each chart, or, of many phases, the lowest and highest values in equal parts of it.

import { A } from "./axes";
import type { Data } from "./charts";
import { QUANTITIES } from "./envelope";
import type { Motion } from "./motion";

/** With more phases than this in view, the lowest and highest values of equal parts of the time are drawn. */
export const ROWS_MAX = 2_000;
/** Parts of the time in view, some of the width of a pixel. */
const BINS = 1_200;
/** Points of a phase in which the acceleration changes. */
const POINTS = 8;
/** Axes of one chart: the degrees of A have a chart of their own for each quantity. */
const GROUPS = [[0, 1, 2], [A]];
export const CHARTS = Array.from({ length: QUANTITIES }).flatMap((_, quantity) => GROUPS.map((axes) => ({ quantity, axes })));

/** Data that grows by a point: a time, and the value of each axis, of each chart. */
class Points {
  readonly data: Data[] = CHARTS.map(({ axes }) => Array.from({ length: 1 + axes.length }, () => []));

  constructor(private readonly axes: number) {}

  add(time: number, value: (axis: number, quantity: number) => number): void {
    CHARTS.forEach(({ quantity, axes }, index) => {
      if (axes.some((axis) => axis >= this.axes)) return;
      this.data[index]?.[0]?.push(time);
      axes.forEach((axis, line) => this.data[index]?.[line + 1]?.push(value(axis, quantity)));
    });
  }
}

/** The first and the last phase in a span of time. */
export function rowsIn(motion: Motion, from: number, to: number): [number, number] {
  return [Math.max(0, motion.rowAt(from)), motion.rowAt(to)];
}

/** The data of each chart in a span of time. */
export function samples(motion: Motion, from: number, to: number): Data[] {
  const [first, last] = rowsIn(motion, from, to);
  if (last - first > ROWS_MAX) return extremes(motion, from, to);
  const points = new Points(motion.axes);
  addRows(motion, points, first, last, [from, to]);
  return points.data;
}

function addRows(motion: Motion, points: Points, first: number, last: number, [begin, end]: [number, number]): void {
  const all = Array.from({ length: motion.axes }, (_, axis) => axis);
  const rest = (time: number): void => points.add(time, () => 0);
  let ended = begin;
  for (let row = first; row <= last; row++) {
    const phase = motion.read(row);
    if (phase.isHoming) continue;
    const [from, to] = [Math.max(begin, phase.from), Math.min(end, motion.to(row))];
    if (from - ended > 1e-6) [ended, from].forEach(rest);
    ended = to;
    const count = all.some((axis) => phase.jerk(axis)) ? POINTS : 1;
    for (let point = 0; point <= count && to > from; point++) {
      const after = from + ((to - from) * point) / count - phase.from;
      points.add(phase.from + after, (axis, quantity) => [phase.speed(axis, after), phase.accel(axis, after), phase.jerk(axis)][quantity] ?? 0);
    }
  }
  if (ended < end) [ended, end].forEach(rest);
}

function extremes(motion: Motion, from: number, to: number): Data[] {
  const bins = motion.envelope.bins(from, Math.min(to, motion.end), BINS);
  const column = (value: (bin: number, isHigh: boolean) => number): number[] => Array.from({ length: 2 * BINS }, (_, point) => value(point >> 1, point % 2 === 1));
  const times = column((bin) => bins.middle(bin));
  return CHARTS.map(({ quantity, axes }) => {
    const isThere = axes.every((axis) => axis < motion.axes);
    return [isThere ? times : [], ...axes.map((axis) => (isThere ? column((bin, isHigh) => bins.value(bin, axis, quantity, isHigh)) : []))];
  });
}
