// Speed, acceleration and jerk of each axis over time, with the equal intervals shaded.

import type uPlot from "uplot";
import { A, AXIS_NAMES, unitOf } from "./axes";
import { Charts, type Data } from "./charts";
import { button, part } from "./elements";
import { colour } from "./drawing";
import { Kind, Motion } from "./motion";

/** With more phases than this in view, the lowest and highest values of equal parts of the time are drawn. */
const ROWS_MAX = 2_000;
/** Parts of the time in view, some of the width of a pixel. */
const BINS = 1_200;
/** Points of a phase in which the acceleration changes. */
const POINTS = 8;
const SHADES: Partial<Record<Kind, string>> = {
  [Kind.Accelerate]: "accel",
  [Kind.Cruise]: "cruise",
  [Kind.Decelerate]: "decel",
};
const QUANTITIES = [["Speed", "s"], ["Acceleration", "s²"], ["Jerk", "s³"]] as const;
/** Axes of one chart: the degrees of A have a chart of their own for each quantity. */
const GROUPS = [[0, 1, 2], [A]];
const CHARTS = QUANTITIES.flatMap((_, quantity) => GROUPS.map((axes) => ({ quantity, axes })));

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

/** What a chart shows, with its unit. */
function nameOf({ quantity, axes }: (typeof CHARTS)[number], isRotary: boolean): string {
  const [name, seconds] = QUANTITIES[quantity] ?? ["", ""];
  const [first = 0] = axes;
  return `${name}${first === A ? " of A" : ""}, ${unitOf(first, isRotary)}/${seconds}`;
}

export class Curves {
  private motion = new Motion();
  private span: [number, number] = [0, 1];
  private time = 0;
  private readonly charts: Charts;

  constructor(onPick: (time: number) => void) {
    this.charts = new Charts(
      part("curves"),
      CHARTS.map((chart) => ({ name: nameOf(chart, true), lines: chart.axes.map((axis) => ({ name: AXIS_NAMES[axis] ?? "", colour: (AXIS_NAMES[axis] ?? "").toLowerCase() })) })),
      { data: (from, to) => this.data(from, to), zoomed: (from, to) => this.look(from, to), picked: onPick, under: (plot) => this.shade(plot) },
    );
    button("zoom-in").onclick = () => this.zoom(0.5);
    button("zoom-out").onclick = () => this.zoom(2);
    button("zoom-all").onclick = () => this.all();
    button("earlier").onclick = () => this.shift(-0.25);
    button("later").onclick = () => this.shift(0.25);
  }

  show(motion: Motion): void {
    this.motion = motion;
    CHARTS.forEach((chart, index) => this.charts.name(index, nameOf(chart, motion.isRotary)));
    part("key-a").hidden = motion.axes <= A;
    this.all();
  }

  at(time: number): void {
    this.time = time;
    this.charts.at(time);
  }

  /** All of the program, without homing. */
  private all(): void {
    const { motion } = this;
    let row = 0;
    while (row < motion.length && motion.isHoming(row)) row++;
    if (row < motion.length) this.look(motion.from(row), motion.end);
    else this.look(0, Math.max(1, motion.end));
  }

  private zoom(factor: number): void {
    const [from, to] = this.span;
    // After a run the time is its end, which is nothing that anybody has chosen.
    const isChosen = this.time > from && this.time < Math.min(to, this.motion.end);
    const middle = isChosen ? this.time : (from + to) / 2;
    this.look(middle - (middle - from) * factor, middle + (to - middle) * factor);
  }

  private shift(share: number): void {
    const by = share * (this.span[1] - this.span[0]);
    this.look(this.span[0] + by, this.span[1] + by);
  }

  private look(from: number, to: number): void {
    const wide = Math.min(Math.max(to - from, 1e-4), Math.max(this.motion.end, 1));
    const begin = Math.min(Math.max(0, from), Math.max(0, this.motion.end - wide));
    this.span = [begin, begin + wide];
    this.charts.show(...this.span);
    this.charts.at(this.time);
  }

  private data(from: number, to: number): Data[] {
    const [first, last] = this.rows(from, to);
    if (last - first > ROWS_MAX) return this.extremes(from, to);
    const points = new Points(this.motion.axes);
    this.addRows(points, first, last, [from, to]);
    return points.data;
  }

  private rows(from: number, to: number): [number, number] {
    return [Math.max(0, this.motion.rowAt(from)), this.motion.rowAt(to)];
  }

  private addRows(points: Points, first: number, last: number, [begin, end]: [number, number]): void {
    const { motion } = this;
    const all = Array.from({ length: motion.axes }, (_, axis) => axis);
    const rest = (time: number): void => points.add(time, () => 0);
    let ended = begin;
    for (let row = first; row <= last; row++) {
      if (motion.isHoming(row)) continue;
      const [from, to] = [Math.max(begin, motion.from(row)), Math.min(end, motion.to(row))];
      if (from - ended > 1e-6) [ended, from].forEach(rest);
      ended = to;
      const count = all.some((axis) => motion.axis(row, axis, 0).jerk) ? POINTS : 1;
      for (let point = 0; point <= count && to > from; point++) {
        const after = from + ((to - from) * point) / count - motion.from(row);
        const axes = all.map((axis) => motion.axis(row, axis, after));
        points.add(motion.from(row) + after, (axis, quantity) => [axes[axis]?.speed, axes[axis]?.accel, axes[axis]?.jerk][quantity] ?? 0);
      }
    }
    if (ended < end) [ended, end].forEach(rest);
  }

  private extremes(from: number, to: number): Data[] {
    const bins = this.motion.envelope.bins(from, Math.min(to, this.motion.end), BINS);
    const column = (value: (bin: number, isHigh: boolean) => number): number[] => Array.from({ length: 2 * BINS }, (_, point) => value(point >> 1, point % 2 === 1));
    const times = column((bin) => bins.middle(bin));
    return CHARTS.map(({ quantity, axes }) => {
      const isThere = axes.every((axis) => axis < this.motion.axes);
      return [isThere ? times : [], ...axes.map((axis) => (isThere ? column((bin, isHigh) => bins.value(bin, axis, quantity, isHigh)) : []))];
    });
  }

  private shade(plot: uPlot): void {
    const { motion } = this;
    const [first, last] = this.rows(...this.span);
    if (!motion.length || last - first > ROWS_MAX) return;
    const { left, top, width, height } = plot.bbox;
    const x = (time: number): number => Math.min(left + width, Math.max(left, plot.valToPos(time, "x", true)));
    for (let row = first, next = row; row <= last; row = next) {
      // Phases of one interval are shaded together, so that no seams show.
      next = row + 1;
      while (next <= last && motion.kind(next) === motion.kind(row) && motion.from(next) <= motion.to(next - 1) + 1e-9) next++;
      const shade = SHADES[motion.kind(row)];
      const [from, to] = [x(motion.from(row)), x(motion.to(next - 1))];
      if (!shade || motion.isHoming(row) || to - from < 0.5) continue;
      plot.ctx.fillStyle = colour(shade);
      plot.ctx.fillRect(from, top, to - from, height);
    }
  }
}
