// A program that is begun at a line: what the lines before it leave is found by running them in virtual time.

import { input, part } from "../elements";
import { MM_PER_INCH } from "./dialect";
import type { Machine } from "./machine";
import type { NamedProgram } from "./operate";
import { Plan } from "./plan";
import { restFrom, whyNotAfter, whyNotFrom, type Left } from "./rest";
import { linesOfStart, readStart } from "./start";

const Z = 2;
/** A number that is being typed is looked at when it has been left alone for so long, ms. */
const CALM_MS = 300;
const WAITS = "The lines before are run in virtual time.";

export class FromLine {
  private rest: { of: string; line: number; text: string } | undefined;
  private plan: Plan | undefined;
  private timer: number | undefined;
  /** What is found for a line that was typed before is of no use. */
  private looks = 0;
  /** Why there is nothing to send; empty if there is. */
  refusal = "";

  /** `changed` hears that there is another program to send. */
  constructor(
    private readonly machine: Machine,
    private readonly whole: () => NamedProgram,
    private readonly changed: () => void,
  ) {
    input("from-line").oninput = () => {
      clearTimeout(this.timer);
      // Nothing is sent before it is known from where: the whole program would go.
      this.take("", WAITS);
      this.timer = window.setTimeout(() => this.look(), CALM_MS);
    };
  }

  /** What is to be sent: the whole, or from the chosen line on. */
  get program(): NamedProgram {
    const { name, text } = this.whole();
    const { rest } = this;
    return rest?.of === text ? { name: `${name} from line ${rest.line}`, text: rest.text } : { name, text };
  }

  /** The page may have another program: that goes from its beginning. */
  refresh(): void {
    if (!this.rest || this.rest.of === this.whole().text) return;
    input("from-line").value = "1";
    this.take("");
  }

  private look(): void {
    const { text } = this.whole();
    const [lines, line] = [text.split(/\r\r\n|\r\n|\r|\n/), Number(input("from-line").value)];
    if (line === 1) return this.take("");
    const why = whyNotFrom(lines, line) || (this.machine.state === "Idle" ? "" : "The machine must be Idle for that.");
    if (why) return this.take("", why);
    // Offsets are listed at rest only.
    const head = `${lines.slice(0, line - 1).join("\n")}\nG4 P0\n$G\n$#\n`;
    const mine = this.looks;
    readStart(this.machine, (start) => {
      if (mine !== this.looks) return;
      if (!start) return this.take("", "The machine does not say from where it starts: type the line again.");
      const plan = new Plan(head, this.machine.settings, linesOfStart(start), () => mine === this.looks && this.begin(text, lines, line, plan));
      this.plan = plan;
    });
  }

  private begin(text: string, lines: string[], line: number, plan: Plan): void {
    if (plan.trouble) return this.take("", `What the lines before leave is not known: ${plan.trouble}`);
    const left = this.left(plan);
    const why = whyNotAfter(lines, line, left);
    if (why) return this.take("", why);
    const rest = restFrom(lines, line, left);
    this.rest = { of: text, line, text: rest.text };
    this.refusal = "";
    part("from-what").textContent = rest.words;
    this.changed();
  }

  private left(plan: Plan): Left {
    const said = (name: string): string => plan.said.filter((text) => text.startsWith(`[${name}:`)).at(-1)?.slice(name.length + 2, -1) ?? "";
    const { isInches, report } = this.machine;
    const unit = isInches ? MM_PER_INCH : 1;
    const highestMm = Math.max((report.machinePosition[Z] ?? 0) * unit, plan.extents[Z]?.[1] ?? -Infinity, plan.placeMm[Z] ?? 0);
    return { modes: said("GC").split(" "), length: Number(said("TLO")), placeMm: plan.placeMm, highestMm, isInches };
  }

  private take(words: string, refusal = ""): void {
    this.looks++;
    this.plan?.end();
    this.rest = undefined;
    this.refusal = refusal;
    part("from-what").textContent = words || refusal;
    this.changed();
  }
}
