// The `$$` of somebody's machine: what is taken of it stands among the settings, and what becomes of each line is said below them.

import { area, button, element, input, part } from "./elements";
import { bytes, Task } from "./job";
import { rowOf } from "./rows";
import { setting } from "./operate/dialect";

/** The first lines tell what a file is. */
const TELLING_LINES = 1_000;

/** A file of which most lines set something is a listing, and no program. */
export function isListing(text: string): boolean {
  const lines = text.split(/\r\n|\r|\n/, TELLING_LINES).filter((line) => line.trim());
  const sets = lines.filter((line) => setting(line) || /^\s*\$[A-Za-z][\w/]*\s*=/.test(line));
  return sets.length > lines.length / 2;
}

export class Listing {
  private readonly task = new Task();

  /** `take` gets the lines of `$n=v` that are taken. */
  constructor(private readonly take: (lines: string) => void, open: (file: File) => void) {
    const chosen = input("listing-file");
    button("open-listing").onclick = () => chosen.click();
    chosen.onchange = () => {
      const [found] = chosen.files ?? [];
      if (found) open(found);
      chosen.value = "";
    };
    area("settings").addEventListener("paste", (event) => this.paste(event));
  }

  read(name: string, text: string): void {
    element("settings-details", HTMLDetailsElement).open = true;
    this.say(`${name} is read.`);
    part("listing").replaceChildren();
    this.task.ask(
      { do: "list-settings", text: bytes(text) },
      (said) => {
        if (said.is !== "settings-listed") return false;
        const { taken, rows } = said.listed;
        if (taken !== null) this.take(taken);
        part("listing").replaceChildren(...rows.map((row) => rowOf(row, (words) => [words])));
        this.say(taken === null ? `${name}: nothing is taken, because it does not work together.` : `${name}, line by line:`);
        return true;
      },
      (trouble) => this.say(trouble.words),
    );
  }

  private say(words: string): void {
    part("listing-state").textContent = words;
  }

  /** A whole listing is read as a file is. Single lines are entered as they are. */
  private paste(event: ClipboardEvent): void {
    const { value, selectionStart, selectionEnd } = area("settings");
    const text = event.clipboardData?.getData("text/plain") ?? "";
    const isWhole = selectionEnd - selectionStart === value.length;
    if (!isWhole || !isListing(text) || !/\n./.test(text)) return;
    event.preventDefault();
    this.read("What was pasted", text);
  }
}
