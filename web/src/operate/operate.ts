// Operates a machine. Each panel knows the machine, and none knows which one it is.

import { Change } from "./change";
import { Console } from "./console";
import { Jog } from "./jog";
import { Machine } from "./machine";
import { offerOverrides } from "./overrides";
import { Position } from "./position";
import { Power } from "./power";
import { Probe } from "./probe";
import { Sending } from "./sending";
import { State } from "./state";
import { offerStop } from "./stop";
import { Tool } from "./tool";
import { Zero } from "./zero";

export class Operate {
  readonly machine = new Machine();
  private readonly power: Power;

  constructor(program: () => string, settings: () => string) {
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
    this.power.look();
  }
}
