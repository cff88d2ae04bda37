// Probing: downwards to a plate, or sideways to an edge, and the zero of the work from the contact.

import { button, input, part } from "../elements";
import { LETTERS, MM_PER_INCH } from "./dialect";
import type { Machine } from "./machine";
import { readModes, type Modes } from "./modes";

/** Where to: an axis and a direction. */
interface Way {
  axis: number;
  sign: 1 | -1;
}

export class Probe {
  /** Where the last contact was, in the machine's coordinates and the unit of its reports, and which way it was looked for. */
  private contact: { place: number[]; way: Way } | undefined;
  private way: Way = { axis: 2, sign: -1 };

  constructor(private readonly machine: Machine) {
    button("probe").onclick = () => this.start();
    button("probe-zero").onclick = () => this.setZero();
    for (const choice of document.querySelectorAll<HTMLInputElement>("[name=probe-to]")) choice.onchange = () => this.turn(choice.value);
    machine.watch({
      began: () => this.forget(),
      said: (message) => this.hear(message),
      reported: () => (button("probe-zero").disabled = !this.contact || machine.state !== "Idle"),
    });
  }

  /** Looks another way. What was found before is of no use for that. */
  private turn(words: string): void {
    this.way = { axis: LETTERS.indexOf(words[0] ?? ""), sign: words[1] === "-" ? -1 : 1 };
    this.forget();
    part("probe-beside").textContent = words[0] === "Z" ? "Thickness of the plate, mm" : "Radius of the tool, mm";
    button("probe-zero").textContent = `Set ${words[0]} by the contact`;
    button("probe-zero").disabled = true;
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
    if (this.machine.report.pins.includes("P")) return "The probe touches already: move the tool away, or see $6.";
    if (!(distanceMm > 0)) return "The distance must be above 0 mm.";
    if (!(feedMmPerMin > 0)) return "The feed must be above 0 mm/min.";
    return "";
  }

  /** In the modes as they are, so that they are the same after it. */
  private line({ isInches, isRelative }: Modes, distanceMm: number, feedMmPerMin: number): string {
    const { axis, sign } = this.way;
    const words = (mm: number): string => (isInches ? (mm / MM_PER_INCH).toFixed(4) : mm.toFixed(3));
    const fromMm = isRelative ? 0 : this.toMm(this.machine.report.workPosition[axis] ?? 0);
    return `G38.2 ${LETTERS[axis]}${words(fromMm + sign * distanceMm)} F${words(feedMmPerMin)}`;
  }

  private toMm(reported: number): number {
    return this.machine.isInches ? reported * MM_PER_INCH : reported;
  }

  private hear(message: string): void {
    const found = /^\[PRB:([^:]*):([01])\]$/.exec(message);
    if (!found) return;
    const place = (found[1] ?? "").split(",").map(Number);
    const { way } = this;
    this.contact = found[2] === "1" ? { place, way } : undefined;
    const unit = this.machine.isInches ? "in" : "mm";
    this.say(this.contact ? `Contact at ${LETTERS[way.axis]} ${place[way.axis]} ${unit} of the machine.` : "No contact within the distance.");
  }

  /** The contact was that far before the work: a plate's thickness above it, a tool's radius beside it. After the contact the machine has gone on a
   * little, and counts from there. */
  private setZero(): void {
    const besideMm = Number(input("probe-thickness").value);
    const { contact } = this;
    if (!contact || !(besideMm >= 0)) return this.say(`The ${this.way.axis === 2 ? "plate's thickness" : "tool's radius"} must be 0 mm or more.`);
    const { axis, sign } = contact.way;
    const pastMm = this.toMm((this.machine.report.machinePosition[axis] ?? 0) - (contact.place[axis] ?? 0));
    readModes(this.machine, ({ isInches }) => {
      const mm = pastMm - sign * besideMm;
      this.machine.command(`G10 L20 P0 ${LETTERS[axis]}${isInches ? (mm / MM_PER_INCH).toFixed(5) : mm.toFixed(3)}`, (answer) => {
        if (answer === "ok") this.say(`${LETTERS[axis]} is 0 at ${besideMm} mm ${axis === 2 ? "below" : "beyond"} the contact.`);
      });
    });
  }
}
