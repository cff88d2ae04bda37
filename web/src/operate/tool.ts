// Spindle or laser, and coolant.

import { button, input, part } from "../elements";
import { FLOOD, MIST, nameOf, type Status } from "./dialect";
import type { Machine } from "./machine";

/** States in which the machine takes the bytes of coolant. */
const SWITCHES_COOLANT = ["Idle", "Run", "Hold"];

export class Tool {
  constructor(private readonly machine: Machine) {
    const speed = (): string => `S${input("tool-s").value || "0"}`;
    button("tool-cw").onclick = () => machine.command(`M3 ${speed()}`);
    button("tool-ccw").onclick = () => machine.command(`M4 ${speed()}`);
    button("tool-off").onclick = () => machine.command("M5");
    button("flood").onclick = () => machine.byte(FLOOD);
    button("mist").onclick = () => machine.byte(MIST);
    button("coolant-off").onclick = () => machine.command("M9");
    machine.watch({ reported: (report) => this.show(report), set: () => this.name() });
  }

  private get isLaser(): boolean {
    return this.machine.settings.get(32) === "1";
  }

  /** As the settings have it. */
  private name(): void {
    part("h-tool").textContent = this.isLaser ? "Laser and coolant" : "Spindle and coolant";
    button("tool-cw").textContent = this.isLaser ? "M3 constant" : "M3 clockwise";
    button("tool-ccw").textContent = this.isLaser ? "M4 by speed" : "M4 counter\u00adclockwise";
    part("laser-note").hidden = !this.isLaser;
    const most = Number(this.machine.settings.get(30) ?? "");
    if (most) part("tool-most").textContent = `S, ${Number(this.machine.settings.get(31))} to ${most}${this.isLaser ? "" : " rpm"}`;
  }

  private show({ state, accessories, spindle }: Status): void {
    const direction = accessories.includes("S") ? "M3" : accessories.includes("C") ? "M4" : "";
    part("tool-now").textContent = direction ? `on, ${direction}, S ${spindle} now` : "off";
    const isIdle = state === "Idle";
    for (const id of ["tool-cw", "tool-ccw", "tool-off", "coolant-off"]) button(id).disabled = !isIdle;
    for (const [id, letter] of [["flood", "F"], ["mist", "M"]] as const) {
      button(id).disabled = !SWITCHES_COOLANT.includes(nameOf(state));
      button(id).setAttribute("aria-pressed", String(accessories.includes(letter)));
    }
  }
}
