// Operates a machine. Each panel knows the machine, and none knows which one it is.

import { part } from "../elements";
import { Change } from "./change";
import { Console } from "./console";
import { Jog } from "./jog";
import { Machine } from "./machine";
import { offerOverrides } from "./overrides";
import { Position } from "./position";
import { Power } from "./power";
import { Probe } from "./probe";
import { linesOf } from "./program";
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

  constructor(
    private readonly program: () => NamedProgram,
    settings: () => string,
  ) {
    const { machine } = this;
    new Console(machine);
    new State(machine);
    new Position(machine);
    new Jog(machine);
    new Zero(machine);
    new Probe(machine);
    new Tool(machine);
    new Sending(machine, program, new Change(machine));
    offerOverrides(machine);
    offerStop(machine);
    this.power = new Power(machine, settings);
  }

  /** Switches a machine on when it is first looked at. */
  look(): void {
    const { name, text } = this.program();
    part("sending-what").textContent = `${name}: ${linesOf(text).length} lines that say something, as on the first tab.`;
    this.power.look();
  }
}
