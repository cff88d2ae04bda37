// Grbl's dialect, from the side of a sender.

import { AXIS_NAMES } from "../axes";

export const HOLD = 0x21;
export const RESUME = 0x7e;
export const RESET = 0x18;
export const STATUS = 0x3f;
export const JOG_CANCEL = 0x85;
export const FLOOD = 0xa0;
export const MIST = 0xa1;
/** What is sent behind it in a change of the tool is by hand. */
export const TOOL_CHANGE = 0xa3;
export const MM_PER_INCH = 25.4;
/** The axes that a machine may have, in the order in which it reports them. */
export const LETTERS: readonly string[] = AXIS_NAMES;

/** What is known by the last reports. A machine does not tell all of it in each. */
export interface Status {
  /** As `Idle` or `Hold:0`. */
  state: string;
  /** In the unit of reports. */
  machinePosition: number[];
  workPosition: number[];
  offset: number[];
  feed: number;
  spindle: number;
  /** The letters of inputs that are on. */
  pins: string;
  /** Feed, rapids, spindle, %. */
  overrides: number[];
  /** S or C, F, M: what is on. */
  accessories: string;
  /** Moves and bytes for which there is room; undefined if `$10` does not ask for it. */
  room: number[] | undefined;
  /** N of the line that is carried out. */
  line: number | undefined;
  /** The axes that are homed, bit 0 for X, if this report tells: it does when that has changed. */
  homedMask: number | undefined;
}

export const UNKNOWN: Status = {
  state: "Off",
  machinePosition: [],
  workPosition: [],
  offset: [],
  feed: 0,
  spindle: 0,
  pins: "",
  overrides: [100, 100, 100],
  accessories: "",
  room: undefined,
  line: undefined,
  homedMask: undefined,
};

/** The name of a state, without its number. */
export const nameOf = (state: string): string => state.split(":")[0] ?? "";

/** Whether a change of the tool goes on in this state, once it has begun: there may be jogs and holds in it. */
export const goesOnChanging = (state: string): boolean => ["Tool", "Jog", "Hold", "Door"].includes(nameOf(state));

/** The tool that a message of M6 asks for, 0 if it has no number. */
export function askedTool(message: string): number | undefined {
  if (message.startsWith("[MSG:M6: change the tool,")) return 0;
  const number = /^\[MSG:M6: put in tool (\d+)/.exec(message)?.[1];
  return number === undefined ? undefined : Number(number);
}

/** What a report, as `<Idle|MPos:0.000,0.000,0.000|FS:0,0>`, adds to what was known. */
export function status(line: string, before: Status): Status | undefined {
  if (!line.startsWith("<") || !line.endsWith(">")) return undefined;
  const [state = "", ...fields] = line.slice(1, -1).split("|");
  const found = new Map(fields.map((field) => [field.slice(0, field.indexOf(":")), field.slice(field.indexOf(":") + 1)]));
  const numbers = (name: string): number[] | undefined => found.get(name)?.split(",").map(Number);
  const offset = numbers("WCO") ?? before.offset;
  const shifted = (place: number[], by: 1 | -1): number[] => place.map((value, axis) => value + by * (offset[axis] ?? 0));
  const [machine, work] = [numbers("MPos"), numbers("WPos")];
  const [feed = 0, spindle = 0] = numbers("FS") ?? [];
  return {
    state,
    machinePosition: machine ?? shifted(work ?? [], 1),
    workPosition: work ?? shifted(machine ?? [], -1),
    offset,
    feed,
    spindle,
    pins: found.get("Pn") ?? "",
    overrides: numbers("Ov") ?? before.overrides,
    // It comes with the overrides, and is left out if nothing is on.
    accessories: found.get("A") ?? (found.has("Ov") ? "" : before.accessories),
    room: numbers("Bf"),
    line: numbers("Ln")?.[0],
    homedMask: numbers("H")?.[1],
  };
}

/** A line that sets something, as `$110=2880.000`. */
export function setting(line: string): [number, string] | undefined {
  const found = /^\$(\d+)\s*=\s*([^\s(;]+)/.exec(line.trim());
  return found ? [Number(found[1]), found[2] ?? ""] : undefined;
}

/** Puts bytes together to lines. */
export class Lines {
  private partial = "";

  push(bytes: Uint8Array): string[] {
    const parts = (this.partial + String.fromCharCode(...bytes)).split(/\r?\n/);
    this.partial = parts.pop() ?? "";
    return parts.filter(Boolean);
  }
}
