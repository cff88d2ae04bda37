// Speed, acceleration and jerk of each axis over time, with the equal intervals shaded.

import type uPlot from "uplot";
import { A, AXIS_NAMES, unitOf } from "./axes";
import { Charts } from "./charts";
import { button, part } from "./elements";
import { colour } from "./drawing";
import { Kind, Motion } from "./motion";
import { CHARTS, ROWS_MAX, rowsIn, samples } from "./samples";

const SHADES: Partial<Record<Kind, string>> = {
  [Kind.Accelerate]: "accel",
  [Kind.Cruise]: "cruise",
  [Kind.Decelerate]: "decel",
};
const NAMES = [["Speed", "s"], ["Acceleration", "s²"], ["Jerk", "s³"]] as const;

/** What a chart shows, with its unit. */
function nameOf({ quantity, axes }: (typeof CHARTS)[number], isRotary: boolean): string {
  const [name, seconds] = NAMES[quantity] ?? ["", ""];
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
      { data: (from, to) => samples(this.motion, from, to), zoomed: (from, to) => this.look(from, to), picked: onPick, under: (plot) => this.shade(plot) },
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
    while (row < motion.length && motion.read(row).isHoming) row++;
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

  private shade(plot: uPlot): void {
    const { motion } = this;
    const [first, last] = rowsIn(motion, ...this.span);
    if (!motion.length || last - first > ROWS_MAX) return;
    const { left, top, width, height } = plot.bbox;
    const x = (time: number): number => Math.min(left + width, Math.max(left, plot.valToPos(time, "x", true)));
    for (let row = first, next = row; row <= last; row = next) {
      // Phases of one interval are shaded together, so that no seams show.
      next = row + 1;
      const { kind, isHoming } = motion.read(row);
      while (next <= last && motion.read(next).kind === kind && motion.from(next) <= motion.to(next - 1) + 1e-9) next++;
      const shade = SHADES[kind];
      const [from, to] = [x(motion.from(row)), x(motion.to(next - 1))];
      if (!shade || isHoming || to - from < 0.5) continue;
      plot.ctx.fillStyle = colour(shade);
      plot.ctx.fillRect(from, top, to - from, height);
    }
  }
}
