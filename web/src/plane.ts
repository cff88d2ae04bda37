// A plane of the machine on a canvas: where places are, with a grid and the travel.

import { colour, label, roundStep } from "./drawing";
import type { Segments } from "./segments";

const MARGIN = { left: 44, right: 12, top: 12, bottom: 30 };
/** Room around what is drawn, as a share of it. */
const ROOM = 0.06;

export class Plane {
  private readonly low: [number, number];
  private readonly high: [number, number];
  private readonly scale: number;
  private readonly left: number;
  private readonly bottom: number;

  constructor(
    private readonly axes: [number, number],
    { low, high }: Pick<Segments, "low" | "high">,
    width: number,
    height: number,
  ) {
    const ends = axes.map((axis) => [low[axis] ?? 0, high[axis] ?? 0] as const);
    const [[lowX, highX], [lowY, highY]] = ends as [readonly [number, number], readonly [number, number]];
    const room = Math.max(highX - lowX, highY - lowY, 1) * ROOM;
    [this.low, this.high] = [[lowX - room, lowY - room], [highX + room, highY + room]];
    const [spanX, spanY] = [this.high[0] - this.low[0], this.high[1] - this.low[1]];
    const inner = { width: width - MARGIN.left - MARGIN.right, height: height - MARGIN.top - MARGIN.bottom };
    this.scale = Math.min(inner.width / spanX, inner.height / spanY);
    this.left = MARGIN.left + (inner.width - spanX * this.scale) / 2;
    this.bottom = height - MARGIN.bottom - (inner.height - spanY * this.scale) / 2;
  }

  /** Where a place is on the canvas. */
  at(places: ArrayLike<number>, from = 0): [number, number] {
    return [this.x(places[from + this.axes[0]] ?? 0), this.y(places[from + this.axes[1]] ?? 0)];
  }

  grid(context: CanvasRenderingContext2D, travel: number[]): void {
    const step = roundStep(700 / this.scale, 10);
    const [[lowX, lowY], [highX, highY]] = [this.low, this.high];
    context.lineWidth = 1;
    context.strokeStyle = colour("grid");
    context.fillStyle = colour("muted");
    context.textAlign = "center";
    context.textBaseline = "top";
    for (let mm = Math.ceil(lowX / step) * step; mm <= highX; mm += step) {
      line(context, [this.x(mm), this.y(lowY)], [this.x(mm), this.y(highY)]);
      context.fillText(label(mm, step), this.x(mm), this.y(lowY) + 5);
    }
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (let mm = Math.ceil(lowY / step) * step; mm <= highY; mm += step) {
      line(context, [this.x(lowX), this.y(mm)], [this.x(highX), this.y(mm)]);
      context.fillText(label(mm, step), this.x(lowX) - 6, this.y(mm));
    }
    this.travel(context, travel);
  }

  private travel(context: CanvasRenderingContext2D, travel: number[]): void {
    const [x, y] = this.axes.map((axis) => travel[axis] ?? 0);
    if (!x || !y) return;
    context.save();
    context.beginPath();
    context.rect(this.x(this.low[0]), this.y(this.high[1]), (this.high[0] - this.low[0]) * this.scale, (this.high[1] - this.low[1]) * this.scale);
    context.clip();
    context.setLineDash([5, 4]);
    context.strokeStyle = colour("bound");
    context.strokeRect(this.x(0), this.y(y), x * this.scale, y * this.scale);
    context.restore();
  }

  private x(mm: number): number {
    return this.left + (mm - this.low[0]) * this.scale;
  }

  private y(mm: number): number {
    return this.bottom - (mm - this.low[1]) * this.scale;
  }
}

function line(context: CanvasRenderingContext2D, from: [number, number], to: [number, number]): void {
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.stroke();
}
