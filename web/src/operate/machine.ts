// A machine on the other side of a port, whichever it is: what it said last, and what it may be asked.

import type { Trouble } from "../messages";
import { Lines, STATUS, status, type Status } from "./dialect";
import { Flight } from "./flight";
import type { Listener, Port } from "./port";

const ASK_EVERY_MS = 200;

/** What becomes known of a machine. */
export interface Watcher {
  /** It begins anew: after power-up, and after a reset. Nothing of before is answered. */
  began?(): void;
  /** A report of its state. */
  reported?(report: Status): void;
  /** Its settings have been read, or one has changed. */
  set?(): void;
  /** A line for the log, and what it is: `sent`, `wrong`, `note`, or what the machine said. */
  logged?(line: string, kind: string): void;
  /** An alarm in words; empty when it is over. */
  alarmed?(words: string): void;
}

export class Machine {
  /** As in the last report, `Off` without a machine. */
  state = "Off";
  isHomed = false;
  /** `$n`, as it was printed last. */
  readonly settings = new Map<number, string>();
  private port: Port | undefined;
  private lines = new Lines();
  private readonly flight = new Flight((line) => this.write(`${line}\n`));
  private readonly watchers: Watcher[] = [];
  /** The alarm whose words come next, if one has just been raised. */
  private alarm = "";

  constructor() {
    setInterval(() => this.port && !document.hidden && this.byte(STATUS), ASK_EVERY_MS);
  }

  watch(watcher: Watcher): void {
    this.watchers.push(watcher);
  }

  /** Takes another machine, and leaves the one before. */
  attach<P extends Port>(open: (listener: Listener) => P): P {
    this.port?.close();
    this.lines = new Lines();
    this.begin();
    this.state = "Off";
    this.tell((watcher) => watcher.alarmed?.(""));
    const port = open({
      bytes: (bytes) => this.port === port && this.lines.push(bytes).forEach((line) => this.hear(line)),
      lost: (trouble) => this.port === port && this.lose(trouble),
    });
    this.port = port;
    return port;
  }

  get isAttached(): boolean {
    return this.port !== undefined;
  }

  /** Lines that wait or are under way. */
  get underWay(): number {
    return this.flight.length;
  }

  /** A real-time byte, at once. */
  byte(byte: number): void {
    this.port?.send(Uint8Array.of(byte));
  }

  /** A line of a person: it is logged, and its answer too. */
  command(line: string): void {
    this.log(line, "sent");
    this.ask(line, (answer) => this.log(answer, answer === "ok" ? "" : "wrong"));
  }

  /** A line of the page, of which only the answer is looked at. */
  ask(line: string, answered: (answer: string) => void): void {
    this.flight.push(line, (answer) => {
      if (/^\$H/i.test(line)) this.isHomed = answer === "ok" && (this.isHomed || line.length === 2);
      const set = /^\$(\d+)=(.*)/.exec(line);
      if (set && answer === "ok") this.know(Number(set[1]), set[2] ?? "");
      answered(answer);
    });
  }

  /** A line of the page: what it prints is not logged, but given with the answer. */
  query(line: string, answered: (printed: string[], answer: string) => void): void {
    const printed: string[] = [];
    this.flight.push(line, (answer) => answered(printed, answer), (text) => printed.push(text));
  }

  /** Sends nothing of what waits; what is under way is answered still. */
  forgetWaiting(): void {
    this.flight.forgetWaiting();
  }

  log(line: string, kind: string): void {
    this.tell((watcher) => watcher.logged?.(line, kind));
  }

  private write(text: string): void {
    this.port?.send(new TextEncoder().encode(text));
  }

  private tell(what: (watcher: Watcher) => void): void {
    this.watchers.forEach(what);
  }

  private begin(): void {
    this.flight.restart();
    this.isHomed = false;
    this.tell((watcher) => watcher.began?.());
  }

  private know(number: number, value: string): void {
    this.settings.set(number, value);
    this.tell((watcher) => watcher.set?.());
  }

  private readSettings(): void {
    this.query("$$", (lines) => {
      for (const line of lines) {
        const set = /^\$(\d+)=(\S*)/.exec(line);
        if (set) this.settings.set(Number(set[1]), set[2] ?? "");
      }
      this.tell((watcher) => watcher.set?.());
    });
  }

  private lose(trouble: Trouble): void {
    this.port = undefined;
    this.show({ state: "Off", position: [], feed: undefined, pins: "", override: "" });
    this.tell((watcher) => watcher.alarmed?.(`The machine is gone: ${trouble.words}`));
  }

  private hear(line: string): void {
    const report = status(line);
    if (report) return this.show(report);
    if (line === "ok" || line.startsWith("error:")) return this.flight.answer(line);
    if (line.startsWith("Grbl ")) {
      this.begin();
      this.readSettings();
    } else if (line.startsWith("ALARM:")) {
      this.isHomed = false;
      this.alarm = line;
      this.tell((watcher) => watcher.alarmed?.(line));
    } else if (this.alarm && line.startsWith("[MSG:")) {
      const words = `${this.alarm}: ${line.slice(5, -1)}`;
      this.alarm = "";
      this.tell((watcher) => watcher.alarmed?.(words));
    } else if (this.flight.hears(line)) {
      return;
    }
    this.log(line, line.startsWith("ALARM:") ? "wrong" : "");
  }

  private show(report: Status): void {
    if (this.state.startsWith("Alarm") && !report.state.startsWith("Alarm")) this.tell((watcher) => watcher.alarmed?.(""));
    this.state = report.state;
    this.tell((watcher) => watcher.reported?.(report));
  }
}
