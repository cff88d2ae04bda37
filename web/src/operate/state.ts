// What the machine does, and the buttons for that.

import { button, part } from "../elements";
import { HOLD, LETTERS, nameOf, RESET, RESUME, type Status } from "./dialect";
import type { Machine } from "./machine";

/** The letters of inputs that are on; all others are limit switches of their axes. */
const PINS: Record<string, string> = {
  P: "probe",
  "2": "second motor's limit",
  D: "door open",
  R: "emergency stop",
  H: "feed hold",
  S: "cycle start",
};

export class State {
  constructor(private readonly machine: Machine) {
    const buttons: [string, () => void][] = [
      ["home", () => machine.command("$H")],
      ...LETTERS.map((axis): [string, () => void] => [`home-${axis.toLowerCase()}`, () => machine.command(`$H${axis}`)]),
      ["unlock", () => machine.command("$X")],
      ["hold", () => machine.byte(HOLD)],
      ["resume", () => machine.byte(RESUME)],
      ["reset", () => machine.byte(RESET)],
    ];
    for (const [id, act] of buttons) button(id).onclick = act;
    machine.watch({
      reported: (report) => this.show(report),
      linked: (_, words) => this.showLink(words),
      alarmed: (words) => this.tell("alarm", words),
    });
  }

  /** The state, or what is wrong with the link: a state of before is none. */
  private showState(): void {
    const { link, state } = this.machine;
    const words = link === "lost" ? "Lost" : link === "silent" ? "Silent" : state;
    for (const badge of document.querySelectorAll<HTMLElement>("[data-shows=state]")) {
      if (badge.textContent !== words) badge.textContent = words;
      badge.dataset["state"] = nameOf(words);
    }
  }

  private showLink(words: string): void {
    this.tell("link-trouble", words);
    this.showState();
  }

  private show(report: Status): void {
    const { state, room } = report;
    const name = nameOf(state);
    this.showState();
    const isKnown = name !== "Off";
    part("homed-now").textContent = isKnown ? this.machine.homed.words : "–";
    part("feed-now").textContent = isKnown ? `${report.feed} ${this.machine.isInches ? "in" : "mm"}/min` : "–";
    part("pins-now").textContent = isKnown ? [...report.pins].map((pin) => PINS[pin] ?? `${pin} limit`).join(", ") || "none" : "–";
    part("room").hidden = !room;
    if (room) part("room-now").textContent = `${room[0]} moves, ${room[1]} bytes`;
    button("unlock").disabled = name !== "Alarm";
    // While it brakes still, it does not resume.
    button("resume").disabled = !["Hold:0", "Door:0"].includes(state) && !this.machine.waitsForTool;
    button("hold").disabled = !["Run", "Jog"].includes(name);
    button("home").disabled = !["Idle", "Alarm"].includes(name);
    for (const id of ["stop", "reset"]) button(id).disabled = !this.machine.isAttached;
  }

  /** What is wrong, with the machine and with the link to it: above its panels, and at the foot of every view. */
  private tell(id: "alarm" | "link-trouble", words: string): void {
    say(id, words);
    say("bar-trouble", part("link-trouble").textContent || part("alarm").textContent || "");
  }
}

function say(id: string, words: string): void {
  const place = part(id);
  place.textContent = words;
  place.hidden = !words;
}
