// The program of the page, sent to the machine: no more bytes than it takes, and none after a refusal.

import { button, element } from "../elements";
import type { Machine } from "./machine";

/** Lines ahead of what fits, so that the flight is always full. */
const AHEAD = 16;

interface Job {
  lines: string[];
  next: number;
  answered: number;
}

export class Sending {
  private job: Job | undefined;

  constructor(
    private readonly machine: Machine,
    program: () => string,
  ) {
    button("send-program").onclick = () => this.start(program());
    button("stop-program").onclick = () => this.stop();
    machine.watch({
      began: () => this.end(),
      alarmed: (words) => words && this.end(),
      reported: ({ state }) => (button("send-program").disabled = state !== "Idle" || this.job !== undefined),
    });
  }

  private start(program: string): void {
    const lines = program.split(/\r\n|\r|\n/).map((line) => line.replace(/;.*|\([^)]*\)/g, "").trim());
    this.job = { lines, next: 0, answered: 0 };
    this.machine.log(`the program, ${lines.length} lines`, "sent");
    this.more(this.job);
  }

  private more(job: Job): void {
    while (this.job === job && job.next < job.lines.length && this.machine.underWay < AHEAD) this.send(job);
    if (this.job === job && job.answered >= job.lines.length) {
      this.job = undefined;
      this.machine.log("all lines are answered", "note");
    }
    this.show();
  }

  private send(job: Job): void {
    const number = ++job.next;
    const line = job.lines[number - 1] ?? "";
    if (/[?!~]/.test(line)) {
      this.machine.log(`line ${number}: \`${line}\` has a real-time command: take it out of the program`, "wrong");
      return this.stop();
    }
    this.machine.ask(line, (answer) => {
      job.answered++;
      if (answer !== "ok" && this.job === job) {
        this.machine.log(`line ${number} \`${line}\`: ${answer}`, "wrong");
        this.stop();
      }
      this.more(job);
    });
  }

  /** Sends no more; what was sent is made. */
  private stop(): void {
    this.machine.forgetWaiting();
    this.end();
  }

  private end(): void {
    this.job = undefined;
    this.show();
  }

  private show(): void {
    const bar = element("sent", HTMLProgressElement);
    bar.hidden = button("stop-program").hidden = !this.job;
    if (this.job) bar.value = this.job.answered / Math.max(1, this.job.lines.length);
  }
}
