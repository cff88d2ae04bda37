// Lines of one's own behind a button, kept in this browser.

import { area, made, part } from "../elements";
import type { Machine } from "./machine";

const KEPT = "macros";

export interface Macro {
  name: string;
  lines: string[];
}

/** A name in brackets begins each; lines before the first name belong to none. */
export function macrosOf(text: string): Macro[] {
  const macros: Macro[] = [];
  for (const line of text.split("\n").map((each) => each.trim())) {
    const name = /^\[(.+)\]$/.exec(line)?.[1];
    if (name) macros.push({ name, lines: [] });
    else if (line) macros.at(-1)?.lines.push(line);
  }
  return macros.filter(({ lines }) => lines.length);
}

export class Macros {
  constructor(private readonly machine: Machine) {
    const text = area("macros-text");
    text.value = localStorage.getItem(KEPT) ?? "";
    text.oninput = () => {
      localStorage.setItem(KEPT, text.value);
      this.show();
    };
    machine.watch({ reported: () => this.enable() });
    this.show();
  }

  private show(): void {
    const buttons = macrosOf(area("macros-text").value).map(({ name, lines }) => {
      const button = made("button", name) as HTMLButtonElement;
      button.type = "button";
      button.title = lines.join("\n");
      button.onclick = () => this.send(lines);
      return button;
    });
    part("macros").replaceChildren(...(buttons.length ? buttons : [made("p", "None yet. A macro is a few lines that you send often, behind a button.", "note")]));
    this.enable();
  }

  private enable(): void {
    for (const button of part("macros").querySelectorAll("button")) button.disabled = !["Idle", "Alarm", "Tool"].includes(this.machine.state);
  }

  /** One by one: behind a refused line the others make no sense. */
  private send([first, ...rest]: string[]): void {
    if (first === undefined) return;
    this.machine.command(first, (answer) => answer === "ok" && this.send(rest));
  }
}
