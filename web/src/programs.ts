// Programs to choose from: ours, and files that are opened or dropped.

import { button, input, select } from "./elements";

/** Ours, with what each shows. */
const OURS: [string, string][] = [
  ["engraving.nc", "a car, engraved"],
  ["two_tools.nc", "two tools: drilled holes and an outline"],
  ["arcs.nc", "arcs and corners"],
  ["parking.nc", "homing, and long moves of three axes"],
  ["square.nc", "a square"],
  ["diagonal.nc", "one long diagonal"],
  ["ringing.nc", "stops and corners"],
];

/** The first thing that one sees. */
export const FIRST = "engraving.nc";

export class Programs {
  /** `take` gets one of ours, and `open` a file. */
  constructor(private readonly take: (name: string, text: string) => void, open: (file: File) => void) {
    const list = select("programs");
    for (const [file, words] of OURS) list.add(new Option(`${file}: ${words}`, file));
    list.onchange = () => void example(list.value).then((text) => this.take(list.value, text));
    const chosen = input("file");
    chosen.onchange = () => {
      const [found] = chosen.files ?? [];
      if (found) open(found);
      chosen.value = "";
    };
    button("open").onclick = () => chosen.click();
  }
}

/** The text of one of ours. */
export async function example(name: string): Promise<string> {
  return (await fetch(new URL(`programs/${name}`, import.meta.url))).text();
}
