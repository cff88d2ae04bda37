// What the machine would do with a program, from where it stands: the same program runs in virtual time, with the settings, the offsets and the
// place of the machine. So its path, the time left, and whether it fits are known before a line is sent.

import { AXIS_NAMES, axesOf, isRotary, unitOf } from "../axes";
import { worker } from "../job";
import type { Columns, FromWorker, ToolRow, ToWorker } from "../messages";
import { Motion } from "../motion";

/** The ends of the travel are looked at afterwards, so that they can be named, and a change of the tool takes no time. */
const WITHOUT_ENDS = "$20=0\n$21=0\n$341=0\n";
/** What a place may be off by, as rounded numbers go, mm. */
const ROUNDED_MM = 0.002;
/** Where the travel of the first axis stands. */
const TRAVEL = 130;

/** An axis that would leave its travel. */
export interface Beyond {
  axis: string;
  /** The farthest place, mm, or degrees of a rotary axis, as all of an axis. */
  placeMm: number;
  travelMm: number;
  unit: string;
  /** The first line that goes beyond. */
  line: number;
}

export class Plan {
  readonly motion = new Motion();
  /** Which tools the program asks for, and what it says of them. */
  tools: ToolRow[] = [];
  /** The plain lines that are made of a program that computes or calls, with the numbers of those that they are made from. */
  made: [number: number, text: string][] | undefined;
  /** The whole of it, from the first line to the end, s; undefined before it is known, or if it cannot be. */
  totalS: number | undefined;
  /** Where the machine is at its end, mm, and what it has said last. */
  placeMm: number[] = [];
  said: string[] = [];
  /** From where to where each axis goes, mm of the machine, degrees of a rotary axis; of no motion nothing. */
  extents: [number, number][] = [];
  /** How far each axis goes beyond its travel, and the first line that does. */
  beyond: Beyond[] = [];
  /** Why it cannot be run. */
  trouble = "";
  private readonly worker: Worker;
  private readonly before: number;
  private beganS = 0;
  private answeredAtS: Float64Array = new Float64Array();

  /** Lines before the program make a machine at power-up such as this one is. `done` is called once, when all is known that will be. */
  constructor(
    program: string,
    private readonly settings: ReadonlyMap<number, string>,
    before: string[],
    done: () => void,
  ) {
    this.before = before.length;
    this.motion.isRotary = isRotary(settings);
    this.worker = worker(axesOf(settings));
    this.worker.onmessage = ({ data }: MessageEvent<FromWorker>) => {
      if (data.is === "tools") return void (this.tools = data.tools);
      if (data.is === "plain") return void (this.made = data.lines ?? undefined);
      if (data.is === "planned") this.take(data.motion, data);
      if (data.is === "trouble") this.trouble = this.placed(data.trouble.line, data.trouble.words);
      this.end();
      done();
    };
    this.worker.onerror = (event) => {
      this.trouble = event.message || "the simulated machine did not start";
      done();
    };
    const lines = [...settings].map(([number, value]) => `$${number}=${value}\n`);
    this.worker.postMessage({
      do: "plan",
      program: new TextEncoder().encode(program),
      before: new TextEncoder().encode(before.map((line) => `${line}\n`).join("")),
      settings: lines.join("") + WITHOUT_ENDS,
    } satisfies ToWorker);
  }

  /** It is wanted no more. */
  end(): void {
    this.worker.terminate();
  }

  /** What the program says of the tool that this line asks for. */
  comment(line: number, tool: number): string | undefined {
    return this.tools.find((row) => row.line === line && row.tool === tool)?.comment ?? undefined;
  }

  /** When a line is answered, s from the first one on. */
  answeredS(line: number): number {
    return (this.answeredAtS[line + this.before - 1] ?? this.beganS) - this.beganS;
  }

  /** What of the motion is made when so much time has gone, s of the motion. */
  atS(goneS: number): number {
    return this.beganS + goneS;
  }

  /** How much time has gone when so much of the motion is made, s. */
  goneS(madeS: number): number {
    return madeS - this.beganS;
  }

  /** When a line begins to move the machine, s of the motion; undefined if it never does. */
  beginsS(line: number): number | undefined {
    return this.motion.timeOf(line + this.before);
  }

  /** When the last line before this one that moves the machine has done so: the next one that moves it begins, s of the motion. */
  endsS(line: number): number {
    return this.motion.timeBehind(line + this.before) ?? this.motion.end;
  }

  /** Whether an axis has no end, as a rotary one may. */
  isEndless(axis: number): boolean {
    return Number(this.settings.get(TRAVEL + axis)) === 0;
  }

  private take(motion: Columns[], { lines, answeredAtS, beganS, totalS, placeMm, said }: Extract<FromWorker, { is: "planned" }>): void {
    for (const columns of motion) this.motion.add(columns);
    this.motion.addLines(lines);
    this.motion.beginAt(beganS);
    [this.placeMm, this.said] = [placeMm, said];
    [this.answeredAtS, this.beganS, this.totalS] = [answeredAtS, beganS, totalS - beganS];
    this.look();
  }

  /** Looks at the whole once: the page asks with every report. */
  private look(): void {
    const { motion } = this;
    const beyond = new Map<number, Beyond>();
    for (let row = 0; row < motion.length; row++) {
      const phase = motion.read(row);
      if (phase.isHoming) continue;
      for (let axis = 0; axis < phase.axes; axis++) for (const after of [0, phase.span]) this.see(axis, phase.place(axis, after), phase.from, beyond);
    }
    this.beyond = [...beyond.values()];
  }

  private see(axis: number, placeMm: number, timeS: number, beyond: Map<number, Beyond>): void {
    const [low, high] = this.extents[axis] ?? [placeMm, placeMm];
    this.extents[axis] = [Math.min(low, placeMm), Math.max(high, placeMm)];
    const travelMm = Number(this.settings.get(TRAVEL + axis));
    const past = (mm: number): number => Math.max(-mm, mm - travelMm);
    if (!travelMm || past(placeMm) <= ROUNDED_MM) return;
    const before = beyond.get(axis);
    const line = before?.line ?? this.motion.lineAt(timeS) - this.before;
    if (!before || past(placeMm) > past(before.placeMm)) beyond.set(axis, { axis: AXIS_NAMES[axis] ?? "", placeMm, travelMm, unit: unitOf(axis, this.motion.isRotary), line });
  }

  private placed(line: number | null, words: string): string {
    const number = line === null ? 0 : line - this.before;
    return number > 0 ? `line ${number}: ${words.replace(/^line \d+: /, "")}` : words;
  }
}
