// Operates a machine. Each panel knows the machine, and none knows which one it is.

import type { Picture } from "../picture/picture";
import { keepAwake } from "./awake";
import { Change } from "./change";
import { Console } from "./console";
import { Fits } from "./fits";
import { FromLine } from "./from-line";
import { Gamepads } from "./gamepad";
import { Jog } from "./jog";
import { LivePicture } from "./live";
import { Machine } from "./machine";
import { Macros } from "./macros";
import { offerOverrides } from "./overrides";
import { Position } from "./position";
import { Power } from "./power";
import { Probe } from "./probe";
import { Sending } from "./sending";
import { State } from "./state";
import { offerStop } from "./stop";
import { Tool } from "./tool";
import { Zero } from "./zero";

/** The program of the page. */
export interface NamedProgram {
  name: string;
  text: string;
}

export class Operate {
  readonly machine = new Machine();
  private readonly power: Power;
  private readonly live: LivePicture;
  private readonly fits: Fits;
  private readonly fromLine: FromLine;
  private isLooked = false;

  constructor(picture: Picture, program: () => NamedProgram, settings: () => string) {
    const { machine } = this;
    this.fromLine = new FromLine(machine, program, () => this.programChanged());
    const sent = (): NamedProgram => this.fromLine.program;
    new Console(machine);
    new State(machine);
    new Position(machine);
    new Gamepads(machine, new Jog(machine));
    new Zero(machine);
    new Probe(machine);
    new Tool(machine);
    new Macros(machine);
    this.live = new LivePicture(machine, picture, () => sent().text);
    this.fits = new Fits(machine, this.live, this.fromLine);
    new Sending(machine, sent, new Change(machine), this.live, this.fits);
    offerOverrides(machine);
    offerStop(machine);
    keepAwake(machine);
    this.power = new Power(machine, settings);
  }

  /** Shows the machine in the picture, or no more. A machine is switched on when it is first looked at. */
  look(isLooked: boolean): void {
    this.isLooked = isLooked;
    this.live.look(isLooked);
    if (!isLooked) return;
    this.fits.show();
    this.power.look();
  }

  /** The page has another program. */
  programChanged(): void {
    if (!this.isLooked) return;
    this.fromLine.refresh();
    this.fits.show();
    this.live.replan();
  }

  /** A page that has another use for the machine, as that of the settings, needs it to be on. */
  attach(): void {
    this.power.look();
  }
}
