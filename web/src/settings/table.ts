// The table of settings, from the machine's own code. A worker answers one question, because one that waits for more takes memory.

import { Task } from "../job";
import type { FromWorker, SettingRow, ToWorker, Trouble } from "../messages";

export async function rows(axes: number): Promise<SettingRow[]> {
  const answer = await ask({ do: "setting-rows" }, axes);
  return answer.is === "setting-rows" ? answer.rows : [];
}

/** Why these settings cannot be together, on whichever board. */
export async function refusal(lines: string, axes: number): Promise<Trouble | null> {
  const answer = await ask({ do: "check-settings", lines }, axes);
  if (answer.is === "trouble") return answer.trouble;
  return answer.is === "settings-checked" ? answer.refusal : null;
}

function ask(question: ToWorker, axes: number): Promise<FromWorker> {
  return new Promise((resolve) => {
    const hear = (answer: FromWorker): boolean => {
      resolve(answer);
      return true;
    };
    new Task().ask(question, hear, (trouble) => resolve({ is: "trouble", trouble }), axes);
  });
}
