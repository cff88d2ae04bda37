// A program that this page sends: no more bytes than the machine takes, and none after a refusal. It ends with the page.

import type { Status } from "./dialect";
import { FORGOTTEN } from "./flight";
import type { Machine } from "./machine";
import { linesOf, realTime, type ProgramLine } from "./program";
import type { Begun, Progress, Sender, SenderWatcher } from "./sender";
import { stop } from "./stop";

/** Lines ahead of what fits, so that the flight is always full. */
const AHEAD = 16;

/** The machine is locked: by an alarm, which it tells a moment later, or by a jog. */
const LOCKED = "error:9";

interface Job {
  lines: ProgramLine[];
  next: number;
  answered: number;
  /** The line that was refused because the machine is locked. */
  locked?: ProgramLine;
}

export class PageSender implements Sender {
  private job: Job | undefined;
  /** The line that was refused, and how, until the machine has said why. */
  private refused: { line: ProgramLine; answer: string } | undefined;

  constructor(
    private readonly machine: Machine,
    private readonly watcher: SenderWatcher,
  ) {
    machine.watch({
      began: () => this.begin(),
      alarmed: (words) => words && this.lock(),
      linked: (link) => link === "lost" && this.leave(),
      reported: (report) => this.look(report),
    });
  }

  get progress(): Progress | undefined {
    return this.job && this.of(this.job);
  }

  start(begun: Begun): void {
    const lines = linesOf(begun.text, begun.made);
    const acts = realTime(lines);
    if (acts) return this.watcher.ended(`Line ${acts.number} \`${acts.text}\` has a byte that the machine would obey at once (?, !, ~, or a letter beyond ASCII): take it out, or put it into a comment.`);
    if (!lines.length) return this.watcher.ended("The program is empty.");
    this.job = { lines, next: 0, answered: 0 };
    this.watcher.began(this.of(this.job));
    this.watcher.knows(begun);
    this.more(this.job);
  }

  private of({ lines, answered }: Job): Progress {
    return { lines: lines.length, answered, last: lines[answered - 1]?.number ?? 0, next: lines[answered]?.number, end: lines.at(-1)?.number ?? 0 };
  }

  private more(job: Job): void {
    while (this.job === job && !job.locked && job.next < job.lines.length && this.machine.underWay < AHEAD) this.send(job);
  }

  private send(job: Job): void {
    const line = job.lines[job.next++];
    if (!line) return;
    this.machine.askOfProgram(line.sent, (answer) => {
      if (this.job !== job || job.locked || answer === FORGOTTEN) return;
      if (answer === LOCKED) return void (job.locked = line);
      job.answered++;
      if (answer !== "ok") return this.refuse(line, answer);
      this.more(job);
    });
  }

  /** Lines behind the refused one are on their way already, and make no sense without it: the machine forgets them. */
  private refuse(line: ProgramLine, answer: string): void {
    this.refused = { line, answer };
    this.end(`Stopped: line ${line.number} \`${line.text}\` was refused with ${answer}.`);
    stop(this.machine);
  }

  private lock(): void {
    if (!this.job) return;
    this.end("Stopped by an alarm.");
    this.machine.forgetWaiting();
  }

  private leave(): void {
    const { job } = this;
    if (!job) return;
    const { next, end } = this.of(job);
    this.end(`The link was lost before line ${next ?? end} was answered: the machine may have gone on with what it had.`);
  }

  private begin(): void {
    this.end("Stopped: the machine has forgotten what it had not made.");
    const { refused } = this;
    if (!refused) return;
    this.refused = undefined;
    const { number, text } = refused.line;
    this.machine.explain(refused.answer, (words) => this.watcher.ended(`Stopped: line ${number} \`${text}\` was refused. ${words}`));
  }

  private look({ state }: Status): void {
    const { job } = this;
    if (job?.locked && state === "Alarm") return this.lock();
    if (job?.locked) return this.refuse(job.locked, LOCKED);
    if (job && job.answered === job.lines.length && ["Idle", "Check"].includes(state)) this.end(`Done: ${job.lines.length} lines.`);
  }

  private end(words: string): void {
    if (!this.job) return;
    this.job = undefined;
    this.watcher.ended(words);
  }
}
