// The program that is sent to the machine, as a person sees it: how far it is, how long it still takes, and why it has ended.

import { button, duration, element, part } from "../elements";
import type { Change } from "./change";
import { nameOf, type Status } from "./dialect";
import type { Fits } from "./fits";
import type { LivePicture } from "./live";
import type { Machine } from "./machine";
import type { NamedProgram } from "./operate";
import { PageSender } from "./page-sender";
import { madeAt } from "./progress";
import type { Begun, Progress, Sender, SenderWatcher } from "./sender";
import { ServerSender } from "./server-sender";
import { stop } from "./stop";

const UNSEEN = "Where it would go is being worked out. Press again to send it unseen.";

export class Sending implements SenderWatcher {
  private readonly byPage: Sender;
  private readonly byServer: Sender;
  /** How much of the plan is made, s of its motion; undefined before the program is known. */
  private madeS: number | undefined;
  /** Somebody has pressed Send, and the plan is not known yet. */
  private isAsked = false;

  constructor(
    private readonly machine: Machine,
    private readonly program: () => NamedProgram,
    private readonly change: Change,
    private readonly live: LivePicture,
    private readonly fits: Fits,
  ) {
    this.byPage = new PageSender(machine, this);
    this.byServer = new ServerSender(machine, this);
    button("send-program").onclick = () => void this.ask();
    live.watch(() => this.enable());
    button("stop-program").onclick = () => stop(machine);
    machine.watch({
      reported: (report) => this.follow(report),
      attached: () => (this.isAsked = false),
    });
  }

  began(progress: Progress): void {
    const { sender, live } = this;
    this.change.program = {
      get line() {
        return sender.progress?.next;
      },
      comment: (line, tool) => live.plan?.comment(line, tool),
    };
    this.machine.log(`the program, ${progress.lines} lines`, "sent");
    this.show();
  }

  knows({ text, before }: Begun): void {
    this.live.adopt(text, before);
    this.madeS = 0;
  }

  ended(words: string): void {
    this.madeS = undefined;
    this.change.program = undefined;
    this.live.made(Infinity);
    this.live.replan();
    this.say(words);
    this.show();
  }

  private get sender(): Sender {
    return this.machine.jobs ? this.byServer : this.byPage;
  }

  private get progress(): Progress | undefined {
    return this.sender.progress;
  }

  /** Sends it once it is known that it fits, or at the second press. */
  private async ask(): Promise<void> {
    // A second press may come before the next report.
    if (this.progress) return;
    if (this.isAsked) return this.start();
    this.isAsked = true;
    const told = setTimeout(() => this.say(UNSEEN), 500);
    await this.live.known();
    clearTimeout(told);
    if (this.isAsked) this.start();
  }

  private start(): void {
    this.isAsked = false;
    if (this.progress) return;
    if (this.fits.refusal) return this.say("Not sent.");
    const program = this.program();
    this.sender.start({ ...program, before: this.live.before, made: this.live.planOf(program.text)?.made });
  }

  private enable(): void {
    button("send-program").disabled = !["Idle", "Check"].includes(this.machine.state) || this.progress !== undefined || this.fits.refusal !== "";
  }

  private follow(report: Status): void {
    const { progress } = this;
    this.enable();
    if (!progress) return;
    this.note(progress, report);
    this.show(report);
  }

  /** Where the machine is along the plan. Without a line in its reports it is anywhere up to the line that is answered next. */
  private note({ next, end }: Progress, { line, machinePosition }: Status): void {
    const { plan } = this.live;
    if (this.madeS === undefined || plan?.totalS === undefined) return;
    this.madeS = madeAt(plan, { from: line, to: line ?? next ?? end }, this.machine.inMm(machinePosition), Math.max(this.madeS, plan.atS(0)));
    this.live.made(this.madeS);
  }

  private say(words: string): void {
    part("sending-now").textContent = words;
  }

  private show(report?: Status): void {
    const { progress } = this;
    const bar = element("sent", HTMLProgressElement);
    bar.hidden = button("stop-program").hidden = !progress;
    if (!progress) return;
    const [leftS, totalS] = [this.leftS, this.live.plan?.totalS];
    bar.value = leftS === undefined || !totalS ? progress.answered / progress.lines : 1 - leftS / totalS;
    const waits = this.change.words || this.waits(progress, report);
    this.say([waits || this.where(progress, report), leftS === undefined ? "" : this.left(leftS)].filter(Boolean).join(", "));
  }

  private get leftS(): number | undefined {
    const { plan } = this.live;
    if (plan?.totalS === undefined || this.madeS === undefined) return undefined;
    return Math.max(0, plan.totalS - plan.goneS(Math.max(this.madeS, plan.atS(0))));
  }

  /** The program waits for a person by M0 or M1: with what it says there. */
  private waits({ next }: Progress, report?: Status): string {
    if (!report || nameOf(report.state) !== "Hold" || next === undefined) return "";
    const lines = (this.live.program ?? "").split(/\r\r\n|\r\n|\r|\n/);
    const text = lines[next - 1] ?? "";
    if (!/\bM0*[01]\b/i.test(text.replace(/\([^)]*\)|;.*/g, ""))) return "";
    const comment = [text, lines[next - 2] ?? ""].map((each) => (/\(([^)]+)\)|;\s*(.+)/.exec(each) ?? []).slice(1).find(Boolean)).find(Boolean);
    return `The program waits in line ${next}${comment ? `: ${comment.replace(/^MSG,?\s*/i, "")}` : ""}. Resume goes on`;
  }

  private where({ lines, answered, end }: Progress, report?: Status): string {
    return report?.line === undefined ? `${answered} of ${lines} lines answered` : `line ${report.line} of ${end} is under way`;
  }

  private left(leftS: number): string {
    const [feed = 100, rapids = 100] = this.machine.report.overrides;
    return `about ${duration(Math.round(leftS)).replace(".000", "")} left${feed === 100 && rapids === 100 ? "" : " at overrides of 100 %"}`;
  }
}
