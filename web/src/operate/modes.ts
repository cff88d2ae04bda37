// The modes in which the machine would understand a word, as `$G` lists them.

import type { Machine } from "./machine";

export interface Modes {
  /** G54 to G59. */
  system: string;
  isInches: boolean;
  isRelative: boolean;
  isInverseTime: boolean;
}

export function readModes(machine: Machine, then: (modes: Modes) => void): void {
  machine.query("$G", (printed) => {
    const words = printed.find((line) => line.startsWith("[GC:"))?.slice(4, -1).split(" ");
    if (!words) return;
    then({
      system: words.find((word) => /^G5[4-9]$/.test(word)) ?? "",
      isInches: words.includes("G20"),
      isRelative: words.includes("G91"),
      isInverseTime: words.includes("G93"),
    });
  });
}
