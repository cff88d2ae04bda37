// The path in a plane: what was made already in full colours over what is ahead.

import { canvas } from "./elements";
import { colour, onChange, pen } from "./drawing";
import { AXIS_NAMES } from "./motion";
import { Plane } from "./plane";
import type { Picture, Shown } from "./path";
import { Breath, type Segments } from "./segments";

/** Lines that are drawn in one go. */
const IN_ONE_GO = 4_000;

export class Flat implements Picture {
  private readonly under = canvas("grid");
  private readonly all = canvas("path");
  private readonly done = canvas("done");
  private readonly over = canvas("tool");
  private axes: [number, number] = [0, 1];
  private plane: Plane | undefined;
  private shown: Shown | undefined;
  private time = 0;
  /** Lines that are drawn as done, from the first. */
  private made = 0;
  private drawing = 0;

  constructor() {
    onChange(this.all, () => void this.draw());
  }

  look(plane: string): void {
    this.axes = [AXIS_NAMES.indexOf(plane[0] as "X"), AXIS_NAMES.indexOf(plane[1] as "X")];
    void this.draw();
  }

  show(shown: Shown): void {
    this.shown = shown;
    void this.draw();
  }

  at(time: number): void {
    this.time = time;
    this.drawDone();
    this.drawTool();
  }

  hide(isHidden: boolean): void {
    for (const layer of [this.under, this.all, this.done, this.over]) layer.hidden = isHidden;
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

  /** Draws all lines, piece by piece, so that the page answers in between; the highest ranks last. */
  private async draw(): Promise<void> {
    const mine = ++this.drawing;
    const [drawn, grid] = [pen(this.all), pen(this.under)];
    this.plane = undefined;
    if (!drawn || !grid || !this.shown) return this.at(this.time);
    const { segments, tone, travel } = this.shown;
    this.plane = new Plane(this.axes, segments, drawn.width, drawn.height);
    this.plane.grid(grid.context, travel);
    pen(this.done);
    this.made = 0;
    this.at(this.time);
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
    context.beginPath();
    for (let index = from; index < to; index++) {
      if (segments.ranks[index] !== rank) continue;
      context.moveTo(...plane.at(segments.places, 6 * index));
      context.lineTo(...plane.at(segments.places, 6 * index + 3));
    }
    context.lineCap = "round";
    context.lineWidth = rank >= shown.tone.loud ? 6 : 2;
    context.strokeStyle = colour(shown.tone.colours[rank] ?? "ink");
    context.stroke();
  }

  /** Adds what was made since the last time; begins anew if time went back. */
  private drawDone(): void {
    const isWhole = !this.shown || this.time >= this.shown.motion.end;
    this.all.classList.toggle("ahead", !isWhole);
    this.done.classList.toggle("unused", isWhole);
    if (isWhole || !this.shown) return;
    const { segments, tone } = this.shown;
    const until = madeAt(segments, this.time);
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
    const context = pen(this.over)?.context;
    const { plane, shown } = this;
    if (!context || !plane || !shown || shown.motion.isHomingAt(this.time)) return;
    context.beginPath();
    context.arc(...plane.at(shown.motion.places(this.time)), 6, 0, 2 * Math.PI);
    context.fillStyle = colour("tool");
    context.fill();
    context.lineWidth = 2;
    context.strokeStyle = colour("card");
    context.stroke();
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
