// What the page and its worker say to each other. A worker has one machine, and ends with it.

/** Stretches of motion, as columns: see `Motion` in crates/web. */
export interface Columns {
  times: Float64Array;
  kinds: Uint8Array;
  values: Float32Array;
}

export type ToWorker =
  | { do: "run"; program: Uint8Array; settings: string; withTrace: boolean }
  | { do: "operate"; settings: string; speed: number }
  | { do: "send"; bytes: Uint8Array }
  | { do: "speed"; speed: number }
  | { do: "stop-button"; pressed: boolean }
  | { do: "plate"; placeMm: number | undefined }
  | { do: "estimate"; program: Uint8Array; settings: string }
  | { do: "setting-rows" }
  | { do: "check-settings"; lines: string };

export type FromWorker =
  | { is: "progress"; answered: number; lines: number; seconds: number; motion: Columns; trace: Uint8Array }
  | { is: "ended"; summary: Summary; wallSeconds: number; motion: Columns; trace: Uint8Array }
  | { is: "trouble"; trouble: Trouble }
  | { is: "output"; bytes: Uint8Array; seconds: number }
  | { is: "estimated"; answeredAtS: Float64Array; totalS: number }
  | { is: "setting-rows"; rows: SettingRow[] }
  | { is: "settings-checked"; refusal: Trouble | null };

/** A setting: see `Row` in crates/web. */
export interface SettingRow {
  number: number;
  group: string;
  name: string;
  remark: string;
  unit: string;
  min: number;
  max: number;
  default: string;
  kind: "switch" | "mask" | "choice" | "whole" | "number";
  options: [number, string][];
}

export interface Trouble {
  line: number | null;
  words: string;
}

export interface Verdict {
  promise: string;
  kept: boolean;
  detail: string;
}

export interface Refusal {
  line: number;
  text: string;
  code: number;
  words: string;
}

export interface Summary {
  duration_s: number;
  homing_s: number;
  motion_s: number;
  moves: number;
  steps: number;
  state: string;
  position_mm: number[];
  travel_mm: number[];
  lines_sent: number;
  cut_short: boolean;
  alarm: number | null;
  verdicts: Verdict[];
  refusals: Refusal[];
  refusals_total: number;
  pauses: { line: number; text: string; words: string | null }[];
  messages: string[];
}
