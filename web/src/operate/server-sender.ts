// A program that the page's server sends. It goes on without the page, which shows what the server tells.

import type { Machine } from "./machine";
import type { Begun, Progress, Sender, SenderWatcher } from "./sender";

/** A job, as the server tells it. */
export interface ServersJob {
  name: string;
  lines: number;
  answered: number;
  last: number;
  line: number | null;
  end: number;
  state: "sending" | "waiting" | "done" | "stopped";
  words: string;
}

/** A port whose other end holds jobs. */
export interface JobHolder {
  /** The last job, which may have ended. */
  readonly job: ServersJob | undefined;
  onJob: ((job: ServersJob) => void) | undefined;
  /** A program is not sent, and why. */
  onRefused: ((why: string) => void) | undefined;
  start(program: Begun): void;
  /** The program of the job. */
  program(): Promise<Begun>;
}

export class ServerSender implements Sender {
  progress: Progress | undefined;
  private name = "";

  constructor(
    private readonly machine: Machine,
    private readonly watcher: SenderWatcher,
  ) {
    machine.watch({ attached: () => this.attach() });
  }

  start(program: Begun): void {
    this.machine.jobs?.start(program);
  }

  private attach(): void {
    const { jobs } = this.machine;
    if (this.progress) this.end(`The server goes on with ${this.name}, as long as it runs: connect again to see how it is.`);
    if (!jobs) return;
    jobs.onJob = (job) => this.hear(job, jobs);
    // Another page may have begun one meanwhile.
    jobs.onRefused = (why) => (this.progress ? this.machine.log(why, "wrong") : this.watcher.ended(`Not sent: ${why}.`));
  }

  private hear({ name, lines, answered, last, line, end, state, words }: ServersJob, holder: JobHolder): void {
    this.name = name;
    if (state === "done" || state === "stopped") return this.end(`${name}: ${words}`);
    const before = this.progress;
    this.progress = { lines, answered, last, next: line ?? undefined, end };
    if (before) return;
    this.watcher.began(this.progress);
    void holder.program().then((begun) => this.progress && this.watcher.knows(begun));
  }

  private end(words: string): void {
    this.progress = undefined;
    this.watcher.ended(words);
  }
}
