// How long a program still takes: the same program runs in virtual time, with the settings of the machine.

import { worker } from "../job";
import type { FromWorker, ToolRow, ToWorker } from "../messages";

/** A program is run from wherever the machine stands, so the ends of its travel are not looked at, and a change of the tool takes no time. */
const WITHOUT_ENDS = "$20=0\n$21=0\n$341=0\n";

export class Estimate {
  private readonly worker = worker();
  /** When each line is answered, and when all is over, s. */
  private run: { answeredAtS: Float64Array; totalS: number } | undefined;

  /** Which tools the program asks for, and what it says of them. */
  private tools: ToolRow[] = [];

  constructor(program: string, settings: ReadonlyMap<number, string>) {
    this.worker.onmessage = ({ data }: MessageEvent<FromWorker>) => {
      if (data.is === "tools") return void (this.tools = data.tools);
      if (data.is === "estimated") this.run = data;
      this.end();
    };
    this.worker.onerror = () => this.end();
    const lines = [...settings].map(([number, value]) => `$${number}=${value}\n`).join("");
    this.worker.postMessage({
      do: "estimate",
      program: new TextEncoder().encode(program),
      settings: lines + WITHOUT_ENDS,
    } satisfies ToWorker);
  }

  end(): void {
    this.worker.terminate();
  }

  /** What the program says of the tool that this line asks for. */
  comment(line: number, tool: number): string | undefined {
    return this.tools.find((row) => row.line === line && row.tool === tool)?.comment ?? undefined;
  }

  /** What is left and all, s, this long after the answer to this line; undefined while that is not known. */
  at(line: number, sinceS: number): { leftS: number; totalS: number } | undefined {
    if (!this.run) return undefined;
    const { answeredAtS, totalS } = this.run;
    const [from, to] = [answeredAtS[line - 1] ?? 0, answeredAtS[line] ?? totalS];
    return { leftS: Math.max(0, totalS - Math.min(from + sinceS, to)), totalS };
  }
}
