// Overrides of feed, rapids and spindle: bytes, and the values that the machine reports.

import { part } from "../elements";
import type { Machine } from "./machine";

const NAMES = ["feed", "rapids", "spindle"];

export function offerOverrides(machine: Machine): void {
  for (const key of part("overrides").querySelectorAll<HTMLButtonElement>("button[data-byte]")) {
    key.onclick = () => machine.byte(Number(key.dataset["byte"]));
    machine.watch({ reported: ({ state }) => (key.disabled = state === "Off") });
  }
  machine.watch({
    reported: ({ overrides }) =>
      NAMES.forEach((name, index) => {
        part(`override-${name}`).textContent = `${overrides[index]} %`;
      }),
  });
}
