// Where the machine is and what it does, and the buttons for that.

import { button, part } from "../elements";
import { AXIS_NAMES } from "../motion";
import { HOLD, RESET, RESUME, type Status } from "./dialect";
import type { Machine } from "./machine";

/** The letters of inputs that are pressed; all others are limit switches of their axes. */
const PINS: Record<string, string> = {
  P: "probe",
  "2": "second motor's limit",
  D: "door open",
  R: "emergency stop",
  H: "feed hold",
  S: "cycle start",
};

export class State {
  constructor(private readonly machine: Machine) {
    const buttons: [string, () => void][] = [
      ["home", () => machine.command("$H")],
      ["unlock", () => machine.command("$X")],
      ["hold", () => machine.byte(HOLD)],
      ["resume", () => machine.byte(RESUME)],
      ["reset", () => machine.byte(RESET)],
      ["zero", () => machine.command("G0 X0 Y0 Z0")],
    ];
    for (const [id, act] of buttons) button(id).onclick = act;
    machine.watch({ reported: (report) => this.show(report), alarmed: (words) => this.showAlarm(words) });
  }

  showPosition(positionMm: number[]): void {
    positionMm.slice(0, AXIS_NAMES.length).forEach((mm, axis) => {
      part(`place-${AXIS_NAMES[axis]?.toLowerCase()}`).textContent = mm.toFixed(3);
    });
  }

  private show(report: Status): void {
    const { state } = report;
    const name = state.split(":")[0] ?? "";
    const badge = part("state");
    badge.textContent = state;
    badge.dataset["state"] = name;
    part("homed-now").textContent = this.machine.isHomed ? "yes" : "no";
    part("feed-now").textContent = `${report.feed ?? 0} mm/min`;
    part("pins-now").textContent = [...report.pins].map((pin) => PINS[pin] ?? `${pin} limit`).join(", ") || "none";
    if (report.override) part("override-now").textContent = `${report.override.split(",")[0]} %`;
    button("unlock").disabled = name !== "Alarm";
    // While it brakes still, it does not resume.
    button("resume").disabled = state !== "Hold:0" && state !== "Door:0";
    button("hold").disabled = !["Run", "Jog", "Home"].includes(name);
    button("home").disabled = !["Idle", "Alarm"].includes(name);
    button("zero").disabled = name !== "Idle" || !this.machine.isHomed;
  }

  private showAlarm(words: string): void {
    const place = part("alarm");
    place.textContent = words;
    place.hidden = !words;
  }
}
