// The console: what was said, and a line to send.

import { element, input, made, part } from "../elements";
import type { Machine } from "./machine";

/** Lines that are kept. */
const LOG_MAX = 500;

export class Console {
  private readonly history: string[] = [];
  private past = 0;

  constructor(private readonly machine: Machine) {
    const line = input("line");
    element("console", HTMLFormElement).onsubmit = (event) => {
      event.preventDefault();
      this.send(line.value.trim());
      line.value = "";
    };
    line.onkeydown = (event) => {
      const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
      if (!step) return;
      event.preventDefault();
      this.past = Math.min(Math.max(0, this.past + step), this.history.length);
      line.value = this.history[this.past] ?? "";
    };
    machine.watch({ logged: (text, kind) => this.log(text, kind) });
  }

  private send(text: string): void {
    if (!text) return;
    this.past = this.history.push(text);
    if (["?", "!", "~"].includes(text)) this.machine.byte(text.charCodeAt(0));
    else this.machine.command(text);
  }

  private log(text: string, kind: string): void {
    const log = part("log");
    const isAtEnd = log.scrollHeight - log.scrollTop - log.clientHeight < 40;
    log.append(made("div", kind === "sent" ? `> ${text}` : text, kind));
    while (log.childElementCount > LOG_MAX) log.firstElementChild?.remove();
    if (isAtEnd) log.scrollTop = log.scrollHeight;
  }
}
