// Grbl's dialect, from the side of a sender.

export const HOLD = 0x21;
export const RESUME = 0x7e;
export const RESET = 0x18;
export const STATUS = 0x3f;
export const JOG_CANCEL = 0x85;
export interface Status {
  state: string;
  position: number[];
  feed: number | undefined;
  pins: string;
  override: string;
}

/** A report, as `<Idle|MPos:0.000,0.000,0.000|FS:0,0>`. */
export function status(line: string): Status | undefined {
  if (!line.startsWith("<") || !line.endsWith(">")) return undefined;
  const [state = "", ...fields] = line.slice(1, -1).split("|");
  const found = new Map(fields.map((field) => [field.slice(0, field.indexOf(":")), field.slice(field.indexOf(":") + 1)]));
  return {
    state,
    position: (found.get("MPos") ?? found.get("WPos") ?? "").split(",").filter(Boolean).map(Number),
    feed: found.has("FS") ? Number(found.get("FS")?.split(",")[0]) : undefined,
    pins: found.get("Pn") ?? "",
    override: found.get("Ov") ?? "",
  };
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

