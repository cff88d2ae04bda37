// Speed, acceleration and jerk of each axis over time, with the equal intervals shaded.

import { button, canvas } from "./elements";
import { colour, label, onChange, pen, roundStep } from "./drawing";
import { AXES, AXIS_NAMES, type AxisMotion, Kind, type Motion } from "./motion";

const LEFT = 62;
const RIGHT = 10;
const BOTTOM = 34;
/** Room above each panel, for its name. */
const GAP = 26;
/** Points of a stretch that is not narrow. */
const POINTS = 12;
const SHADES: Partial<Record<Kind, string>> = {
  [Kind.Accelerate]: "accel",
  [Kind.Cruise]: "cruise",
  [Kind.Decelerate]: "decel",
};
const PANELS: { name: string; of: (motion: AxisMotion) => number }[] = [
  { name: "speed, mm/s", of: (motion) => motion.speed },
  { name: "acceleration, mm/s²", of: (motion) => motion.accel },
  { name: "jerk, mm/s³", of: (motion) => motion.jerk },
];

interface Point {
  time: number;
  value: number;
}

export class Curves {
  private readonly canvas = canvas("curves");
  private readonly over = canvas("cursor");
  private motion: Motion | undefined;
  private span: [number, number] = [0, 1];
  private cursor = 0;

  constructor(private readonly onPick: (time: number) => void) {
    onChange(this.canvas, () => this.draw());
    button("zoom-in").onclick = () => this.zoom(0.5);
    button("zoom-out").onclick = () => this.zoom(2);
    button("zoom-all").onclick = () => this.all();
    button("earlier").onclick = () => this.shift(-0.25);
    button("later").onclick = () => this.shift(0.25);
    this.canvas.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.shiftKey) return;
      event.preventDefault();
      this.zoom(event.deltaY > 0 ? 1.25 : 0.8, this.timeAt(event.offsetX));
    }, { passive: false });
    this.canvas.addEventListener("pointerdown", (event) => this.onPick(this.timeAt(event.offsetX)));
    this.canvas.addEventListener("dblclick", (event) => this.zoom(0.25, this.timeAt(event.offsetX)));
  }

  show(motion: Motion): void {
    this.motion = motion;
    this.all();
  }

  at(time: number): void {
    this.cursor = time;
    this.drawCursor();
  }

  /** The first stretch of time that the program moves in, without homing, to the end. */
  private all(): void {
    const motion = this.motion;
    let row = 0;
    while (motion && row < motion.length && motion.isHoming(row)) row++;
    const hasMoves = motion !== undefined && row < motion.length;
    this.span = hasMoves ? [motion.from(row), motion.end] : [0, Math.max(1, motion?.end ?? 1)];
    this.draw();
  }

  private zoom(factor: number, middle = this.inSpan(this.cursor) ? this.cursor : (this.span[0] + this.span[1]) / 2): void {
    const end = this.motion?.end ?? 1;
    const width = Math.min(Math.max((this.span[1] - this.span[0]) * factor, 1e-4), end);
    const share = (middle - this.span[0]) / (this.span[1] - this.span[0]);
    const from = Math.min(Math.max(0, middle - share * width), Math.max(0, end - width));
    this.span = [from, from + width];
    this.draw();
  }

  private shift(share: number): void {
    const by = share * (this.span[1] - this.span[0]);
    this.span = [this.span[0] + by, this.span[1] + by];
    this.draw();
  }

  private inSpan(time: number): boolean {
    return time >= this.span[0] && time <= this.span[1];
  }

  private timeAt(x: number): number {
    const share = (x - LEFT) / (this.canvas.clientWidth - LEFT - RIGHT);
    return this.span[0] + Math.min(Math.max(share, 0), 1) * (this.span[1] - this.span[0]);
  }

  private draw(): void {
    const [drawn, motion] = [pen(this.canvas), this.motion];
    if (!drawn || !motion?.length) return;
    const { context, width, height } = drawn;
    const x = (time: number): number => LEFT + ((time - this.span[0]) / (this.span[1] - this.span[0])) * (width - LEFT - RIGHT);
    const tall = (height - BOTTOM - GAP * PANELS.length) / PANELS.length;
    const first = Math.max(0, motion.rowAt(this.span[0]));
    const last = Math.max(first, motion.rowAt(this.span[1]));
    PANELS.forEach((panel, index) => {
      const top = GAP + index * (tall + GAP);
      this.shade(context, motion, [first, last], x, top, tall);
      this.panel(context, motion, [first, last], x, { ...panel, top, tall, width });
    });
    this.timeAxis(context, x, height);
    this.drawCursor();
  }

  private drawCursor(): void {
    const drawn = pen(this.over);
    if (!drawn || !this.inSpan(this.cursor)) return;
    const { context, width, height } = drawn;
    const x = LEFT + ((this.cursor - this.span[0]) / (this.span[1] - this.span[0])) * (width - LEFT - RIGHT);
    context.strokeStyle = colour("tool");
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(x, GAP);
    context.lineTo(x, height - BOTTOM);
    context.stroke();
  }

  private shade(context: CanvasRenderingContext2D, motion: Motion, [first, last]: [number, number], x: (time: number) => number, top: number, tall: number): void {
    const [from, to] = [x(this.span[0]), x(this.span[1])];
    let next = first;
    for (let row = first; row <= last; row = next) {
      // Stretches of one interval are shaded together, so that no seams show.
      next = row + 1;
      while (next <= last && motion.kind(next) === motion.kind(row) && motion.from(next) <= motion.to(next - 1) + 1e-9) next++;
      const shade = SHADES[motion.kind(row)];
      const [left, right] = [Math.max(from, x(motion.from(row))), Math.min(to, x(motion.to(next - 1)))];
      if (!shade || motion.isHoming(row) || right - left < 0.5) continue;
      context.fillStyle = colour(shade);
      context.fillRect(left, top, right - left, tall);
    }
  }

  private panel(
    context: CanvasRenderingContext2D,
    motion: Motion,
    [first, last]: [number, number],
    x: (time: number) => number,
    { name, of, top, tall, width }: { name: string; of: (motion: AxisMotion) => number; top: number; tall: number; width: number },
  ): void {
    const curves = Array.from({ length: AXES }, (_, axis) => [...this.points(motion, [first, last], axis, of)]);
    const values = curves.flatMap((points) => points.map((point) => point.value)).filter(Number.isFinite);
    let [low, high] = values.reduce(([least, most], value) => [Math.min(least, value), Math.max(most, value)], [0, 0]);
    if (high - low < 1e-6) [low, high] = [low - 1, high + 1];
    const room = (high - low) * 0.08;
    [low, high] = [low - room, high + room];
    const y = (value: number): number => top + ((high - value) / (high - low)) * tall;
    const step = roundStep(high - low, Math.max(2, Math.floor(tall / 34)));
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.lineWidth = 1;
    for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
      context.strokeStyle = colour(Math.abs(value) < step / 2 ? "bound" : "grid");
      context.beginPath();
      context.moveTo(LEFT, y(value));
      context.lineTo(width - RIGHT, y(value));
      context.stroke();
      context.fillStyle = colour("muted");
      context.fillText(label(value, step), LEFT - 6, y(value));
    }
    context.save();
    context.beginPath();
    context.rect(LEFT, top - 2, width - LEFT - RIGHT, tall + 4);
    context.clip();
    context.lineWidth = 1.75;
    curves.forEach((points, axis) => {
      context.strokeStyle = colour((AXIS_NAMES[axis] ?? "X").toLowerCase());
      context.beginPath();
      points.forEach((point, index) => context[index ? "lineTo" : "moveTo"](x(point.time), y(point.value)));
      context.stroke();
    });
    context.restore();
    context.textAlign = "left";
    context.textBaseline = "bottom";
    context.fillStyle = colour("ink");
    context.fillText(name, LEFT, top - 5);
  }

  /** The points of a curve. Of stretches narrower than a pixel only the lowest and the highest values of each pixel. */
  private *points(motion: Motion, [first, last]: [number, number], axis: number, of: (motion: AxisMotion) => number): Generator<Point> {
    const pixel = (this.span[1] - this.span[0]) / Math.max(1, this.canvas.clientWidth - LEFT - RIGHT);
    let ended = this.span[0];
    let crowd: { from: number; low: number; high: number } | undefined;
    for (let row = first; row <= last; row++) {
      const [from, to] = [motion.from(row), motion.to(row)];
      if (motion.isHoming(row)) continue;
      if (from - ended > 1e-6) {
        yield { time: ended, value: 0 };
        yield { time: from, value: 0 };
      }
      ended = to;
      if (to - from < pixel) {
        const value = of(motion.axis(row, axis, (to - from) / 2));
        crowd ??= { from, low: value, high: value };
        [crowd.low, crowd.high] = [Math.min(crowd.low, value), Math.max(crowd.high, value)];
        if (to - crowd.from < pixel && row < last) continue;
      }
      if (crowd) {
        yield { time: crowd.from, value: crowd.low };
        yield { time: crowd.from, value: crowd.high };
        crowd = undefined;
      }
      if (to - from >= pixel) {
        const [begin, end] = [Math.max(0, this.span[0] - from), Math.min(to, this.span[1]) - from];
        for (let point = 0; point <= POINTS && end > begin; point++) {
          const after = begin + ((end - begin) * point) / POINTS;
          yield { time: from + after, value: of(motion.axis(row, axis, after)) };
        }
      }
    }
    if (ended < this.span[1]) {
      yield { time: ended, value: 0 };
      yield { time: this.span[1], value: 0 };
    }
  }

  private timeAxis(context: CanvasRenderingContext2D, x: (time: number) => number, height: number): void {
    const step = roundStep(this.span[1] - this.span[0], Math.max(2, Math.floor(this.canvas.clientWidth / 60)));
    context.fillStyle = colour("muted");
    context.textAlign = "center";
    context.textBaseline = "top";
    for (let time = Math.ceil(this.span[0] / step) * step; time <= this.span[1]; time += step) {
      context.fillText(label(time, step), x(time), height - BOTTOM + 4);
    }
    context.textAlign = "right";
    context.fillText("time, s", this.canvas.clientWidth - RIGHT, height - 14);
  }
}
