// The path in a plane, coloured by speed, with the place of the tool on it.

import { canvas, part } from "./elements";
import { colour, label, onChange, pen, roundStep } from "./drawing";
import { AXIS_NAMES, Kind, type Motion } from "./motion";

/** Speeds have as many colours; slow places are drawn over fast ones. */
const CLASSES = 8;
const MARGIN = { left: 44, right: 12, top: 12, bottom: 30 };
/** Pieces of a stretch along which the speed changes. */
const PIECES_OF_BEND = 6;
/** A stretch that is shorter has one colour. */
const SHORT_PX = 6;
/** Nothing is drawn more finely. */
const FINE_PX = 0.5;

/** Lines by classes of speed. What lies on a line that is there already is left out, as is what is finer than a pixel. */
class Strokes {
  private readonly classes: number[][] = Array.from({ length: CLASSES }, () => []);
  private readonly seen = new Set<number>();

  add(index: number, from: [number, number], to: [number, number]): void {
    // Places of up to 4096 half pixels, four of them, and a class fit into the 53 bits of a number.
    const [left, low, right, high] = [...from, ...to].map((px) => Math.min(4095, Math.max(0, Math.round(px / FINE_PX))));
    if (left === undefined || low === undefined || right === undefined || high === undefined) return;
    const key = (((left * 4096 + low) * 4096 + right) * 4096 + high) * CLASSES + index;
    if (this.seen.has(key)) return;
    this.seen.add(key);
    this.classes[index]?.push(left * FINE_PX, low * FINE_PX, right * FINE_PX, high * FINE_PX);
  }

  /** Puts the lines of a class on a path. */
  lay(index: number, context: CanvasRenderingContext2D): void {
    const points = this.classes[index] ?? [];
    for (let at = 0; at < points.length; at += 4) {
      context.moveTo(points[at] ?? 0, points[at + 1] ?? 0);
      context.lineTo(points[at + 2] ?? 0, points[at + 3] ?? 0);
    }
  }
}

interface View {
  x: (mm: number) => number;
  y: (mm: number) => number;
}

export class PathPicture {
  private readonly under = canvas("path");
  private readonly over = canvas("tool");
  private motion: Motion | undefined;
  private travel: number[] = [];
  private view: View | undefined;
  private axes: [number, number] = [0, 1];
  private time = 0;

  constructor() {
    onChange(this.under, () => this.draw());
  }

  show(motion: Motion, travel: number[]): void {
    [this.motion, this.travel] = [motion, travel];
    this.draw();
  }

  look(plane: string): void {
    this.axes = [AXIS_NAMES.indexOf(plane[0] as "X"), AXIS_NAMES.indexOf(plane[1] as "X")];
    this.draw();
  }

  at(time: number): void {
    this.time = time;
    this.drawTool();
  }

  /** The picture as a file. */
  file(): Promise<Blob | null> {
    const whole = document.createElement("canvas");
    [whole.width, whole.height] = [this.under.width, this.under.height];
    const context = whole.getContext("2d");
    if (context) {
      context.fillStyle = colour("card");
      context.fillRect(0, 0, whole.width, whole.height);
      context.drawImage(this.under, 0, 0);
    }
    return new Promise((resolve) => whole.toBlob(resolve));
  }

  private draw(): void {
    const [drawn, motion] = [pen(this.under), this.motion];
    const bounds = motion && this.bounds(motion);
    part("path-key").hidden = !bounds;
    this.view = undefined;
    if (!drawn || !bounds) return this.drawTool();
    const { context, width, height } = drawn;
    const inner = { width: width - MARGIN.left - MARGIN.right, height: height - MARGIN.top - MARGIN.bottom };
    const [spanX, spanY] = [bounds.high[0] - bounds.low[0], bounds.high[1] - bounds.low[1]];
    const scale = Math.min(inner.width / spanX, inner.height / spanY);
    const [left, bottom] = [MARGIN.left + (inner.width - spanX * scale) / 2, height - MARGIN.bottom - (inner.height - spanY * scale) / 2];
    const view = {
      x: (mm: number) => left + (mm - bounds.low[0]) * scale,
      y: (mm: number) => bottom - (mm - bounds.low[1]) * scale,
    };
    this.view = view;
    this.grid(context, view, bounds, 70 / scale);
    this.lines(context, view, motion);
    part("path-top").textContent = `${label(motion.topSpeed, 0.1)} mm/s`;
    this.drawTool();
  }

  /** What the picture shows: the program's places, with some room around. */
  private bounds(motion: Motion): { low: [number, number]; high: [number, number] } | undefined {
    const [low, high]: [number, number][] = [[Infinity, Infinity], [-Infinity, -Infinity]];
    if (!low || !high) return undefined;
    for (let row = 0; row < motion.length; row++) {
      if (motion.isHoming(row)) continue;
      for (const after of [0, motion.to(row) - motion.from(row)]) {
        this.axes.forEach((axis, index) => {
          const place = motion.place(row, axis, after);
          low[index] = Math.min(low[index] ?? 0, place);
          high[index] = Math.max(high[index] ?? 0, place);
        });
      }
    }
    if (!Number.isFinite(low[0])) return undefined;
    const room = Math.max(high[0] - low[0], high[1] - low[1], 1) * 0.06;
    return { low: [low[0] - room, low[1] - room], high: [high[0] + room, high[1] + room] };
  }

  private grid(context: CanvasRenderingContext2D, view: View, bounds: { low: number[]; high: number[] }, least: number): void {
    const step = roundStep(least * 10, 10);
    const [lowX = 0, lowY = 0] = bounds.low;
    const [highX = 0, highY = 0] = bounds.high;
    context.lineWidth = 1;
    context.strokeStyle = colour("grid");
    context.fillStyle = colour("muted");
    context.textAlign = "center";
    context.textBaseline = "top";
    for (let mm = Math.ceil(lowX / step) * step; mm <= highX; mm += step) {
      line(context, [view.x(mm), view.y(lowY)], [view.x(mm), view.y(highY)]);
      context.fillText(label(mm, step), view.x(mm), view.y(lowY) + 5);
    }
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (let mm = Math.ceil(lowY / step) * step; mm <= highY; mm += step) {
      line(context, [view.x(lowX), view.y(mm)], [view.x(highX), view.y(mm)]);
      context.fillText(label(mm, step), view.x(lowX) - 6, view.y(mm));
    }
    const [travelX, travelY] = this.axes.map((axis) => this.travel[axis] ?? 0);
    if (!travelX || !travelY) return;
    context.setLineDash([5, 4]);
    context.strokeStyle = colour("bound");
    context.save();
    context.beginPath();
    context.rect(view.x(lowX), view.y(highY), view.x(highX) - view.x(lowX), view.y(lowY) - view.y(highY));
    context.clip();
    context.strokeRect(view.x(0), view.y(travelY), view.x(travelX) - view.x(0), view.y(0) - view.y(travelY));
    context.restore();
    context.setLineDash([]);
  }

  private lines(context: CanvasRenderingContext2D, view: View, motion: Motion): void {
    const strokes = new Strokes();
    const [right, up] = this.axes;
    const point = (row: number, after: number): [number, number] => [view.x(motion.place(row, right, after)), view.y(motion.place(row, up, after))];
    for (let row = 0; row < motion.length; row++) {
      if (motion.isHoming(row)) continue;
      const span = motion.to(row) - motion.from(row);
      let from = point(row, 0);
      const end = point(row, span);
      const long = Math.abs(end[0] - from[0]) + Math.abs(end[1] - from[1]);
      const isStraight = motion.kind(row) === Kind.Cruise || long < SHORT_PX;
      const pieces = isStraight ? 1 : PIECES_OF_BEND;
      for (let piece = 1; piece <= pieces; piece++) {
        const to = piece === pieces ? end : point(row, (span * piece) / pieces);
        const speed = motion.speedIn(row, (span * (piece - 0.5)) / pieces);
        strokes.add(Math.min(CLASSES - 1, Math.floor((CLASSES * speed) / motion.topSpeed)), from, to);
        from = to;
      }
    }
    context.lineWidth = 2;
    context.lineCap = "round";
    for (let index = CLASSES - 1; index >= 0; index--) {
      context.strokeStyle = colour(`speed-${index + 1}`);
      context.beginPath();
      strokes.lay(index, context);
      context.stroke();
    }
  }

  private drawTool(): void {
    const context = pen(this.over)?.context;
    if (!context || !this.view || !this.motion?.length || this.motion.isHomingAt(this.time)) return;
    const places = this.motion.places(this.time);
    const [x, y] = this.axes.map((axis) => places[axis] ?? 0);
    context.beginPath();
    context.arc(this.view.x(x ?? 0), this.view.y(y ?? 0), 6, 0, 2 * Math.PI);
    context.fillStyle = colour("tool");
    context.fill();
    context.lineWidth = 2;
    context.strokeStyle = colour("card");
    context.stroke();
  }
}

function line(context: CanvasRenderingContext2D, from: [number, number], to: [number, number]): void {
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.stroke();
}
