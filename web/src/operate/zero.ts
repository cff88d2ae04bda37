// The zero of the work: which offset is in force, and where its zero is.

import { button, select } from "../elements";
import { LETTERS, type Status } from "./dialect";
import type { Machine } from "./machine";
import { readModes } from "./modes";

export class Zero {
  constructor(private readonly machine: Machine) {
    const system = select("work-system");
    system.onchange = () => machine.command(system.value, () => this.read());
    for (const axis of LETTERS) button(`zero-${axis.toLowerCase()}`).onclick = () => this.set(`${axis}0`);
    button("zero-all").onclick = () => this.set(machine.axes.map((axis) => `${axis}0`).join(" "));
    machine.watch({ reported: (report, before) => this.follow(report, before) });
  }

  /** The offset in force becomes such that the machine stands at zero. */
  private set(words: string): void {
    this.machine.command(`G10 L20 P0 ${words}`);
  }

  private follow({ state, offset }: Status, before: Status): void {
    const isIdle = state === "Idle";
    // By hand in a change of the tool, Z is set for the new one.
    for (const zero of document.querySelectorAll<HTMLButtonElement>("#zero-all, [id^=zero-][aria-label]")) zero.disabled = !isIdle && state !== "Tool";
    select("work-system").disabled = !isIdle;
    // A program or the console may have chosen another.
    if (isIdle && (before.state !== "Idle" || offset.join() !== before.offset.join())) this.read();
  }

  private read(): void {
    readModes(this.machine, ({ system }) => (select("work-system").value = system));
  }
}
