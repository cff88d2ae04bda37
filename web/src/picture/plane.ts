// A plane of the machine on a canvas: where places are, with a grid, the travel and the zero of the work.

import { colour, label, roundStep } from "../drawing";
import { AXIS_NAMES } from "../axes";

const MARGIN = { left: 46, right: 14, top: 14, bottom: 34 };
/** Room around what is drawn, as a share of it. */
const ROOM = 0.06;
/** The least that is looked at, mm. */
const LEAST_MM = 1;
/** Lines of the grid are no nearer than this, px. */
const GRID_PX = 64;

/** What is looked at: the place in the middle, mm, and how large a millimetre is, px. */
export interface Window {
  middle: [number, number];
  scale: number;
}

/** The window in which all these places are seen. */
export function fitted(axes: [number, number], low: number[], high: number[], width: number, height: number): Window {
  const [x, y] = axes.map((axis) => [low[axis] ?? 0, high[axis] ?? 0]) as [[number, number], [number, number]];
  const room = Math.max(x[1] - x[0], y[1] - y[0], LEAST_MM) * ROOM;
  const inner = [Math.max(width - MARGIN.left - MARGIN.right, 1), Math.max(height - MARGIN.top - MARGIN.bottom, 1)] as const;
  const scale = Math.min(inner[0] / (x[1] - x[0] + 2 * room), inner[1] / (y[1] - y[0] + 2 * room));
  return { middle: [(x[0] + x[1]) / 2, (y[0] + y[1]) / 2], scale };
}

export class Plane {
  private readonly left: number;
  private readonly bottom: number;

  constructor(
    private readonly axes: [number, number],
    readonly window: Window,
    private readonly width: number,
    private readonly height: number,
  ) {
    this.left = MARGIN.left + (width - MARGIN.left - MARGIN.right) / 2;
    this.bottom = MARGIN.top + (height - MARGIN.top - MARGIN.bottom) / 2;
  }

  /** Where a place is on the canvas. */
  at(places: ArrayLike<number>, from = 0): [number, number] {
    return [this.x(places[from + this.axes[0]] ?? 0), this.y(places[from + this.axes[1]] ?? 0)];
  }

  /** Adds the line from one place to the next to what is drawn. */
  line(context: CanvasRenderingContext2D, places: ArrayLike<number>, from: number): void {
    const [x, y] = [from + this.axes[0], from + this.axes[1]];
    context.moveTo(this.x(places[x] ?? 0), this.y(places[y] ?? 0));
    context.lineTo(this.x(places[x + 3] ?? 0), this.y(places[y + 3] ?? 0));
  }

  /** Which place is there, mm. */
  placeAt(x: number, y: number): [number, number] {
    const { middle, scale } = this.window;
    return [middle[0] + (x - this.left) / scale, middle[1] - (y - this.bottom) / scale];
  }

  grid(context: CanvasRenderingContext2D): void {
    const { width, height } = this;
    const [right, bottom] = [width - MARGIN.right, height - MARGIN.bottom];
    const step = roundStep((right - MARGIN.left) / this.window.scale, Math.max(1, Math.floor((right - MARGIN.left) / GRID_PX)));
    const [[lowX, highY], [highX, lowY]] = [this.placeAt(MARGIN.left, MARGIN.top), this.placeAt(right, bottom)];
    context.lineWidth = 1;
    context.strokeStyle = colour("grid");
    context.fillStyle = colour("muted");
    context.textAlign = "center";
    context.textBaseline = "top";
    for (let mm = Math.ceil(lowX / step) * step; mm <= highX; mm += step) {
      line(context, [this.x(mm), MARGIN.top], [this.x(mm), bottom]);
      if (this.x(mm) < right - 52) context.fillText(label(mm, step), this.x(mm), bottom + 6);
    }
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (let mm = Math.ceil(lowY / step) * step; mm <= highY; mm += step) {
      line(context, [MARGIN.left, this.y(mm)], [right, this.y(mm)]);
      if (this.y(mm) > MARGIN.top + 18) context.fillText(label(mm, step), MARGIN.left - 7, this.y(mm));
    }
    this.letters(context, right, bottom);
  }

  /** As far as the axes can go, from the machine's zero. */
  travel(context: CanvasRenderingContext2D, travel: number[]): void {
    const [x, y] = this.axes.map((axis) => travel[axis] ?? 0);
    if (!x || !y) return;
    this.clipped(context, () => {
      context.setLineDash([6, 4]);
      context.lineWidth = 1.5;
      context.strokeStyle = colour("bound");
      context.strokeRect(this.x(0), this.y(y), x * this.window.scale, y * this.window.scale);
    });
  }

  /** A cross in a circle, as drawings mark an origin. */
  zero(context: CanvasRenderingContext2D, zero: number[]): void {
    const [x, y] = this.at(zero);
    this.clipped(context, () => {
      context.lineWidth = 1.5;
      context.strokeStyle = colour("ink");
      line(context, [x - 13, y], [x + 13, y]);
      line(context, [x, y - 13], [x, y + 13]);
      context.beginPath();
      context.arc(x, y, 7, 0, 2 * Math.PI);
      context.stroke();
    });
  }

  /** Draws no farther than the grid goes. */
  clipped(context: CanvasRenderingContext2D, draw: () => void): void {
    context.save();
    context.beginPath();
    context.rect(MARGIN.left, MARGIN.top, this.width - MARGIN.left - MARGIN.right, this.height - MARGIN.top - MARGIN.bottom);
    context.clip();
    draw();
    context.restore();
  }

  private letters(context: CanvasRenderingContext2D, right: number, bottom: number): void {
    const [across, up] = this.axes.map((axis) => AXIS_NAMES[axis] ?? "");
    context.save();
    context.font = context.font.replace(/^\S+/, "bold 13px");
    context.textBaseline = "top";
    context.textAlign = "right";
    context.fillStyle = colour((across ?? "").toLowerCase());
    context.fillText(`${across} mm`, right, bottom + 5);
    context.fillStyle = colour((up ?? "").toLowerCase());
    context.fillText(up ?? "", MARGIN.left - 7, MARGIN.top);
    context.restore();
  }

  private x(mm: number): number {
    return this.left + (mm - this.window.middle[0]) * this.window.scale;
  }

  private y(mm: number): number {
    return this.bottom - (mm - this.window.middle[1]) * this.window.scale;
  }
}

function line(context: CanvasRenderingContext2D, from: [number, number], to: [number, number]): void {
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.stroke();
}
