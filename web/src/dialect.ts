// Grbl's dialect, from the side of a sender.

export const HOLD = 0x21;
export const RESUME = 0x7e;
export const RESET = 0x18;
export const STATUS = 0x3f;
export const JOG_CANCEL = 0x85;
/** Bytes that the controller takes before it has answered. */
export const WINDOW_BYTES = 128;

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

/** Lines under way: no more bytes are sent than the controller takes. */
export class Flight {
  private readonly waiting: { line: string; answered: (answer: string) => void }[] = [];
  private readonly sent: { length: number; answered: (answer: string) => void }[] = [];
  private bytes = 0;

  constructor(private readonly send: (line: string) => void) {}

  /** Sends a line as soon as there is room, and tells its answer, `ok` or `error:N`. */
  push(line: string, answered: (answer: string) => void): void {
    this.waiting.push({ line, answered });
    this.fill();
  }

  /** How many lines wait or are under way. */
  get length(): number {
    return this.waiting.length + this.sent.length;
  }

  /** An answer has come. */
  answer(answer: string): void {
    const first = this.sent.shift();
    if (!first) return;
    this.bytes -= first.length;
    first.answered(answer);
    this.fill();
  }

  /** Nothing more is sent; what is under way is answered still. */
  forgetWaiting(): void {
    this.waiting.length = 0;
  }

  /** The controller begins anew, and answers nothing of before. */
  restart(): void {
    this.forgetWaiting();
    this.sent.length = this.bytes = 0;
  }

  private fill(): void {
    for (;;) {
      const next = this.waiting[0];
      if (!next) return;
      const length = next.line.length + 1;
      if (this.sent.length && this.bytes + length > WINDOW_BYTES) return;
      this.waiting.shift();
      this.sent.push({ length, answered: next.answered });
      this.bytes += length;
      this.send(next.line);
    }
  }
}
