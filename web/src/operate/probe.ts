// Probing downwards, and the zero of Z from it.

import { button, input, part } from "../elements";
import { MM_PER_INCH } from "./dialect";
import type { Machine } from "./machine";
import { readModes, type Modes } from "./modes";

const Z = 2;

export class Probe {
  /** Where the last contact was, in the machine's coordinates and the unit of its reports. */
  private contact: number[] | undefined;

  constructor(private readonly machine: Machine) {
    button("probe").onclick = () => this.start();
    button("probe-zero").onclick = () => this.setZero();
    machine.watch({
      began: () => this.forget(),
      said: (message) => this.hear(message),
      reported: () => (button("probe-zero").disabled = !this.contact || machine.state !== "Idle"),
    });
  }

  private say(words: string): void {
    part("probe-result").textContent = words;
  }

  private forget(): void {
    this.contact = undefined;
    this.say("");
  }

  private start(): void {
    const [distanceMm, feedMmPerMin] = [input("probe-distance"), input("probe-feed")].map((place) => Number(place.value)) as [number, number];
    const why = this.refusal(distanceMm, feedMmPerMin);
    if (why) return this.say(why);
    this.forget();
    readModes(this.machine, (modes) => {
      if (modes.isInverseTime) return this.say("Feeds are inverse times now (G93): send G94 first.");
      this.machine.command(this.line(modes, distanceMm, feedMmPerMin), (answer) => answer !== "ok" && this.say("The machine refused: see the console."));
    });
  }

  private refusal(distanceMm: number, feedMmPerMin: number): string {
    if (this.machine.state !== "Idle") return `The machine is in ${this.machine.state}: it probes when it is Idle.`;
    if (this.machine.report.pins.includes("P")) return "The probe touches already: lift the tool, or see $6.";
    if (!(distanceMm > 0)) return "The distance must be above 0 mm.";
    if (!(feedMmPerMin > 0)) return "The feed must be above 0 mm/min.";
    return "";
  }

  /** In the modes as they are, so that they are the same after it. */
  private line({ isInches, isRelative }: Modes, distanceMm: number, feedMmPerMin: number): string {
    const words = (mm: number): string => (isInches ? (mm / MM_PER_INCH).toFixed(4) : mm.toFixed(3));
    const fromMm = isRelative ? 0 : this.toMm(this.machine.report.workPosition[Z] ?? 0);
    return `G38.2 Z${words(fromMm - distanceMm)} F${words(feedMmPerMin)}`;
  }

  private toMm(reported: number): number {
    return this.machine.isInches ? reported * MM_PER_INCH : reported;
  }

  private hear(message: string): void {
    const found = /^\[PRB:([^:]*):([01])\]$/.exec(message);
    if (!found) return;
    const place = (found[1] ?? "").split(",").map(Number);
    this.contact = found[2] === "1" ? place : undefined;
    const unit = this.machine.isInches ? "in" : "mm";
    this.say(this.contact ? `Contact at Z ${place[Z]} ${unit} of the machine.` : "No contact within the distance.");
  }

  /** The contact was on top of a plate. After it the machine has gone on a little, and counts from there. */
  private setZero(): void {
    const thicknessMm = Number(input("probe-thickness").value);
    const { contact } = this;
    if (!contact || !(thicknessMm >= 0)) return this.say("The plate's thickness must be 0 mm or more.");
    const pastMm = this.toMm((this.machine.report.machinePosition[Z] ?? 0) - (contact[Z] ?? 0));
    readModes(this.machine, ({ isInches }) => {
      const z = pastMm + thicknessMm;
      this.machine.command(`G10 L20 P0 Z${isInches ? (z / MM_PER_INCH).toFixed(5) : z.toFixed(3)}`, (answer) => {
        if (answer === "ok") this.say(`Z is 0 at ${thicknessMm} mm below the contact.`);
      });
    });
  }
}
