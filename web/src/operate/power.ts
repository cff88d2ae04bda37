// The simulated machine: its power, its time, and its emergency stop.

import { button, input, select } from "../elements";
import type { Machine } from "./machine";
import { SimulatedPort } from "./port";

/** Where the plate for the probe lies, from the switch of Z. */
const PLATE_MM = 10;

export class Power {
  private port: SimulatedPort | undefined;

  constructor(
    private readonly machine: Machine,
    private readonly settings: () => string,
  ) {
    button("power").onclick = () => this.on();
    const stop = input("stop-button");
    stop.onchange = () => this.port?.setStopButton(stop.checked);
    const plate = input("plate");
    plate.onchange = () => this.port?.setPlate(plate.checked ? PLATE_MM : undefined);
    select("live-rate").onchange = () => this.setSpeed();
  }

  /** Switches it on when its page is first looked at. */
  look(): void {
    if (!this.machine.isAttached) this.on();
  }

  /** A machine at power-up, with the settings of the page. */
  private on(): void {
    input("stop-button").checked = input("plate").checked = false;
    this.machine.log("power-up", "note");
    this.port = this.machine.attach((listener) => new SimulatedPort(this.settings(), listener));
    this.setSpeed();
  }

  private setSpeed(): void {
    this.port?.setSpeed(Number(select("live-rate").value));
  }
}
