// The path in a plane: what was made already in full colours over what is ahead. The wheel goes nearer, dragging shifts.

import { canvas, part, select } from "../elements";
import { colour, onChange, pen } from "../drawing";
import { AXIS_NAMES } from "../axes";
import { Handling } from "./handling";
import type { Moment, Shown, View } from "./picture";
import { fitted, Plane, type Window } from "./plane";
import { Breath, type Segments } from "./segments";

/** Lines that are drawn in one go. */
const IN_ONE_GO = 4_000;

export class Flat implements View {
  private readonly under = canvas("grid");
  private readonly all = canvas("path");
  private readonly done = canvas("done");
  private readonly tool = part("tool");
  private axes: [number, number] = [0, 1];
  /** What a person looks at; undefined for all there is. */
  private window: Window | undefined;
  private plane: Plane | undefined;
  private shown: Shown | undefined;
  private moment: Moment = { made: Infinity, tool: undefined };
  /** Lines that are drawn as made, from the first. */
  private made = 0;
  private drawing = 0;

  constructor() {
    onChange(this.all, () => void this.draw());
    new Handling(part("stack"), {
      plane: () => (this.all.hidden ? undefined : this.plane),
      look: (window) => {
        this.window = window;
        void this.draw();
      },
    });
    select("fit").addEventListener("change", () => this.fit());
  }

  look(plane: string): void {
    this.axes = [AXIS_NAMES.indexOf(plane[0] as "X"), AXIS_NAMES.indexOf(plane[1] as "X")];
    this.fit();
  }

  show(shown: Shown): void {
    // Another path is seen as a whole first.
    if (shown.motion !== this.shown?.motion) this.window = undefined;
    this.shown = shown;
    void this.draw();
  }

  at(moment: Moment): void {
    this.moment = moment;
    this.drawMade();
    this.drawTool();
  }

  hide(isHidden: boolean): void {
    for (const layer of [this.under, this.all, this.done]) layer.hidden = isHidden;
    this.drawTool();
  }

  file(): Promise<Blob | null> {
    const whole = document.createElement("canvas");
    [whole.width, whole.height] = [this.all.width, this.all.height];
    const context = whole.getContext("2d");
    if (context) {
      context.fillStyle = colour("card");
      context.fillRect(0, 0, whole.width, whole.height);
      for (const layer of [this.under, this.all]) context.drawImage(layer, 0, 0);
    }
    return new Promise((resolve) => whole.toBlob(resolve));
  }

  private fit(): void {
    this.window = undefined;
    void this.draw();
  }

  /** All there is: the path, or as far as the machine can go if that is wanted or there is no path. */
  private whole({ segments: { count, low, high }, travel, workZero }: Shown): [number[], number[]] {
    const zeros = travel.map(() => 0);
    if (travel.length && (!count || select("fit").value === "travel")) {
      return [zeros.map((zero, axis) => (count ? Math.min(zero, low[axis] ?? 0) : zero)), travel.map((mm, axis) => (count ? Math.max(mm, high[axis] ?? 0) : mm))];
    }
    const zero = workZero ?? (count ? low : [0, 0, 0]);
    // A zero that is far from the path would leave no room for it.
    const isNear = zero.every((mm, axis) => Math.abs(mm - (low[axis] ?? 0)) <= Math.max(...high.map((most, of) => most - (low[of] ?? 0)), 1));
    return isNear ? [low.map((mm, axis) => Math.min(mm, zero[axis] ?? mm)), high.map((mm, axis) => Math.max(mm, zero[axis] ?? mm))] : [low, high];
  }

  /** Draws all lines, piece by piece, so that the page answers in between; the highest ranks last. */
  private async draw(): Promise<void> {
    const mine = ++this.drawing;
    const [drawn, grid] = [pen(this.all), pen(this.under)];
    this.plane = undefined;
    if (!drawn || !grid || !this.shown) return this.at(this.moment);
    const { segments, tone, travel, workZero } = this.shown;
    const { width, height } = drawn;
    const plane = new Plane(this.axes, this.window ?? fitted(this.axes, ...this.whole(this.shown), width, height), width, height);
    this.plane = plane;
    plane.grid(grid.context);
    plane.travel(grid.context, travel);
    if (workZero) plane.zero(grid.context, workZero);
    pen(this.done);
    this.made = 0;
    this.at(this.moment);
    const breath = new Breath();
    for (const rank of tone.colours.keys()) {
      for (let from = 0; from < segments.count; from += IN_ONE_GO) {
        if (breath.isDue) {
          await breath.take();
          if (mine !== this.drawing) return;
        }
        this.stroke(drawn.context, segments, rank, from, Math.min(segments.count, from + IN_ONE_GO));
      }
    }
    this.all.dataset["lines"] = String(segments.count);
  }

  private stroke(context: CanvasRenderingContext2D, segments: Segments, rank: number, from: number, to: number): void {
    const { plane, shown } = this;
    if (!plane || !shown) return;
    plane.clipped(context, () => {
      context.beginPath();
      for (let index = from; index < to; index++) {
        if (segments.ranks[index] === rank) plane.line(context, segments.places, 6 * index);
      }
      context.lineCap = "round";
      context.lineWidth = rank >= shown.tone.loud ? 6 : 2.25;
      context.strokeStyle = colour(shown.tone.colours[rank] ?? "ink");
      context.stroke();
    });
  }

  /** Adds what was made since the last time; begins anew if time went back. */
  private drawMade(): void {
    const isWhole = !this.shown || this.moment.made >= this.shown.motion.end;
    this.all.classList.toggle("ahead", !isWhole);
    this.done.classList.toggle("unused", isWhole);
    if (isWhole || !this.shown) return;
    const { segments, tone } = this.shown;
    const until = madeAt(segments, this.moment.made);
    if (until < this.made) {
      pen(this.done);
      this.made = 0;
    }
    const context = this.done.getContext("2d");
    if (context && until > this.made) {
      for (const rank of tone.colours.keys()) this.stroke(context, segments, rank, this.made, until);
    }
    this.made = until;
  }

  private drawTool(): void {
    const { plane } = this;
    const { tool } = this.moment;
    this.tool.hidden = this.all.hidden || !plane || !tool;
    if (!plane || !tool) return;
    const [x, y] = plane.at(tool);
    this.tool.style.translate = `${x}px ${y}px`;
    // Read by the tests, and by nobody else.
    this.tool.dataset["at"] = plane.placeAt(x, y).map((mm) => mm.toFixed(2)).join(" ");
  }
}

/** How many of the lines are made at a time. */
export function madeAt({ ends, count }: Segments, time: number): number {
  let [low, high] = [0, count];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((ends[middle] ?? Infinity) <= time) low = middle + 1;
    else high = middle;
  }
  return low;
}
