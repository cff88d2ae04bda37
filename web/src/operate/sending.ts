// The program of the page, sent to the machine: no more bytes than it takes, and none after a refusal.

import { button, duration, element, part } from "../elements";
import type { Change, SentProgram } from "./change";
import type { Status } from "./dialect";
import { inMm } from "./start";
import type { Fits } from "./fits";
import { FORGOTTEN } from "./flight";
import type { LivePicture } from "./live";
import type { Machine } from "./machine";
import type { Plan } from "./plan";
import { linesOf, realTime, type ProgramLine } from "./program";
import { madeAt } from "./progress";
import { stop } from "./stop";

/** Lines ahead of what fits, so that the flight is always full. */
const AHEAD = 16;

interface Job {
  lines: ProgramLine[];
  next: number;
  answered: number;
  /** What the machine was expected to do when it began. */
  plan: Plan | undefined;
  /** How much of that is made, s of its motion. */
  madeS: number;
}

export class Sending {
  private job: Job | undefined;
  /** The line that was refused, and how, until the machine has said why. */
  private refused: { line: ProgramLine; answer: string } | undefined;

  constructor(
    private readonly machine: Machine,
    program: () => string,
    private readonly change: Change,
    private readonly live: LivePicture,
    private readonly fits: Fits,
  ) {
    button("send-program").onclick = () => this.start(program());
    button("stop-program").onclick = () => stop(machine);
    machine.watch({
      began: () => this.begin(),
      alarmed: (words) => words && this.lock(),
      linked: (link) => link === "lost" && this.leave(),
      reported: (report) => this.follow(report),
    });
  }

  private start(program: string): void {
    // A second press may come before the next report.
    if (this.job) return;
    const lines = linesOf(program);
    const acts = realTime(lines);
    if (acts) return this.say(`Line ${acts.number} \`${acts.text}\` has a byte that the machine would obey at once (?, !, ~, or a letter beyond ASCII): take it out, or put it into a comment.`);
    if (!lines.length) return this.say("The program is empty.");
    if (this.fits.refusal) return this.say("Not sent: it does not fit.");
    const { plan } = this.live;
    this.job = { lines, next: 0, answered: 0, plan, madeS: plan?.atS(0) ?? 0 };
    this.change.program = this.told(this.job);
    this.machine.log(`the program, ${lines.length} lines`, "sent");
    this.more(this.job);
    this.show();
  }

  /** What a change of the tool has to know of it. */
  private told(job: Job): SentProgram {
    return {
      get line() {
        return job.lines[job.answered]?.number;
      },
      comment: (line, tool) => job.plan?.comment(line, tool),
    };
  }

  private more(job: Job): void {
    while (this.job === job && job.next < job.lines.length && this.machine.underWay < AHEAD) this.send(job);
  }

  private send(job: Job): void {
    const line = job.lines[job.next++];
    if (!line) return;
    this.machine.askOfProgram(line.sent, (answer) => {
      if (this.job !== job || answer === FORGOTTEN) return;
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
    const line = job.lines[job.answered]?.number ?? job.lines.at(-1)?.number;
    this.end(`The link was lost before line ${line} was answered: the machine may have gone on with what it had.`);
  }

  private begin(): void {
    this.end("Stopped: the machine has forgotten what it had not made.");
    const { refused } = this;
    if (!refused) return;
    this.refused = undefined;
    const { number, text } = refused.line;
    this.machine.explain(refused.answer, (words) => this.say(`Stopped: line ${number} \`${text}\` was refused. ${words}`));
  }

  private follow(report: Status): void {
    button("send-program").disabled = !["Idle", "Check"].includes(report.state) || this.job !== undefined || this.fits.refusal !== "";
    const { job } = this;
    if (!job) return;
    this.note(job, report);
    const isOver = job.answered === job.lines.length && ["Idle", "Check"].includes(report.state);
    if (isOver) this.end(`Done: ${job.lines.length} lines.`);
    else this.show(report);
  }

  /** Where the machine is along the plan. Without a line in its reports it is anywhere up to the line that is answered next. */
  private note(job: Job, { line, machinePosition }: Status): void {
    const answered = job.lines[job.answered]?.number ?? job.lines.at(-1)?.number ?? 0;
    if (job.plan?.totalS !== undefined) job.madeS = madeAt(job.plan, { from: line, to: line ?? answered }, inMm(machinePosition, this.machine.isInches), job.madeS);
    this.live.made(job.madeS);
  }

  private end(words: string): void {
    if (!this.job) return;
    this.job = undefined;
    this.live.made(Infinity);
    this.live.replan();
    this.change.program = undefined;
    this.say(words);
    this.show();
  }

  private say(words: string): void {
    part("sending-now").textContent = words;
  }

  private show(report?: Status): void {
    const { job } = this;
    const bar = element("sent", HTMLProgressElement);
    bar.hidden = button("stop-program").hidden = !job;
    if (!job) return;
    const totalS = job.plan?.totalS;
    const leftS = job.plan && totalS !== undefined ? Math.max(0, totalS - job.plan.goneS(job.madeS)) : undefined;
    bar.value = leftS === undefined || !totalS ? job.answered / job.lines.length : 1 - leftS / totalS;
    this.say([this.change.words || this.where(job, report), leftS === undefined ? "" : this.left(leftS)].filter(Boolean).join(", "));
  }

  private where(job: Job, report?: Status): string {
    const last = job.lines.at(-1)?.number;
    return report?.line === undefined ? `${job.answered} of ${job.lines.length} lines answered` : `line ${report.line} of ${last} is under way`;
  }

  private left(leftS: number): string {
    const [feed = 100, rapids = 100] = this.machine.report.overrides;
    return `about ${duration(Math.round(leftS)).replace(".000", "")} left${feed === 100 && rapids === 100 ? "" : " at overrides of 100 %"}`;
  }
}
