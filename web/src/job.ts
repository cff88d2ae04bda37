// A program that runs in a worker of its own, which ends with it.

import type { Columns, FromWorker, Summary, ToWorker, Trouble } from "./messages";

export interface Watcher {
  progress(answered: number, lines: number, seconds: number): void;
  motion(columns: Columns): void;
  trace(rows: Uint8Array): void;
  ended(summary: Summary, wallSeconds: number): void;
  trouble(trouble: Trouble): void;
}

export function worker(): Worker {
  return new Worker(new URL("worker.js", document.baseURI), { type: "module" });
}

export class JobRunner {
  private worker: Worker | undefined;

  run(program: string, settings: string, withTrace: boolean, watcher: Watcher): void {
    this.cancel();
    const machine = worker();
    this.worker = machine;
    machine.onmessage = ({ data }: MessageEvent<FromWorker>) => {
      switch (data.is) {
        case "progress":
          watcher.motion(data.motion);
          watcher.trace(data.trace);
          watcher.progress(data.answered, data.lines, data.seconds);
          break;
        case "ended":
          watcher.motion(data.motion);
          watcher.trace(data.trace);
          this.cancel();
          watcher.ended(data.summary, data.wallSeconds);
          break;
        case "trouble":
          this.cancel();
          watcher.trouble(data.trouble);
      }
    };
    machine.onerror = (event) => {
      this.cancel();
      watcher.trouble({ line: null, words: `the machine did not start: ${event.message || "is the page complete?"}` });
    };
    const bytes = new TextEncoder().encode(program);
    machine.postMessage({ do: "run", program: bytes, settings, withTrace } satisfies ToWorker);
  }

  get isRunning(): boolean {
    return this.worker !== undefined;
  }

  /** Ends the machine, whatever it does. */
  cancel(): void {
    this.worker?.terminate();
    this.worker = undefined;
  }
}
