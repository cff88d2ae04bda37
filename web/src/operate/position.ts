// Where the machine is: from the zero of the work, and from its own.

import { A, isRotary, unitOf } from "../axes";
import { button, element, input, part } from "../elements";
import { LETTERS, type Status } from "./dialect";
import type { Machine } from "./machine";

export class Position {
  constructor(private readonly machine: Machine) {
    button("zero").onclick = () => this.goToZero();
    element("go-to", HTMLFormElement).onsubmit = (event) => {
      event.preventDefault();
      this.goThere();
    };
    machine.watch({ reported: (report) => this.show(report) });
  }

  private show(report: Status): void {
    // What is not known is not 0.
    const text = (value: number | undefined, axis: number): string => (value === undefined ? "–" : value.toFixed(this.machine.isInInches(axis) ? 4 : 3).replace(/^-(0\.0+)$/, "$1"));
    const { axes } = this.machine;
    for (const row of part("places").querySelectorAll<HTMLElement>("[data-axis]")) {
      const axis = row.dataset["axis"] ?? "";
      const index = LETTERS.indexOf(axis);
      row.hidden = !axes.includes(axis);
      part(`work-${axis.toLowerCase()}`).textContent = text(report.workPosition[index], index);
      part(`place-${axis.toLowerCase()}`).textContent = text(report.machinePosition[index], index);
      button(`home-${axis.toLowerCase()}`).disabled = button("home").disabled;
    }
    part("go-turn").hidden = !axes.includes("A");
    part("letter-a").textContent = unitOf(A, isRotary(this.machine.settings)) === "degrees" ? "A°" : "A";
    part("position-unit").textContent = this.machine.isInches ? "inches" : "mm";
    button("zero").disabled = button("go").disabled = report.state !== "Idle";
  }

  private get feed(): string {
    return input("jog-feed").value || "1000";
  }

  /** As jogs, which leave the modes of the program alone. Below its zero Z goes up first, otherwise it goes last. */
  private goToZero(): void {
    const [plane, down] = ["X0 Y0", "Z0"].map((words) => `$J=G21 G90 ${words} F${this.feed}`) as [string, string];
    const isBelow = (this.machine.report.workPosition[2] ?? 0) < 0;
    for (const line of isBelow ? [down, plane] : [plane, down]) this.machine.command(line);
  }

  /** To typed coordinates of the work, in the unit that is shown; what is left empty stays. Up it goes first, down last. */
  private goThere(): void {
    const typed = (axis: string): string => input(`go-${axis.toLowerCase()}`).value;
    const typedOf = (axes: string[]): string => axes.filter(typed).map((axis) => `${axis}${typed(axis)}`).join(" ");
    const { axes } = this.machine;
    const words = [typedOf(axes.filter((axis) => axis !== "Z")), typedOf(["Z"])].filter(Boolean);
    part("go-trouble").textContent = words.length ? "" : `Type where to, at least one of ${axes.join(", ").replace(/, (.)$/, " and $1")}.`;
    const unit = this.machine.isInches ? `G20 G90` : "G21 G90";
    const feed = this.machine.isInches ? (Number(this.feed) / 25.4).toFixed(2) : this.feed;
    const jogs = words.map((of) => `$J=${unit} ${of} F${feed}`);
    const goesUp = typed("Z") && Number(typed("Z")) > (this.machine.report.workPosition[2] ?? 0);
    for (const line of goesUp ? jogs.reverse() : jogs) this.machine.command(line);
  }
}
