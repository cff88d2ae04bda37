// A program that runs in a worker of its own, which ends with it.

import { select } from "./elements";
import type { Columns, FromWorker, Kept, LineTimes, Summary, ToWorker, Trouble } from "./messages";

export interface Watcher {
  progress(answered: number, lines: number, seconds: number): void;
  motion(pieces: Columns[]): void;
  rows(rows: Uint8Array): void;
  lines(lineTimes: LineTimes): void;
  ended(summary: Summary, wallSeconds: number): void;
  trouble(trouble: Trouble): void;
}

/** A worker with a machine of so many axes, by its name; if nobody says, as many as are chosen beside the program. */
export function worker(axes = chosenAxes()): Worker {
  return new Worker(new URL("worker.js", import.meta.url), { type: "module", name: `${axes} axes` });
}

/** How many axes the simulated machine has. */
export const chosenAxes = (): number => Number(select("axes").value);

/** One thing at a time, done by a worker. What is asked next ends it. */
export class Task {
  private worker: Worker | undefined;

  /** Asks a new worker, with a machine of so many axes or of as many as are chosen. `hear` says whether that was all. */
  ask(message: ToWorker, hear: (said: FromWorker) => boolean, failed: (trouble: Trouble) => void, axes?: number): void {
    this.cancel();
    const machine = worker(axes);
    this.worker = machine;
    machine.onmessage = ({ data }: MessageEvent<FromWorker>) => {
      if (data.is === "trouble") {
        this.cancel();
        failed(data.trouble);
      } else if (hear(data) && this.worker === machine) this.cancel();
    };
    machine.onerror = (event) => {
      this.cancel();
      failed({ line: null, words: `the machine did not start: ${event.message || "is the page complete?"}` });
    };
    // What is sent goes there for good, so that it is not held twice.
    machine.postMessage(message, "program" in message ? [message.program.buffer] : []);
  }

  /** Ends the worker, whatever it does. */
  cancel(): void {
    this.worker?.terminate();
    this.worker = undefined;
  }
}

export const bytes = (text: string): Uint8Array => new TextEncoder().encode(text);

/** Runs a program, of which something is kept. */
export function run(task: Task, program: Uint8Array, settings: string, kept: Kept, watcher: Watcher): void {
  const hear = (said: FromWorker): boolean => {
    if (said.is !== "progress" && said.is !== "ended") return false;
    watcher.motion(said.motion);
    watcher.rows(said.rows);
    watcher.lines(said.lineTimes);
    if (said.is === "progress") watcher.progress(said.answered, said.lines, said.seconds);
    else watcher.ended(said.summary, said.wallSeconds);
    return said.is === "ended";
  };
  task.ask({ do: "run", program, settings, kept }, hear, watcher.trouble);
}
