// What the page and its worker say to each other. A worker has one machine, and ends with it.

/** A piece of motion: phases as columns, each of which has one number for each phase, or one alone that holds throughout: see `piece` in crates/web. */
export interface Columns {
  phases: number;
  /** When the last one ends, s. */
  end: number;
  begins: Float64Array;
  pauses: Float64Array;
  kinds: Uint8Array;
  ofAxes: OfAxis[];
  loads: Uint16Array;
  jumps: Uint16Array;
  asked: Float32Array;
  /** One for each change of the tool's power meanwhile. */
  powerTimes: Float64Array;
  powers: Float32Array;
}

/** Place, speed and acceleration of an axis where each phase begins, mm and s, and how much larger the acceleration is at its end. */
export interface OfAxis {
  places: Float32Array;
  speeds: Float32Array;
  accels: Float32Array;
  changes: Float32Array;
}

/** When lines of the program begin to move the machine, s. */
export interface LineTimes {
  times: Float64Array;
  lines: Uint32Array;
}

/** What is kept of a run beside its motion: see `Kept` in crates/web. */
export type Kept = "lines" | "trace" | "waves";

/** What is said of a program under one name. */
export interface CheckRow {
  name: string;
  words: string;
  places: string[];
}

export type ToWorker =
  | { do: "run"; program: Uint8Array; settings: string; kept: Kept }
  | { do: "check"; program: Uint8Array; settings: string }
  | { do: "report"; name: string; program: Uint8Array; settings: string }
  | { do: "profiles"; asked: number[] }
  | { do: "operate"; settings: string; speed: number }
  | { do: "send"; bytes: Uint8Array }
  | { do: "speed"; speed: number }
  | { do: "stop-button"; pressed: boolean }
  | { do: "plate"; placeMm: number | undefined }
  | { do: "plan"; program: Uint8Array; before: Uint8Array; settings: string }
  | { do: "setting-rows" }
  | { do: "check-settings"; lines: string }
  | { do: "list-settings"; text: Uint8Array }
  | { do: "quick"; program: Uint8Array; settings: string; load: Load | undefined };

export type FromWorker =
  | { is: "progress"; answered: number; lines: number; seconds: number; motion: Columns[]; rows: Uint8Array; lineTimes: LineTimes }
  | { is: "ended"; summary: Summary; wallSeconds: number; motion: Columns[]; rows: Uint8Array; lineTimes: LineTimes }
  | { is: "checked"; rows: CheckRow[] }
  | { is: "reported"; report: string }
  | { is: "profiles"; profiles: Profiles }
  | { is: "trouble"; trouble: Trouble }
  | { is: "output"; bytes: Uint8Array; seconds: number }
  | { is: "tools"; tools: ToolRow[] }
  | { is: "plain"; lines: [number: number, text: string][] | null }
  | { is: "planned"; motion: Columns[]; lines: LineTimes; answeredAtS: Float64Array; beganS: number; totalS: number; placeMm: number[]; said: string[] }
  | { is: "setting-rows"; rows: SettingRow[] }
  | { is: "settings-checked"; refusal: Trouble | null }
  | { is: "settings-listed"; listed: Listed }
  | { is: "quickly"; answered: number; lines: number }
  | { is: "found"; found: Found }
  | { is: "swung"; swings: Swings | null; words: string };

/** A line with M6, its tool, and what the program says of that. */
export interface ToolRow {
  line: number;
  tool: number;
  comment: string | null;
}

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

/** What `isostep profile` says of them, and their curves: times in s, and then mm. */
export interface Profiles {
  names: string[];
  rows: { name: string; cells: string[] }[];
  refused: { name: string; words: string }[];
  curves: { name: string; times: number[]; speed: number[]; accel: number[]; jerk: number[] }[];
}

/** What becomes of a `$$` of another controller: see `Listed` in crates/web. */
export interface Listed {
  taken: string | null;
  rows: CheckRow[];
}

/** A run for its time alone: see `Found` in crates/web. */
export interface Found {
  program_s: number;
  stopped: string | null;
  corners_mm: number | null;
  together_mm: number | null;
  shaped_mm: number | null;
}

/** A load behind X and Y that rings. */
export interface Load {
  hz: number;
  damping: number;
}

/** How far it swings: see `Swings` in crates/web. */
export interface Swings {
  after_stops_mm: number | null;
  after_corners_mm: number | null;
}

export interface Trouble {
  /** The text that it is about: the program, if it does not say. */
  about?: "program" | "settings";
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
  pauses: { line: number; text: string; words: string | null; comment: string | null }[];
  messages: string[];
  said_last: string[];
}
