// Sends settings to a machine, one by one. A setting may be refused until another has changed, so what is refused is
// tried again after the others, until nothing more is taken.

import type { Machine } from "../operate/machine";
import { line } from "./lines";

export interface Sent {
  taken: number[];
  /** What is still refused, in the machine's words. */
  refused: Map<number, string>;
}

/** The machine takes settings in these states only. */
export const mayBeSet = (state: string): boolean => ["Idle", "Alarm"].includes(state);

export async function send(machine: Machine, changes: [number, string][]): Promise<Sent> {
  const taken: number[] = [];
  for (let left = changes; ; ) {
    const refused: [number, string, string][] = [];
    for (const [number, value] of left) {
      const words = await refusal(machine, line(number, value));
      if (words) refused.push([number, value, words]);
      else taken.push(number);
    }
    const isOver = refused.length === 0 || refused.length === left.length;
    if (isOver) return { taken, refused: new Map(refused.map(([number, , words]) => [number, words])) };
    left = refused.map(([number, value]) => [number, value]);
  }
}

/** The machine's words, if it refuses a line. */
function refusal(machine: Machine, text: string): Promise<string | undefined> {
  return new Promise((resolve) => {
    machine.query(text, (printed, answer) => {
      if (answer === "ok") return resolve(undefined);
      const words = printed.map((said) => /^\[MSG:(.*)\]$/.exec(said)?.[1] ?? "").filter(Boolean);
      if (words.length) resolve(words.join(" "));
      else machine.explain(answer, resolve);
    });
  });
}
