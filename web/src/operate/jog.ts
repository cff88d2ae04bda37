// Jogging: held down jogs, let go cancels; or by steps, of which each is made whole.

import { input, part } from "../elements";
import { JOG_CANCEL, LETTERS } from "./dialect";
import { HeldJog } from "./held";
import { FORGOTTEN } from "./flight";
import type { Machine } from "./machine";

/** How often a jog that is held down is renewed. */
const RENEW_EVERY_MS = 40;

/** How far a jog goes at most on an axis whose zero is not known, mm. */
const BLIND_MM = 100;
/** Keys on the jog pad: the axis and the direction. */
const KEYS: Record<string, [number, number]> = {
  ArrowLeft: [0, -1],
  ArrowRight: [0, 1],
  ArrowDown: [1, -1],
  ArrowUp: [1, 1],
  PageDown: [2, -1],
  PageUp: [2, 1],
};
/** The setting with the travel of the first axis. */
const TRAVEL = 130;

export class Jog {
  /** What is held down, and the jog that it makes. */
  private by: string | undefined;
  private held: HeldJog | undefined;

  constructor(private readonly machine: Machine) {
    const pad = part("pad");
    for (const key of pad.querySelectorAll<HTMLButtonElement>("button[data-axis]")) this.readKey(key);
    pad.addEventListener("keydown", (event) => {
      const jog = KEYS[event.key];
      if (!jog) return;
      event.preventDefault();
      if (!event.repeat) this.start(...jog, event.key);
    });
    pad.addEventListener("keyup", (event) => this.letGo(event.key));
    pad.addEventListener("focusout", (event) => {
      // The first of a press moves the focus from one button to another.
      if (!(event.relatedTarget instanceof Node && pad.contains(event.relatedTarget))) this.letGo();
    });
    window.addEventListener("blur", () => this.letGo());
    document.addEventListener("visibilitychange", () => document.hidden && this.letGo());
    machine.watch({
      began: () => this.forget(),
      attached: () => this.forget(),
      reported: (report) => {
        this.held?.report(report);
        for (const key of pad.querySelectorAll<HTMLButtonElement>("button[data-axis]")) key.hidden = Number(key.dataset["axis"]) >= machine.axes.length;
      },
    });
    setInterval(() => this.held?.renew(), RENEW_EVERY_MS);
  }

  private readKey(key: HTMLButtonElement): void {
    const [axis, direction] = [Number(key.dataset["axis"]), Number(key.dataset["direction"])];
    key.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      key.setPointerCapture(event.pointerId);
      this.start(axis, direction, "pointer");
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) key.addEventListener(end, () => this.letGo("pointer"));
    key.addEventListener("contextmenu", (event) => event.preventDefault());
    key.addEventListener("keydown", (event) => {
      if (![" ", "Enter"].includes(event.key)) return;
      event.preventDefault();
      if (!event.repeat) this.start(axis, direction, event.key);
    });
  }

  /** How far one press goes, mm; undefined for as long as it is held down. */
  private get stepMm(): number | undefined {
    return Number(document.querySelector<HTMLInputElement>("[name=jog-step]:checked")?.value) || undefined;
  }

  /** Begins a jog, by a key or something else that has this name: as far as a press goes, or until it is let go. */
  start(axis: number, direction: number, by: string): void {
    if (this.by || !["Idle", "Jog", "Tool"].includes(this.machine.state)) return;
    const { stepMm } = this;
    const feed = Number(input("jog-feed").value) || 1000;
    // A step ends by itself: were it cancelled when the key is let go, it would be of another length.
    if (stepMm) return this.ask(`$J=G21 G91 ${LETTERS[axis]}${direction * stepMm} F${feed}`);
    this.by = by;
    const { report } = this.machine;
    this.machine.log(`jog ${LETTERS[axis]}${direction > 0 ? "+" : "-"} F${feed}, while it is held`, "sent");
    this.held = new HeldJog(axis, direction, feed, this.mostMm(axis, direction), report, this.machine.isInInches(axis), (line) => this.ask(line));
  }

  private ask(line: string): void {
    if (!this.by) this.machine.log(line, "sent");
    this.machine.ask(line, (answer) => {
      if (answer === "ok" || answer === FORGOTTEN) return;
      // What was refused is not asked for again.
      this.held = undefined;
      this.machine.explain(answer, (words) => this.machine.log(words, "wrong"));
    });
  }

  /** To the end of the axis, if that is known; whoever holds the key down ends it before. */
  private mostMm(axis: number, direction: number): number {
    const travelMm = Number(this.machine.settings.get(TRAVEL + axis));
    if (!this.machine.homed.has(LETTERS[axis] ?? "") || !travelMm) return BLIND_MM;
    const placeMm = this.machine.inMm(this.machine.report.machinePosition)[axis] ?? 0;
    return Math.max(0, direction > 0 ? travelMm - placeMm : placeMm);
  }

  private forget(): void {
    this.by = this.held = undefined;
  }

  /** What has begun a jog is let go. */
  letGo(by = this.by): void {
    if (!this.by || this.by !== by) return;
    this.forget();
    // In a change of the tool only lines of a program wait.
    if (!this.machine.isChanging) this.machine.forgetWaiting();
    this.machine.byte(JOG_CANCEL);
  }
}
