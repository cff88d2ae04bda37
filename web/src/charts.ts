// Charts over time, one below the other, with the same times: zoomed by dragging, with values at the pointer.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import { colour, onChange } from "./drawing";

export interface Chart {
  name: string;
  /** Names of the lines and of their colours. */
  lines: { name: string; colour: string }[];
}

/** Data of one chart: times, and the values of each line. */
export type Data = (number | null)[][];

export interface Owner {
  /** The data of each chart for a span of time. */
  data(from: number, to: number): Data[];
  /** Somebody has dragged over a span of time. */
  zoomed?(from: number, to: number): void;
  /** Somebody has clicked on a time. */
  picked?(time: number): void;
  /** What is below the lines. */
  under?(plot: uPlot): void;
}

const FONT = '12px system-ui, "DejaVu Sans", sans-serif';
const AXIS = { stroke: () => colour("muted"), grid: { stroke: () => colour("grid"), width: 1 }, ticks: { show: false }, font: FONT };

const NO_SIZE = { width: 100, height: 50 };

/** A range of values that are at rest at zero most of the time. */
function rangeOf(low: number | null, high: number | null): uPlot.Range.MinMax {
  const [least, most] = [Math.min(low ?? 0, 0), Math.max(high ?? 0, 0)];
  return most - least < 1e-6 ? [-1, 1] : uPlot.rangeNum(least, most, 0.08, true);
}

export class Charts {
  private readonly plots: uPlot[];
  private readonly cursors: HTMLElement[];
  private span: [number, number] = [0, 1];
  private time: number | undefined;

  constructor(
    private readonly place: HTMLElement,
    charts: Chart[],
    private readonly owner: Owner,
  ) {
    const key = place.id;
    this.plots = charts.map((chart, index) => this.plot(chart, key, index === charts.length - 1));
    this.cursors = this.plots.map((plot) => plot.over.appendChild(Object.assign(document.createElement("i"), { className: "cursor", hidden: true })));
    onChange(place, () => this.fit());
  }

  show(from: number, to: number): void {
    this.span = [from, to];
    const data = this.owner.data(from, to);
    this.plots.forEach((plot, index) => {
      // A quantity that is 0 all the time needs no picture, and no room for one.
      const isNone = (data[index] ?? []).slice(1).every((values) => values.every((value) => !value));
      plot.root.hidden = isNone;
      const { width, height } = isNone ? NO_SIZE : this.size();
      if (plot.width !== width || plot.height !== height) plot.setSize({ width, height });
      plot.batch(() => {
        plot.setData((data[index] ?? [[]]) as uPlot.AlignedData, false);
        plot.setScale("x", { min: from, max: to });
      });
    });
    this.place.dataset["points"] = String(data.reduce((sum, chart) => sum + chart.length * (chart[0]?.length ?? 0), 0));
  }

  /** Another name for a chart. */
  name(index: number, name: string): void {
    const title = this.plots[index]?.root.querySelector(".u-title");
    if (title) title.textContent = name;
  }

  /** Marks a time. */
  at(time: number): void {
    this.time = time;
    this.mark(time);
  }

  private mark(time: number): void {
    const isInside = time >= this.span[0] && time <= this.span[1];
    this.plots.forEach((plot, index) => {
      const cursor = this.cursors[index];
      if (!cursor) return;
      cursor.hidden = !isInside;
      cursor.style.left = `${plot.valToPos(time, "x")}px`;
    });
  }

  private plot(chart: Chart, key: string, isLast: boolean): uPlot {
    const options: uPlot.Options = {
      ...NO_SIZE,
      title: chart.name,
      cursor: { sync: { key, filters: { pub: (type) => type.startsWith("mousemove") || type === "mouseleave" } }, drag: { x: true, y: false, setScale: false }, bind: { dblclick: () => null } },
      scales: { x: { time: false }, y: { range: (_, low, high) => rangeOf(low, high) } },
      axes: [{ ...AXIS, size: isLast ? 34 : 22 }, { ...AXIS, size: 70 }],
      series: [
        { label: "s", value: (_, time) => (time === null ? "" : time.toFixed(4)) },
        ...chart.lines.map((line) => ({
          label: line.name,
          stroke: () => colour(line.colour),
          width: 1.75,
          points: { show: false },
          value: (_: uPlot, value: number | null) => (value === null || value === undefined ? "" : value.toFixed(2)),
        })),
      ],
      hooks: {
        drawClear: [(plot) => this.owner.under?.(plot)],
        setSelect: [(plot) => this.selected(plot)],
        ready: [(plot) => plot.over.addEventListener("click", (event) => this.owner.picked?.(plot.posToVal(event.offsetX, "x")))],
      },
    };
    return new uPlot(options, [[]], this.place);
  }

  private selected(plot: uPlot): void {
    const { left, width } = plot.select;
    if (width < 3) return;
    const [from, to] = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
    plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.owner.zoomed?.(from, to);
  }

  private size(): { width: number; height: number } {
    return { width: Math.max(this.place.clientWidth, 200), height: 190 };
  }

  private fit(): void {
    this.show(...this.span);
    if (this.time !== undefined) this.mark(this.time);
  }
}
