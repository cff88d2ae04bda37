// A change of the tool: which one, in the program's own words, and how it is measured.

import { button, part } from "../elements";
import { askedTool, nameOf, type Status } from "./dialect";
import type { Machine } from "./machine";

/** What is known of the program that is sent. */
export interface SentProgram {
  /** The line that is answered next, from 1. */
  readonly line: number | undefined;
  /** What it says of the tool that this line asks for. */
  comment(line: number, tool: number): string | undefined;
}

/** As `tool 2: 6 mm end mill`. */
export function toolWords(tool: number, comment?: string): string {
  const name = tool ? `tool ${tool}` : "another tool";
  return comment ? `${name}: ${comment}` : name;
}

export class Change {
  /** The program that is sent, if there is one. */
  program: SentProgram | undefined;
  /** The tool that was asked for, and the line of the program that did. */
  private asked: { tool: number; line: number | undefined } | undefined;
  private isTold = false;

  constructor(private readonly machine: Machine) {
    button("measure-tool").onclick = () => machine.command("$TPW");
    machine.watch({
      began: () => this.forget(),
      said: (message) => this.hear(message),
      reported: (report) => this.show(report),
    });
  }

  /** What is waited for, as a sentence without its end; empty if no tool is. */
  get words(): string {
    if (!this.isTold) return "";
    const { tool, line } = this.asked ?? { tool: 0, line: undefined };
    const comment = line === undefined ? undefined : this.program?.comment(line, tool);
    return `Waits for ${toolWords(tool, comment)}`;
  }

  private forget(): void {
    this.asked = undefined;
    this.isTold = false;
  }

  private hear(message: string): void {
    const tool = askedTool(message);
    if (tool !== undefined) this.asked = { tool, line: this.program?.line };
  }

  /** With `$341=0` it waits in Hold. */
  private show({ state }: Status): void {
    const waits = this.machine.isChanging || (this.asked !== undefined && nameOf(state) === "Hold");
    if (this.isTold && !waits) this.forget();
    this.isTold = waits;
    part("tool-wait").hidden = !waits;
    part("tool-wait-now").textContent = this.words;
    const measure = button("measure-tool");
    measure.hidden = !this.machine.isChanging || !["1", "2"].includes(this.machine.settings.get(341) ?? "");
    measure.disabled = !this.machine.waitsForTool;
  }
}
