// The picture: a path in a plane or in space, coloured by one of several things, with the tool on it. The simulated run and the
// machine that is operated show themselves in it by turns.

import { made, part, select } from "../elements";
import type { Motion } from "../motion";
import { Flat } from "./flat";
import { type Segments, segments } from "./segments";
import type { Space } from "./space";
import { type Tone, TONES } from "./tone";

/** What there is to see. All places are the machine's, in mm. */
export interface Scene {
  motion: Motion;
  /** How far each axis can go from the machine's zero; empty if that is not known. */
  travel: number[];
  /** The zero of the work, if there is one beside the machine's. */
  workZero?: number[];
}

/** The same at a time. */
export interface Moment {
  /** What was made until this time of the motion stands out, s. */
  made: number;
  /** Where the tool is; undefined if nobody knows. */
  tool: number[] | undefined;
}

/** A scene with its lines and their colours. */
export interface Shown extends Scene {
  segments: Segments;
  tone: Tone;
}

/** A way to look at a scene. */
export interface View {
  show(shown: Shown): void;
  at(moment: Moment): void;
  hide(isHidden: boolean): void;
  file(): Promise<Blob | null>;
}

export class Picture {
  private readonly flat = new Flat();
  private space: Space | undefined;
  private view: View = this.flat;
  private scene: Scene | undefined;
  private shown: Shown | undefined;
  private moment: Moment = { made: Infinity, tool: undefined };
  private making = 0;

  constructor() {
    select("plane").onchange = () => void this.look(select("plane").value);
    select("tone").onchange = () => this.scene && void this.show(this.scene);
  }

  /** Shows a scene. It is done when all is drawn, or when another came. */
  async show(scene: Scene): Promise<void> {
    const mine = ++this.making;
    this.scene = scene;
    const tone = TONES[select("tone").value] ?? TONES["speed"];
    const lines = tone && (await segments(scene.motion, tone, () => mine === this.making));
    if (!tone || !lines || mine !== this.making) return;
    this.shown = { ...scene, segments: lines, tone };
    this.tellKey(this.shown);
    this.view.show(this.shown);
  }

  at(moment: Moment): void {
    this.moment = moment;
    this.view.at(moment);
  }

  file(): Promise<Blob | null> {
    return this.view.file();
  }

  private async look(place: string): Promise<void> {
    this.view = place === "3D" ? await this.inSpace() : this.flat;
    for (const view of [this.flat, this.space]) view?.hide(view !== this.view);
    part("space-help").hidden = this.view === this.flat;
    if (place !== "3D") this.flat.look(place);
    if (this.shown) {
      this.tellKey(this.shown);
      this.view.show(this.shown);
    }
    this.view.at(this.moment);
  }

  /** The picture in space; that in the plane where a browser has none. */
  private async inSpace(): Promise<View> {
    try {
      const { Space } = await import("./space");
      return (this.space ??= new Space());
    } catch (error) {
      select("plane").value = "XY";
      part("status").textContent = `This browser draws nothing in space: ${error}`;
      return this.flat;
    }
  }

  private tellKey({ motion, tone, travel, workZero, segments: { count } }: Shown): void {
    const { name, low, high, loud } = tone.key(motion);
    const scale = made("span", "", "scale");
    scale.ariaHidden = "true";
    scale.append(...tone.scale.map(swatch));
    const above = loud ? [", ", swatch("over"), ` ${loud}`] : [];
    const colours = count ? [`${name}: ${low} `, scale, ` ${high}`, ...above, ". "] : [];
    const around = [travel.length && (this.view === this.flat ? "Dashed: the travel." : "The box: the travel."), workZero && "Cross: the zero of the work."].filter(Boolean).join(" ");
    part("path-key").replaceChildren(...colours, around);
  }
}

function swatch(colour: string): HTMLElement {
  const one = made("i", "");
  one.style.background = `var(--${colour})`;
  return one;
}
