// How many axes the simulated machine has: X, Y and Z, or A too. A program that is refused for its A turns it to the latter.

import { AXES } from "./axes";
import { part, select } from "./elements";
import type { Refusal } from "./messages";

export class ChoiceOfAxes {
  private readonly choice = select("axes");
  /** A person has chosen, which stays so. */
  private isChosen = false;

  constructor(changed: () => void) {
    this.choice.onchange = () => {
      this.isChosen = true;
      changed();
    };
  }

  get value(): number {
    return Number(this.choice.value);
  }

  set value(axes: number) {
    this.choice.value = String(axes);
  }

  /** A program was run, and these lines were refused. Returns whether it should be run on the machine that there is now. */
  turns(refusals: Refusal[]): boolean {
    const line = refusals.find(({ text }) => hasA(text))?.line;
    if (this.value > AXES || line === undefined) return false;
    if (this.isChosen) this.say(`Line ${line} has A, which a machine with X, Y and Z refuses: choose X Y Z A.`);
    else {
      this.value = AXES + 1;
      this.say(`Line ${line} has A, so this is a machine with X, Y, Z and A.`);
    }
    return !this.isChosen;
  }

  /** Says what there is to say about the program that was run. */
  say(words: string): void {
    part("axes-note").textContent = words;
  }
}

/** Whether a line has a word of A, outside comments and names. */
export function hasA(line: string): boolean {
  return !/^\s*\$/.test(line) && /A\s*[-+.\d#[]/i.test(line.replace(/;.*|\([^)]*\)|<[^>]*>/g, ""));
}
