// The path: in a plane or in space, coloured by one of several things.

import { made, part, select } from "./elements";
import { Flat } from "./flat";
import type { Motion } from "./motion";
import { type Segments, segments } from "./segments";
import type { Space } from "./space";
import { type Tone, TONES } from "./tone";

/** What pictures show. */
export interface Shown {
  motion: Motion;
  segments: Segments;
  tone: Tone;
  travel: number[];
}

/** A way to look at the path. */
export interface Picture {
  show(shown: Shown): void;
  at(time: number): void;
  hide(isHidden: boolean): void;
  file(): Promise<Blob | null>;
}

export class PathPicture {
  private readonly flat = new Flat();
  private space: Space | undefined;
  private picture: Picture = this.flat;
  private motion: Motion | undefined;
  private travel: number[] = [];
  private shown: Shown | undefined;
  private time = 0;
  private making = 0;

  constructor() {
    select("plane").onchange = () => void this.look(select("plane").value);
    select("tone").onchange = () => this.motion && void this.show(this.motion, this.travel);
  }

  /** Shows a run. It is done when all is drawn, or when another came. */
  async show(motion: Motion, travel: number[]): Promise<void> {
    const mine = ++this.making;
    [this.motion, this.travel] = [motion, travel];
    const tone = TONES[select("tone").value] ?? TONES["speed"];
    const lines = tone && (await segments(motion, tone, () => mine === this.making));
    if (mine !== this.making) return;
    part("path-key").hidden = !lines;
    this.shown = lines && { motion, segments: lines, tone, travel };
    if (!this.shown) return;
    this.tellKey(this.shown);
    this.picture.show(this.shown);
  }

  at(time: number): void {
    this.time = time;
    this.picture.at(time);
  }

  file(): Promise<Blob | null> {
    return this.picture.file();
  }

  private async look(place: string): Promise<void> {
    this.picture = place === "3D" ? await this.inSpace() : this.flat;
    for (const picture of [this.flat, this.space]) picture?.hide(picture !== this.picture);
    part("space-help").hidden = this.picture === this.flat;
    if (place !== "3D") this.flat.look(place);
    if (this.shown) {
      this.tellKey(this.shown);
      this.picture.show(this.shown);
    }
    this.picture.at(this.time);
  }

  /** The picture in space; that in the plane where a browser has none. */
  private async inSpace(): Promise<Picture> {
    try {
      const { Space } = await import("./space");
      return (this.space ??= new Space());
    } catch (error) {
      select("plane").value = "XY";
      part("status").textContent = `This browser draws nothing in space: ${error}`;
      return this.flat;
    }
  }

  private tellKey({ motion, tone }: Shown): void {
    const { name, low, high, loud } = tone.key(motion);
    const scale = made("span", "", "scale");
    scale.ariaHidden = "true";
    scale.append(...tone.scale.map(swatch));
    const above = loud ? [", ", swatch("over"), ` ${loud}`] : [];
    part("path-key").replaceChildren(`${name}: ${low} `, scale, ` ${high}`, ...above, this.picture === this.flat ? ". Dashed: the travel." : ".");
  }
}

function swatch(colour: string): HTMLElement {
  const one = made("i", "");
  one.style.background = `var(--${colour})`;
  return one;
}
