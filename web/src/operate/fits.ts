// The program before it is sent: its name, where it would go, how long it takes, and whether the machine can.

import { AXIS_NAMES, placesInWords } from "../axes";
import { button, duration, input, part } from "../elements";
import type { FromLine } from "./from-line";
import type { LivePicture } from "./live";
import type { Machine } from "./machine";
import type { Beyond, Plan } from "./plan";
import { linesOf } from "./program";

export class Fits {
  constructor(
    private readonly machine: Machine,
    private readonly live: LivePicture,
    private readonly fromLine: FromLine,
  ) {
    button("outline").onclick = () => this.goRound();
    live.watch(() => this.show());
    machine.watch({ reported: () => this.showFit() });
  }

  /** Why the program must not be sent as it is; empty if it may. */
  get refusal(): string {
    if (this.fromLine.refusal) return this.fromLine.refusal;
    const beyond = this.live.planOf(this.fromLine.program.text)?.beyond.filter(({ axis }) => this.machine.homed.has(axis)) ?? [];
    return beyond.map((axis) => `${axis.axis} would go to ${axis.placeMm.toFixed(2)} ${axis.unit}, which is ${past(axis)}, first in line ${axis.line}.`).join(" ");
  }

  show(): void {
    const { name, text } = this.fromLine.program;
    const plan = this.live.planOf(text);
    const lines = linesOf(text).length;
    const what = [`${name}: ${lines} ${lines === 1 ? "line" : "lines"}`, plan?.totalS === undefined ? "" : `about ${duration(plan.totalS, 0)}`, plan ? where(plan) : ""];
    part("sending-what").textContent = `${what.filter(Boolean).join(", ")}.`;
    this.showFit();
  }

  private showFit(): void {
    const plan = this.live.planOf(this.fromLine.program.text);
    const [kind, words] = this.fit(plan);
    const place = part("fits");
    if (place.textContent !== words) place.textContent = words;
    place.dataset["fits"] = kind;
    button("outline").disabled = this.machine.state !== "Idle" || !plan?.extents.length || kind === "no";
  }

  private fit(plan: Plan | undefined): [kind: "yes" | "no" | "unknown", words: string] {
    if (!this.machine.isAttached || !plan) return [this.fromLine.refusal ? "no" : "unknown", ""];
    // It stands above.
    if (this.fromLine.refusal) return ["no", ""];
    if (plan.trouble) return ["unknown", `What the machine would do is not known: ${plan.trouble}`];
    const { refusal } = this;
    if (refusal) return ["no", `It does not fit. ${refusal} Move the work's zero, or the work.`];
    const moved = plan.extents.flatMap(([low, high], axis) => (high > low ? [axis] : []));
    const blind = moved.filter((axis) => !plan.isEndless(axis)).map((axis) => AXIS_NAMES[axis] ?? "").filter((axis) => !this.machine.homed.has(axis));
    if (blind.length) return ["unknown", `Whether it fits is not known: ${blind.join(", ")} ${blind.length > 1 ? "are" : "is"} not homed.`];
    return ["yes", moved.length ? "It fits into the travel." : ""];
  }

  /** As jogs, which leave the program's modes alone, at the height at which the tool is. */
  private goRound(): void {
    const [x, y] = this.live.plan?.extents ?? [];
    if (!x || !y) return;
    const feed = input("jog-feed").value || "1000";
    const corners = [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]], [x[0], y[0]]];
    for (const [across, up] of corners) this.machine.command(`$J=G53 G21 G90 X${across?.toFixed(3)} Y${up?.toFixed(3)} F${feed}`);
  }
}

/** The extents, from the machine's zero. */
function where(plan: Plan): string {
  const found = plan.extents.flatMap(([low, high], axis) => (high > low ? [{ axis, words: `${low.toFixed(1)} to ${high.toFixed(1)}` }] : []));
  return found.length ? `${placesInWords(found, plan.motion.isRotary)} of the machine` : "";
}

const past = ({ placeMm, travelMm, unit }: Beyond): string =>
  placeMm < 0 ? `${(-placeMm).toFixed(2)} ${unit} below the machine's zero` : `${(placeMm - travelMm).toFixed(2)} ${unit} past the end of the travel at ${travelMm} ${unit}`;
