// A machine on the other side of a port, whichever it is: what it said last, and what it may be asked.

import { AXES, isRotary, unitOf } from "../axes";
import type { Trouble } from "../messages";
import { goesOnChanging, HOLD, JOG_CANCEL, LETTERS, Lines, MM_PER_INCH, nameOf, RESET, setting, STATUS, status, TOOL_CHANGE, UNKNOWN, type Status } from "./dialect";
import { Flight, FORGOTTEN } from "./flight";
import { Homed } from "./homed";
import type { Listener, Port } from "./port";
import type { JobHolder } from "./server-sender";
import { Words } from "./words";

const ASK_EVERY_MS = 200;
/** A machine that has said nothing for so long, though it is asked, is silent. */
const SILENT_MS = 1500;
/** The longest time from the first report to the welcome, if one comes. */
const WELCOME_MS = 150;

/** The link to a machine: one that is silent may come back, one that is lost is gone. */
export type Link = "none" | "connected" | "silent" | "lost";

/** What becomes known of a machine. */
export interface Watcher {
  /** How the link is, in words if it is not as it should be. */
  linked?(link: Link, words: string): void;
  /** Another machine is attached, or none. */
  attached?(): void;
  /** It begins anew: after power-up, and after a reset. Lines of before are answered with `FORGOTTEN` then. */
  began?(): void;
  /** A report of its state, and what was known before. */
  reported?(report: Status, before: Status): void;
  /** Its settings have been read, or one has changed. */
  set?(): void;
  /** A line for the log, and what it is: `sent`, `wrong`, `note`, or what the machine said. */
  logged?(line: string, kind: string): void;
  /** An alarm in words; empty when it is over. */
  alarmed?(words: string): void;
  /** A message of the machine, as `[PRB:...]`. */
  said?(message: string): void;
}

export class Machine {
  /** As in the last report, `Off` without a machine. */
  report: Status = UNKNOWN;
  link: Link = "none";
  readonly homed = new Homed();
  /** `$n`, as it was printed last. */
  readonly settings = new Map<number, string>();
  private port: Port | undefined;
  /** Whether this machine has said anything, and when it was heard last, ms. */
  private isHeard = false;
  private heardAt = 0;
  /** When it was asked last, ms. */
  private askedAt = 0;
  private lines = new Lines();
  private readonly flight = new Flight((line) => this.write(`${line}\n`));
  private readonly watchers: Watcher[] = [];
  private readonly words = new Words((line, then) => this.query(line, then));
  /** The alarm whose words come next, if one has just been raised. */
  private alarm = "";
  /** Whether a reset of the page, by a byte or a line, has not been answered yet: it keeps the position. */
  private isResetting = false;
  /** The timer after which no welcome is waited for. */
  private greeting: number | undefined;
  private isGreeted = false;
  /** A change of the tool: what is sent waits for its end, or is by hand. */
  private change: "none" | "waits" | "by hand" = "none";

  constructor() {
    window.addEventListener("pagehide", () => this.letGo());
    setInterval(() => this.port && !document.hidden && this.inquire(), ASK_EVERY_MS);
  }

  watch(watcher: Watcher): void {
    this.watchers.push(watcher);
  }

  /** Takes another machine, which is at power-up or has been on before, and leaves the one before. */
  attach<P extends Port>(open: (listener: Listener) => P, isAtPowerUp: boolean): P {
    this.detach();
    this.homed.begin(isAtPowerUp);
    const port = open({
      bytes: (bytes) => this.port === port && this.take(bytes),
      lost: (trouble) => this.port === port && this.lose(trouble),
    });
    this.port = port;
    this.isHeard = false;
    this.heardAt = performance.now();
    this.setLink("connected");
    this.tell((watcher) => watcher.attached?.());
    return port;
  }

  /** Leaves the machine: a jog is cancelled, a program held. */
  detach(): void {
    this.letGo();
    this.port?.close();
    this.lines = new Lines();
    this.settings.clear();
    clearTimeout(this.greeting);
    this.greeting = undefined;
    this.isResetting = this.isGreeted = false;
    this.begin();
    this.end("none");
  }

  get isAttached(): boolean {
    return this.port !== undefined;
  }

  /** The other end of the port, if it holds jobs. */
  get jobs(): JobHolder | undefined {
    return this.port?.jobs;
  }

  get state(): string {
    return this.report.state;
  }

  /** The letters of its axes, as many as it reports. */
  get axes(): string[] {
    return LETTERS.slice(0, this.report.machinePosition.length || AXES);
  }

  /** Whether it moves, or may for all that is known. */
  get mayMove(): boolean {
    if (!this.isAttached) return this.link === "lost";
    return this.link === "silent" || !["Off", "Idle", "Alarm", "Check", "Sleep"].includes(nameOf(this.state));
  }

  /** Whether it reports inches. */
  get isInches(): boolean {
    return this.settings.get(13) === "1";
  }

  /** The same of an axis: a rotary one is in degrees. */
  isInInches(axis: number): boolean {
    return this.isInches && unitOf(axis, isRotary(this.settings)) === "mm";
  }

  /** Places that it reports, in mm, and of a rotary axis in degrees. */
  inMm(places: number[]): number[] {
    return places.map((place, axis) => (this.isInInches(axis) ? place * MM_PER_INCH : place));
  }

  /** Lines that wait or are under way. */
  get underWay(): number {
    return this.flight.length;
  }

  /** Whether a tool is being changed, with jogs and holds in that. */
  get isChanging(): boolean {
    return this.change !== "none";
  }

  /** Whether it waits for a tool, and has answered what a person has sent: a resume is heard now. */
  get waitsForTool(): boolean {
    return this.state === "Tool" && this.flight.handLength === 0;
  }

  /** A real-time byte, at once. */
  byte(byte: number): void {
    if (byte === RESET) this.isResetting = true;
    this.port?.send(Uint8Array.of(byte));
  }

  /** A line of a person: it is logged, and its answer too. */
  command(line: string, answered?: (answer: string) => void): void {
    if (!this.port) return this.log(`not sent, because there is no machine: ${line}`, "wrong");
    this.log(line, "sent");
    this.ask(line, (answer) => {
      if (answer === "ok") this.log(answer, "");
      else this.words.of(answer, (words) => this.log(words, "wrong"));
      answered?.(answer);
    });
  }

  /** A line of the page, of which only the answer is looked at. */
  ask(line: string, answered: (answer: string) => void): void {
    this.push(line, answered);
  }

  /** A line of a program, which waits for the end of a change of the tool. */
  askOfProgram(line: string, answered: (answer: string) => void): void {
    this.push(line, answered, undefined, true);
  }

  /** A line of the page: what it prints is not logged, but given with the answer. */
  query(line: string, answered: (printed: string[], answer: string) => void): void {
    const printed: string[] = [];
    this.push(line, (answer) => answered(printed, answer), (text) => printed.push(text));
  }

  /** What an answer means, once the machine has said it. */
  explain(answer: string, then: (words: string) => void): void {
    this.words.of(answer, then);
  }

  /** Sends nothing of what waits; what is under way is answered still. */
  forgetWaiting(): void {
    this.flight.forgetWaiting();
  }

  log(line: string, kind: string): void {
    this.tell((watcher) => watcher.logged?.(line, kind));
  }

  /** Reads all settings, as they are in force. */
  readSettings(then?: () => void): void {
    this.query("$$", (lines) => {
      for (const line of lines) {
        const read = setting(line);
        if (read) this.settings.set(...read);
      }
      this.tell((watcher) => watcher.set?.());
      then?.();
    });
  }

  private push(line: string, answered: (answer: string) => void, printed?: (line: string) => void, isOfProgram = false): void {
    const heard = (answer: string): void => {
      if (answer === "ok") this.accepted(line);
      answered(answer);
    };
    if (isOfProgram || !this.isChanging) return this.flight.push(line, heard, printed);
    this.beginByHand();
    this.flight.pushByHand(line, heard, printed);
  }

  /** What is sent from now on is by hand, until the tool has been changed. */
  private beginByHand(): void {
    if (this.change === "by hand") return;
    this.change = "by hand";
    this.flight.shut();
    this.byte(TOOL_CHANGE);
  }

  private noteChange(state: string): void {
    if (this.change === "none" && state === "Tool") this.change = "waits";
    if (this.change === "none" || goesOnChanging(state)) return;
    this.change = "none";
    this.flight.open();
  }

  private accepted(line: string): void {
    this.homed.accepted(line);
    if (/^\$RST/i.test(line) || (/^\$C$/i.test(line) && this.state === "Check")) this.isResetting = true;
    this.note(setting(line));
  }

  private note(set: [number, string] | undefined): void {
    if (!set) return;
    this.settings.set(...set);
    this.tell((watcher) => watcher.set?.());
  }

  private write(text: string): void {
    this.port?.send(new TextEncoder().encode(text));
  }

  private tell(what: (watcher: Watcher) => void): void {
    this.watchers.forEach(what);
  }

  private letGo(): void {
    if (this.jobs) return;
    this.byte(JOG_CANCEL);
    if (nameOf(this.state) === "Run") this.byte(HOLD);
  }

  private begin(): void {
    if (!this.isResetting) this.homed.doubt();
    this.isResetting = false;
    const lost = this.flight.restart();
    this.change = "none";
    this.tell((watcher) => watcher.began?.());
    for (const line of lost) line.answered(FORGOTTEN);
  }

  private lose(trouble: Trouble): void {
    if (!this.isHeard) return this.end("none", `There is no link to the machine: ${trouble.words}`);
    this.end("lost", `The link to the machine is lost: ${trouble.words}. What the machine was told before it may still do: look at the machine itself.`);
  }

  /** There is no machine any more, and why. */
  private end(link: Link, words = ""): void {
    this.port = undefined;
    this.report = UNKNOWN;
    this.setLink(link, words);
    this.tell((watcher) => watcher.reported?.(UNKNOWN, UNKNOWN));
    this.tell((watcher) => watcher.alarmed?.(""));
    this.tell((watcher) => watcher.attached?.());
  }

  private setLink(link: Link, words = ""): void {
    this.link = link;
    this.tell((watcher) => watcher.linked?.(link, words));
  }

  /** Asks for a report. What was asked before should have been answered long ago. */
  private inquire(): void {
    const now = performance.now();
    // A page that is hidden, that hangs or that sleeps does not ask.
    if (now - this.askedAt > SILENT_MS) this.heardAt = now;
    this.askedAt = now;
    const silentMs = now - this.heardAt;
    if (silentMs > SILENT_MS) this.setLink("silent", `The machine has not answered for ${Math.floor(silentMs / 1000)} s: what is shown may be old, and it may still move.`);
    this.byte(STATUS);
  }

  private take(bytes: Uint8Array): void {
    this.isHeard = true;
    this.heardAt = performance.now();
    if (this.link === "silent") this.setLink("connected");
    this.lines.push(bytes).forEach((line) => this.hear(line));
  }

  private hear(line: string): void {
    const report = status(line, this.report);
    if (report) return this.show(report);
    this.homed.reported(line);
    if (line === "ok" || line.startsWith("error:")) return this.flight.answer(line);
    if (line.startsWith("Grbl ")) {
      clearTimeout(this.greeting);
      this.isGreeted = true;
      this.begin();
      this.readSettings();
    } else if (line.startsWith("ALARM:")) {
      this.homed.alarmed(Number(line.slice(6)));
      this.alarm = line;
      this.tell((watcher) => watcher.alarmed?.(line));
    } else if (this.alarm && line.startsWith("[MSG:")) {
      const words = `${this.alarm}: ${line.slice(5, -1)}`;
      this.alarm = "";
      this.tell((watcher) => watcher.alarmed?.(words));
    } else if (this.flight.hears(line)) {
      return;
    }
    // Listed for a person, or changed by another page.
    this.note(setting(line));
    if (line.startsWith("[")) this.tell((watcher) => watcher.said?.(line));
    this.log(line, line.startsWith("ALARM:") ? "wrong" : "");
  }

  private show(report: Status): void {
    const before = this.report;
    this.report = report;
    this.homed.count(this.axes);
    if (report.homedMask !== undefined) this.homed.told(report.homedMask);
    this.noteChange(report.state);
    if (before.state.startsWith("Alarm") && !report.state.startsWith("Alarm")) this.tell((watcher) => watcher.alarmed?.(""));
    this.tell((watcher) => watcher.reported?.(report, before));
    // A board that was in use already says no welcome. If it says one, it forgets what was asked before.
    this.greeting ??= window.setTimeout(() => (this.isGreeted = true), WELCOME_MS);
    if (this.isGreeted && !this.settings.size && !this.underWay && ["Idle", "Alarm"].includes(report.state)) this.readSettings();
  }
}
