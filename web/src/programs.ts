// Programs to choose from: ours, and files that are opened or dropped.

import { button, input, part, select } from "./elements";

/** Ours, with what each shows. */
const OURS: [string, string][] = [
  ["parking.nc", "a car park: homing, three axes"],
  ["arcs.nc", "arcs and corners"],
  ["square.nc", "a square"],
  ["diagonal.nc", "one long diagonal"],
  ["engraving.nc", "an engraving of short moves"],
  ["two_tools.nc", "two tools: drilled holes and an outline"],
  ["ringing.nc", "stops and corners"],
];

export class Programs {
  constructor(private readonly take: (name: string, text: string) => void) {
    const list = select("programs");
    for (const [file, words] of OURS) list.add(new Option(`${file}: ${words}`, file));
    list.onchange = () => void this.fetch(list.value);
    const chosen = input("file");
    chosen.onchange = () => void this.read(chosen.files?.[0]);
    button("open").onclick = () => chosen.click();
    this.takeDropped(part("drop"));
  }

  /** One of ours. */
  async fetch(name: string): Promise<void> {
    const answer = await fetch(new URL(`programs/${name}`, import.meta.url));
    this.take(name, await answer.text());
  }

  private async read(file: File | undefined): Promise<void> {
    if (file) this.take(file.name, await file.text());
  }

  private takeDropped(place: HTMLElement): void {
    for (const kind of ["dragenter", "dragover"]) {
      place.addEventListener(kind, (event) => {
        event.preventDefault();
        place.classList.add("over");
      });
    }
    place.addEventListener("dragleave", () => place.classList.remove("over"));
    place.addEventListener("drop", (event) => {
      event.preventDefault();
      place.classList.remove("over");
      void this.read(event.dataTransfer?.files[0]);
    });
  }
}
