// Operates a machine. Each panel knows the machine, and none knows which one it is.

import { Console } from "./console";
import { Jog } from "./jog";
import { Machine } from "./machine";
import { Power } from "./power";
import { Sending } from "./sending";
import { State } from "./state";

export class Operate {
  private readonly power: Power;

  constructor(program: () => string, settings: () => string) {
    const machine = new Machine();
    new Console(machine);
    new Jog(machine);
    new Sending(machine, program);
    this.power = new Power(machine, new State(machine), settings);
  }

  /** Switches a machine on when it is first looked at. */
  look(): void {
    this.power.look();
  }
}
