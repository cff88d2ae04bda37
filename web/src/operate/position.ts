// Where the machine is: from the zero of the work, and from its own.

import { button, input, part } from "../elements";
import { AXIS_NAMES } from "../motion";
import type { Status } from "./dialect";
import type { Machine } from "./machine";

export class Position {
  constructor(private readonly machine: Machine) {
    button("zero").onclick = () => this.goToZero();
    machine.watch({ reported: (report) => this.show(report) });
  }

  private show(report: Status): void {
    const decimals = this.machine.isInches ? 4 : 3;
    // What is not known is not 0.
    const text = (value: number | undefined): string => (value === undefined ? "–" : value.toFixed(decimals).replace(/^-(0\.0+)$/, "$1"));
    AXIS_NAMES.forEach((axis, index) => {
      part(`work-${axis.toLowerCase()}`).textContent = text(report.workPosition[index]);
      part(`place-${axis.toLowerCase()}`).textContent = text(report.machinePosition[index]);
    });
    part("position-unit").textContent = this.machine.isInches ? "inches" : "mm";
    button("zero").disabled = report.state !== "Idle";
  }

  /** As jogs, which leave the modes of the program alone. Below its zero Z goes up first, otherwise it goes last. */
  private goToZero(): void {
    const feed = input("jog-feed").value || "1000";
    const [plane, down] = ["X0 Y0", "Z0"].map((words) => `$J=G21 G90 ${words} F${feed}`) as [string, string];
    const isBelow = (this.machine.report.workPosition[2] ?? 0) < 0;
    for (const line of isBelow ? [down, plane] : [plane, down]) this.machine.command(line);
  }
}
