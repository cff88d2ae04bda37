// The program that is sent to the machine, as a person sees it: how far it is, how long it still takes, and why it has ended.

import { button, duration, element, part } from "../elements";
import type { Change } from "./change";
import { nameOf, type Status } from "./dialect";
import { Estimate } from "./estimate";
import type { Machine } from "./machine";
import type { NamedProgram } from "./operate";
import { PageSender } from "./page-sender";
import type { Progress, Sender, SenderWatcher } from "./sender";
import { ServerSender } from "./server-sender";
import { stop } from "./stop";

export class Sending implements SenderWatcher {
  private readonly byPage: Sender;
  private readonly byServer: Sender;
  private estimate: Estimate | undefined;
  /** How long the machine has moved since the last answer, and when that was looked at. */
  private sinceMs = 0;
  private lookedAt = 0;

  constructor(
    private readonly machine: Machine,
    program: () => NamedProgram,
    private readonly change: Change,
  ) {
    this.byPage = new PageSender(machine, this);
    this.byServer = new ServerSender(machine, this);
    // A second press may come before the next report.
    button("send-program").onclick = () => this.progress || this.sender.start(program());
    button("stop-program").onclick = () => stop(machine);
    machine.watch({ reported: (report) => this.follow(report) });
  }

  began(progress: Progress): void {
    this.sinceMs = 0;
    this.lookedAt = performance.now();
    const { sender } = this;
    this.change.program = {
      get line() {
        return sender.progress?.next;
      },
      comment: (line, tool) => this.estimate?.comment(line, tool),
    };
    this.machine.log(`the program, ${progress.lines} lines`, "sent");
    this.show();
  }

  knows(text: string): void {
    this.estimate?.end();
    this.estimate = new Estimate(text, this.machine.settings);
  }

  went(): void {
    this.sinceMs = 0;
  }

  ended(words: string): void {
    this.estimate?.end();
    this.estimate = undefined;
    this.change.program = undefined;
    this.say(words);
    this.show();
  }

  private get sender(): Sender {
    return this.machine.jobs ? this.byServer : this.byPage;
  }

  private get progress(): Progress | undefined {
    return this.sender.progress;
  }

  private follow(report: Status): void {
    button("send-program").disabled = !["Idle", "Check"].includes(report.state) || this.progress !== undefined;
    const now = performance.now();
    if (nameOf(report.state) === "Run") this.sinceMs += now - this.lookedAt;
    this.lookedAt = now;
    if (this.progress) this.show(report);
  }

  private say(words: string): void {
    part("sending-now").textContent = words;
  }

  private show(report?: Status): void {
    const { progress } = this;
    const bar = element("sent", HTMLProgressElement);
    bar.hidden = button("stop-program").hidden = !progress;
    if (!progress) return;
    const time = this.estimate?.at(progress.last, this.sinceMs * 1e-3);
    bar.value = time ? 1 - time.leftS / time.totalS : progress.answered / progress.lines;
    this.say([this.change.words || this.where(progress, report), time ? this.left(time.leftS) : ""].filter(Boolean).join(", "));
  }

  private where({ lines, answered, end }: Progress, report?: Status): string {
    return report?.line === undefined ? `${answered} of ${lines} lines answered` : `line ${report.line} of ${end} is under way`;
  }

  private left(leftS: number): string {
    const [feed = 100, rapids = 100] = this.machine.report.overrides;
    return `about ${duration(Math.round(leftS)).replace(".000", "")} left${feed === 100 && rapids === 100 ? "" : " at overrides of 100 %"}`;
  }
}
