// Operates a machine: its position and state, homing, jogging, holding, and a console.

import { button, element, input, made, part, select } from "./elements";
import { Flight, HOLD, JOG_CANCEL, Lines, RESET, RESUME, STATUS, status, type Status } from "./dialect";
import { AXIS_NAMES } from "./motion";
import { SimulatedPort } from "./port";

const ASK_EVERY_MS = 200;
/** Lines that the console keeps. */
const LOG_MAX = 500;
/** How far a jog goes at most on an axis whose zero is not known, mm. */
const JOG_BLIND_MM = 100;
/** Keys on the jog pad: the axis and the direction. */
const JOG_KEYS: Record<string, [number, number]> = {
  ArrowLeft: [0, -1],
  ArrowRight: [0, 1],
  ArrowDown: [1, -1],
  ArrowUp: [1, 1],
  PageDown: [2, -1],
  PageUp: [2, 1],
};

/** The letters of inputs that are pressed; all others are limit switches of their axes. */
const PINS: Record<string, string> = {
  P: "probe",
  "2": "second motor's limit",
  D: "door open",
  R: "emergency stop",
  H: "feed hold",
  S: "cycle start",
};

interface Sending {
  lines: string[];
  next: number;
  answered: number;
}

export class Operate {
  private port: SimulatedPort | undefined;
  private lines = new Lines();
  private readonly flight = new Flight((line) => this.write(`${line}\n`));
  private state = "";
  private isHomed = false;
  /** The alarm whose words come next, if one has just been raised. */
  private alarmed = "";
  private travel: (number | undefined)[] = [];
  private jogging: string | undefined;
  private sending: Sending | undefined;
  private readonly history: string[] = [];
  private past = 0;

  constructor(
    private readonly program: () => string,
    private readonly settings: () => string,
  ) {
    button("power").onclick = () => this.power();
    this.on("home", () => this.command("$H"));
    this.on("unlock", () => this.command("$X"));
    this.on("hold", () => this.byte(HOLD));
    this.on("resume", () => this.byte(RESUME));
    this.on("reset", () => this.reset());
    this.on("zero", () => this.command("G0 X0 Y0 Z0"));
    const stop = input("stop-button");
    stop.onchange = () => this.port?.setStopButton(stop.checked);
    select("live-rate").onchange = () => this.port?.setSpeed(Number(select("live-rate").value));
    this.on("send-program", () => this.stream());
    this.on("stop-program", () => this.stopStream());
    this.readConsole();
    this.readJogs();
    setInterval(() => this.port && !document.hidden && this.byte(STATUS), ASK_EVERY_MS);
    setInterval(() => this.showPlace(), 50);
  }

  /** Switches the machine on when its page is first looked at. */
  look(): void {
    if (!this.port) this.power();
  }

  private on(id: string, act: () => void): void {
    button(id).onclick = act;
  }

  /** A machine at power-up, with the settings of the page. */
  private power(): void {
    this.port?.close();
    this.flight.restart();
    this.lines = new Lines();
    this.sending = undefined;
    this.isHomed = false;
    input("stop-button").checked = false;
    this.log("power-up", "note");
    this.port = new SimulatedPort(this.settings(), {
      bytes: (bytes) => this.lines.push(bytes).forEach((line) => this.hear(line)),
      lost: (trouble) => {
        this.port = undefined;
        this.showState("Off");
        this.alarm(`The machine is gone: ${trouble.words}`);
      },
    });
    this.port.setSpeed(Number(select("live-rate").value));
    this.alarm("");
    for (const axis of [0, 1, 2]) this.travel[axis] = undefined;
  }

  private write(text: string): void {
    this.port?.send(new TextEncoder().encode(text));
  }

  private byte(byte: number): void {
    this.port?.send(Uint8Array.of(byte));
  }

  private command(line: string): void {
    this.log(line, "sent");
    this.flight.push(line, (answer) => {
      this.log(answer, answer === "ok" ? "" : "wrong");
      if (line === "$H") this.isHomed = answer === "ok";
    });
  }

  private reset(): void {
    this.sending = undefined;
    this.byte(RESET);
  }

  private hear(line: string): void {
    const report = status(line);
    if (report) return this.show(report);
    if (line === "ok" || line.startsWith("error:")) return this.flight.answer(line);
    if (line.startsWith("Grbl ")) {
      this.flight.restart();
      this.sending = undefined;
      this.showSending();
      this.flight.push("$$", () => {});
    }
    const travel = /^\$13([0-2])=([\d.]+)/.exec(line);
    if (travel) this.travel[Number(travel[1])] = Number(travel[2]);
    if (/^\$\d+=/.test(line) && this.flight.length) return;
    if (line.startsWith("ALARM:")) {
      this.isHomed = false;
      this.sending = undefined;
      this.alarmed = line;
      this.alarm(line);
    } else if (this.alarmed && line.startsWith("[MSG:")) {
      this.alarm(`${this.alarmed}: ${line.slice(5, -1)}`);
      this.alarmed = "";
    }
    this.log(line, line.startsWith("ALARM:") ? "wrong" : "");
  }

  private show(report: Status): void {
    this.showState(report.state);
    part("feed-now").textContent = `${report.feed ?? 0} mm/min`;
    part("pins-now").textContent = [...report.pins].map((pin) => PINS[pin] ?? `${pin} limit`).join(", ") || "none";
    if (report.override) part("override-now").textContent = `${report.override.split(",")[0]} %`;
  }

  private showState(state: string): void {
    const name = state.split(":")[0] ?? "";
    if (this.state.startsWith("Alarm") && name !== "Alarm") this.alarm("");
    this.state = state;
    const badge = part("state");
    badge.textContent = state;
    badge.dataset["state"] = name;
    part("homed-now").textContent = this.isHomed ? "yes" : "no";
    button("unlock").disabled = name !== "Alarm";
    // While it brakes still, it does not resume.
    button("resume").disabled = state !== "Hold:0" && state !== "Door:0";
    button("hold").disabled = !["Run", "Jog", "Home"].includes(name);
    button("home").disabled = !["Idle", "Alarm"].includes(name);
    button("zero").disabled = name !== "Idle" || !this.isHomed;
    button("send-program").disabled = name !== "Idle" || this.sending !== undefined;
  }

  private alarm(words: string): void {
    const place = part("alarm");
    place.textContent = words;
    place.hidden = !words;
  }

  private showPlace(): void {
    this.port?.positionMm.forEach((mm, axis) => {
      part(`place-${AXIS_NAMES[axis]?.toLowerCase()}`).textContent = mm.toFixed(3);
    });
  }

  // Jogging: held down jogs, let go cancels.

  private readJogs(): void {
    const pad = part("pad");
    for (const key of pad.querySelectorAll<HTMLButtonElement>("button[data-axis]")) {
      const [axis, direction] = [Number(key.dataset["axis"]), Number(key.dataset["direction"])];
      key.addEventListener("pointerdown", (event) => {
        if (event.button !== 0) return;
        key.setPointerCapture(event.pointerId);
        this.jog(axis, direction, "pointer");
      });
      for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) key.addEventListener(end, () => this.letGo("pointer"));
      key.addEventListener("contextmenu", (event) => event.preventDefault());
      key.addEventListener("keydown", (event) => {
        if (![" ", "Enter"].includes(event.key)) return;
        event.preventDefault();
        if (!event.repeat) this.jog(axis, direction, event.key);
      });
    }
    pad.addEventListener("keydown", (event) => {
      const jog = JOG_KEYS[event.key];
      if (!jog) return;
      event.preventDefault();
      if (!event.repeat) this.jog(...jog, event.key);
    });
    pad.addEventListener("keyup", (event) => this.letGo(event.key));
    pad.addEventListener("focusout", (event) => {
      // The first of a press moves the focus from one button to another.
      if (!(event.relatedTarget instanceof Node && pad.contains(event.relatedTarget))) this.letGo();
    });
    window.addEventListener("blur", () => this.letGo());
    document.addEventListener("visibilitychange", () => document.hidden && this.letGo());
  }

  /** Jogs to the end of the axis, if that is known; whoever holds the key down ends it before. */
  private jog(axis: number, direction: number, by: string): void {
    if (this.jogging || !["Idle", "Jog"].includes(this.state)) return;
    this.jogging = by;
    const [name, feed] = [AXIS_NAMES[axis], input("jog-feed").value || "1000"];
    const travel = this.travel[axis];
    const end = this.isHomed && travel ? `G90 G53 ${name}${direction > 0 ? travel : 0}` : `G91 ${name}${direction * JOG_BLIND_MM}`;
    const line = `$J=${end} F${feed}`;
    this.log(line, "sent");
    this.flight.push(line, (answer) => answer !== "ok" && this.log(answer, "wrong"));
  }

  private letGo(by = this.jogging): void {
    if (!this.jogging || this.jogging !== by) return;
    this.jogging = undefined;
    this.flight.forgetWaiting();
    this.byte(JOG_CANCEL);
  }

  // The program of the page, sent to this machine.

  private stream(): void {
    const lines = this.program().split(/\r\n|\r|\n/).map((line) => line.replace(/;.*|\([^)]*\)/g, "").trim());
    const sending: Sending = { lines, next: 0, answered: 0 };
    this.sending = sending;
    this.log(`the program, ${lines.length} lines`, "sent");
    const more = (): void => {
      // A few lines ahead of what fits, so that the flight is always full.
      while (this.sending === sending && sending.next < lines.length && this.flight.length < 16) {
        const number = ++sending.next;
        const line = lines[number - 1] ?? "";
        if (/[?!~]/.test(line)) {
          this.log(`line ${number}: \`${line}\` has a real-time command: take it out of the program`, "wrong");
          return this.stopStream();
        }
        this.flight.push(line, (answer) => {
          sending.answered++;
          if (answer !== "ok" && this.sending === sending) {
            this.log(`line ${number} \`${line}\`: ${answer}`, "wrong");
            this.stopStream();
          }
          if (line.startsWith("$H")) this.isHomed = answer === "ok";
          more();
          this.showSending();
        });
      }
      if (this.sending === sending && sending.answered >= lines.length) {
        this.sending = undefined;
        this.log("all lines are answered", "note");
      }
      this.showSending();
    };
    more();
  }

  /** Sends no more; what was sent is made. */
  private stopStream(): void {
    this.flight.forgetWaiting();
    this.sending = undefined;
    this.showSending();
  }

  private showSending(): void {
    const { sending } = this;
    const bar = element("sent", HTMLProgressElement);
    bar.hidden = button("stop-program").hidden = !sending;
    if (sending) bar.value = sending.answered / Math.max(1, sending.lines.length);
  }

  // The console.

  private readConsole(): void {
    const line = input("line");
    element("console", HTMLFormElement).onsubmit = (event) => {
      event.preventDefault();
      const text = line.value.trim();
      if (!text) return;
      this.past = this.history.push(text);
      line.value = "";
      if (["?", "!", "~"].includes(text)) this.byte(text.charCodeAt(0));
      else this.command(text);
    };
    line.onkeydown = (event) => {
      const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
      if (!step) return;
      event.preventDefault();
      this.past = Math.min(Math.max(0, this.past + step), this.history.length);
      line.value = this.history[this.past] ?? "";
    };
  }

  private log(text: string, kind: string): void {
    const log = part("log");
    const isAtEnd = log.scrollHeight - log.scrollTop - log.clientHeight < 40;
    log.append(made("div", kind === "sent" ? `> ${text}` : text, kind));
    while (log.childElementCount > LOG_MAX) log.firstElementChild?.remove();
    if (isAtEnd) log.scrollTop = log.scrollHeight;
  }
}
