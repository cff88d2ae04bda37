// The picture of the machine that is operated: as far as it can go, the program's path where it would be made, and the tool where the machine
// reports it. What is made already stands out.

import { AXES } from "../axes";
import { part } from "../elements";
import { Motion } from "../motion";
import type { Picture } from "../picture/picture";
import { nameOf, setting, type Status } from "./dialect";
import type { Machine } from "./machine";
import { Plan } from "./plan";
import { linesOfStart, readStart } from "./start";

/** Where the travel of the first axis stands. */
const TRAVEL = 130;
/** A program that is being typed, and a machine that is being set up, is planned when it has been left alone for so long, ms. */
const CALM_MS = 400;
/** The picture goes on evenly between two reports, ms. */
const BETWEEN_MS = 220;

interface Planned {
  program: string;
  /** Lines that make a machine so as this one is. */
  before: string[];
  settings: ReadonlyMap<number, string>;
  plan: Plan;
  isKnown: boolean;
}

export class LivePicture {
  /** Until when the plan is made, s of its motion; Infinity while no program goes. */
  private madeS = Infinity;
  private planned: Planned | undefined;
  private isLooked = false;
  private timer: number | undefined;
  private drawn: { made: number; tool: number[] } | undefined;
  private from: { made: number; tool: number[]; atMs: number } | undefined;
  private isDrawing = false;
  private readonly watchers: (() => void)[] = [];
  /** Who waits until the plan is known. */
  private readonly waiting: (() => void)[] = [];

  constructor(
    private readonly machine: Machine,
    private readonly picture: Picture,
    private readonly ofPage: () => string,
  ) {
    machine.watch({
      attached: () => this.forget(),
      set: () => this.replan(),
      reported: (report, before) => this.follow(report, before),
    });
  }

  /** What the machine would do with the program that was planned last, if that is known. */
  get plan(): Plan | undefined {
    return this.planned?.isKnown ? this.planned.plan : undefined;
  }

  /** The same, if it is of this program. */
  planOf(program: string): Plan | undefined {
    return this.planned?.program === program ? this.plan : undefined;
  }

  /** Tells when the plan is another. */
  watch(changed: () => void): void {
    this.watchers.push(changed);
  }

  /** The machine is looked at, or is no more. */
  look(isLooked: boolean): void {
    this.isLooked = isLooked;
    if (!isLooked) return;
    void this.show();
    this.replan();
  }

  /** A program goes: it is made until this time of the plan's motion, s; Infinity when none goes. */
  made(madeS: number): void {
    this.madeS = madeS;
    this.draw();
  }

  /** Plans anew, once nothing has changed for a while. */
  replan(): void {
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => this.ask(), CALM_MS);
  }

  /** Waits until it is known what the machine would do with the page's program from where it is, or that it cannot be known. */
  known(): Promise<void> {
    return new Promise((resolve) => {
      this.waiting.push(resolve);
      this.ask();
    });
  }

  /** The program that is planned. */
  get program(): string | undefined {
    return this.planned?.program;
  }

  /** From what the plan goes out: the machine's settings as lines of `$n=v`, and then the lines that make it such as it is. */
  get before(): string[] {
    const { planned } = this;
    return planned ? [...[...planned.settings].map(([number, value]) => `$${number}=${value}`), ...planned.before] : [];
  }

  /** A program goes that began so, whichever the page has: it is in the picture until it has ended. */
  adopt(program: string, before: string[]): void {
    if (this.planned?.program !== program || this.before.join() !== before.join()) {
      const settings = before.map(setting).filter((each) => each !== undefined);
      this.begin(program, before.filter((line) => !line.startsWith("$")), new Map(settings));
    }
    this.made(this.plan?.atS(0) ?? 0);
    void this.show();
  }

  private get mayPlan(): boolean {
    return this.isLooked && this.machine.state === "Idle" && this.machine.settings.size > 0 && this.madeS === Infinity;
  }

  private ask(): void {
    if (!this.mayPlan) return this.release();
    const program = this.ofPage();
    readStart(this.machine, (start) => {
      if (!start || !this.mayPlan) return this.release();
      const [before, { planned }] = [linesOfStart(start), this];
      const isPlanned = planned?.program === program && isSame(planned.settings, this.machine.settings) && planned.before.join() === before.join();
      if (!isPlanned) this.begin(program, before, new Map(this.machine.settings));
      else if (planned.isKnown) this.release();
    });
  }

  private begin(program: string, before: string[], settings: ReadonlyMap<number, string>): void {
    this.planned?.plan.end();
    const next: Planned = { program, before, settings, isKnown: false, plan: new Plan(program, settings, before, () => this.take(next)) };
    this.planned = next;
    this.changed();
  }

  private release(): void {
    for (const resolve of this.waiting.splice(0)) resolve();
  }

  private take(planned: Planned): void {
    if (this.planned !== planned) return;
    planned.isKnown = true;
    this.changed();
    this.release();
    void this.show();
  }

  private forget(): void {
    this.planned?.plan.end();
    this.planned = this.drawn = undefined;
    this.madeS = Infinity;
    this.release();
    this.changed();
    void this.show();
  }

  private changed(): void {
    for (const changed of this.watchers) changed();
  }

  private async show(): Promise<void> {
    if (!this.isLooked) return;
    const { settings, report } = this.machine;
    const travel = Array.from({ length: AXES }, (_, axis) => Number(settings.get(TRAVEL + axis)));
    const workZero = report.offset.length ? this.machine.inMm(report.offset) : undefined;
    const motion = this.plan?.motion ?? new Motion();
    part("picture").dataset["of"] = this.plan ? "program" : "machine";
    await this.picture.show({ motion, travel: travel.every((mm) => mm > 0) ? travel : [], ...(workZero && { workZero }) });
    this.draw();
  }

  private follow(report: Status, before: Status): void {
    const isMoved = report.offset.join() !== before.offset.join();
    if (nameOf(report.state) === "Idle" && (before.state !== report.state || isMoved)) this.replan();
    if (isMoved) void this.show();
    this.draw();
  }

  /** Goes to what is known now, evenly. */
  private draw(): void {
    if (!this.isLooked) return;
    const { report, link } = this.machine;
    if (!report.machinePosition.length || link === "lost") {
      this.drawn = undefined;
      return this.picture.at({ made: this.madeS, tool: undefined });
    }
    const to = { made: this.madeS, tool: this.machine.inMm(report.machinePosition) };
    if (!this.drawn || this.drawn.made > to.made) this.drawn = to;
    this.from = { ...this.drawn, atMs: performance.now() };
    if (!this.isDrawing) requestAnimationFrame(() => this.step());
    this.isDrawing = true;
  }

  private step(): void {
    const { from, machine } = this;
    this.isDrawing = false;
    if (!from || !this.drawn || !this.isLooked) return;
    const share = Math.min(1, (performance.now() - from.atMs) / BETWEEN_MS);
    const tool = machine.inMm(machine.report.machinePosition);
    if (!tool.length) return;
    const between = (one: number, other: number): number => (Number.isFinite(one + other) ? one + share * (other - one) : other);
    this.drawn = { made: between(from.made, this.madeS), tool: tool.map((mm, axis) => between(from.tool[axis] ?? mm, mm)) };
    this.picture.at(this.drawn);
    if (share < 1) {
      this.isDrawing = true;
      requestAnimationFrame(() => this.step());
    }
  }
}

function isSame(one: ReadonlyMap<number, string>, other: ReadonlyMap<number, string>): boolean {
  return one.size === other.size && [...one].every(([number, value]) => other.get(number) === value);
}
