// The settings that matter for how fast and how gently a program is made.

import { Choice } from "./choice";
import type { Control } from "./control";
import { Knob } from "./knob";
import type { SettingRow } from "../messages";

export type Rows = ReadonlyMap<number, SettingRow>;
export type Values = ReadonlyMap<number, string>;

/** The speed profile that has a jerk. */
const S_CURVE = 1;
const SHAPER = 950;
const SPEED_PROFILE = 940;

/** Each moves its settings together; where they differ, they keep their ratio. */
export function knobs(rows: Rows, changed: () => void): Control[] {
  const shaper = new Choice([SHAPER, SHAPER + 1], rows, changed);
  const speedProfile = new Choice([SPEED_PROFILE], rows, changed);
  const knob = (numbers: number[], along: number[] = [], isUsed = () => true): Control => new Knob(numbers, along, rows, changed, isUsed);
  return [
    // Brakes go with them, where they are set apart.
    knob([120, 121], [920, 921]),
    knob([122], [922]),
    knob([110, 111]),
    knob([112]),
    knob([904]),
    knob([11]),
    shaper,
    knob([960, 961], [], () => shaper.value !== 0),
    speedProfile,
    knob([930, 931, 932], [], () => speedProfile.value === S_CURVE),
  ];
}
