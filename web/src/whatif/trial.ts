// A run for its time alone, in a worker of its own. What is asked next ends it.

import { bytes, chosenAxes, Task } from "../job";
import type { Found, Load, Swings, Trouble } from "../messages";

/** What is known of it so far. */
export interface Known {
  found?: Found;
  /** Of the load, if one was given: how it swings, or why that is not known. */
  swings?: Swings;
  unknown?: string;
  trouble?: Trouble;
}

export class Trial {
  known: Known = {};
  private readonly task = new Task();
  private key = "";

  /** Asks for a program with settings, unless that is what is known already. Calls `heard` when more is known, and `progress`. */
  ask(program: string, settings: string, load: Load | undefined, heard: () => void, progress: (share: number) => void): void {
    const key = JSON.stringify([program, settings, load, chosenAxes()]);
    if (key === this.key) return heard();
    this.key = key;
    this.known = {};
    this.task.ask(
      { do: "quick", program: bytes(program), settings, load },
      (said) => {
        if (said.is === "quickly") progress(said.lines ? said.answered / said.lines : 0);
        if (said.is === "found") this.known.found = said.found;
        if (said.is === "swung" && said.swings) this.known.swings = said.swings;
        if (said.is === "swung" && !said.swings) this.known.unknown = said.words;
        if (said.is === "found" || said.is === "swung") heard();
        return said.is === (load ? "swung" : "found");
      },
      (trouble) => {
        this.known = { trouble };
        heard();
      },
    );
  }

  cancel(): void {
    this.task.cancel();
    this.key = "";
    this.known = {};
  }
}
