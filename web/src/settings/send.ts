// Sends settings to a machine, one by one, in any order: the machine keeps what does not work together, and says so.

import type { Machine } from "../operate/machine";
import { line } from "./lines";

export interface Sent {
  taken: number[];
  /** What is refused, in the machine's words. */
  refused: Map<number, string>;
  /** What the machine said of the last one that it has taken: whether all work together, among others. */
  remark: string;
}

/** The machine takes settings in these states only. */
export const mayBeSet = (state: string): boolean => ["Idle", "Alarm"].includes(state);

export async function send(machine: Machine, changes: [number, string][]): Promise<Sent> {
  const sent: Sent = { taken: [], refused: new Map(), remark: "" };
  for (const [number, value] of changes) {
    const { isTaken, words } = await ask(machine, line(number, value));
    if (isTaken) sent.taken.push(number);
    else sent.refused.set(number, words);
    sent.remark = isTaken ? words : sent.remark;
  }
  return sent;
}

/** Whether the machine takes a line, and what it says of it. */
function ask(machine: Machine, text: string): Promise<{ isTaken: boolean; words: string }> {
  return new Promise((resolve) => {
    machine.query(text, (printed, answer) => {
      const words = printed.map((said) => /^\[MSG:(.*)\]$/.exec(said)?.[1] ?? "").filter(Boolean).join(" ");
      const isTaken = answer === "ok";
      if (isTaken || words) resolve({ isTaken, words });
      else machine.explain(answer, (explained) => resolve({ isTaken, words: explained }));
    });
  });
}
