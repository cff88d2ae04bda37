// What `isostep check` says of the program.

import { part } from "./elements";
import { Task } from "./job";
import { linked } from "./lines";
import type { CheckRow } from "./messages";
import { rowOf } from "./rows";

export class Advice {
  private readonly task = new Task();

  constructor(private readonly go: (line: number) => void) {}

  clear(): void {
    this.task.cancel();
    part("advice").replaceChildren();
    this.say("");
  }

  /** Looks at a program by itself, in a worker of its own. */
  look(program: Uint8Array, settings: string): void {
    this.clear();
    this.say("It is being looked at.");
    this.task.ask(
      { do: "check", program, settings },
      (said) => {
        if (said.is === "checked") this.tell(said.rows);
        return true;
      },
      (trouble) => this.say(trouble.words),
    );
  }

  private say(words: string): void {
    part("advice-state").textContent = words;
  }

  private tell(rows: CheckRow[]): void {
    this.say("");
    part("advice").replaceChildren(...rows.map((row) => rowOf(row, (words) => linked(words, this.go))));
  }
}
