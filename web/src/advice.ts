// What `isostep check` says of the program.

import { made, part } from "./elements";
import { bytes, Task } from "./job";
import { linked } from "./lines";
import type { CheckRow } from "./messages";

export class Advice {
  private readonly task = new Task();

  constructor(private readonly go: (line: number) => void) {}

  clear(): void {
    this.task.cancel();
    part("advice").replaceChildren();
    this.say("");
  }

  /** Looks at a program by itself, in a worker of its own. */
  look(program: string, settings: string): void {
    this.clear();
    this.say("It is being looked at.");
    this.task.ask(
      { do: "check", program: bytes(program), settings },
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
    part("advice").replaceChildren(...rows.map((row) => this.row(row)));
  }

  private row({ name, words, places }: CheckRow): HTMLElement {
    const row = made("tr", "");
    const head = made("th", name);
    head.setAttribute("scope", "row");
    const said = made("td", "");
    said.append(...linked(words, this.go));
    if (places.length) said.append(this.list(places));
    row.append(head, said);
    return row;
  }

  private list(places: string[]): HTMLElement {
    const list = made("ul", "");
    for (const place of places) {
      const item = made("li", "");
      item.append(...linked(place, this.go));
      list.append(item);
    }
    return list;
  }
}
