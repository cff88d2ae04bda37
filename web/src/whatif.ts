// What if: settings that are moved, and what would become of the program, in another machine that is as simulated as the first.

import "./whatif.css";
import { button, element, input, part } from "./elements";
import { Task } from "./job";
import type { Load, SettingRow } from "./messages";
import { read, reason, withSettings } from "./settings/lines";
import { becomes } from "./whatif/becomes";
import type { Control } from "./whatif/control";
import { figures } from "./whatif/figures";
import { knobs } from "./whatif/knobs";
import { written } from "./whatif/scale";
import { type Known, Trial } from "./whatif/trial";

/** A hand on a slider moves on within this, ms. */
const SETTLED_MS = 100;
const DAMPING = 970;

export class WhatIf {
  private readonly before = new Trial();
  private readonly after = new Trial();
  private readonly rowsOf = new Task();
  private rows: ReadonlyMap<number, SettingRow> = new Map();
  private controls: Control[] = [];
  private waiting = 0;

  /** `keep` puts other settings in force. */
  constructor(
    private readonly program: () => string,
    private readonly inForce: () => string,
    keep: (settings: string) => void,
  ) {
    button("what-if-back").onclick = () => this.look();
    button("what-if-keep").onclick = () => keep(this.settings);
    input("what-if-load").oninput = () => this.move();
  }

  /** The settings are others. What was moved is forgotten. */
  look(): void {
    if (!this.rows.size) return this.ask();
    const inForce = read(this.inForce());
    for (const control of this.controls) control.set(inForce);
    this.move();
  }

    private ask(): void {
    this.rowsOf.ask(
      { do: "setting-rows" },
      (said) => {
        if (said.is !== "setting-rows") return false;
        this.rows = new Map(said.rows.map((row) => [row.number, row]));
        this.controls = knobs(this.rows, () => this.move());
        part("what-if-knobs").replaceChildren(...this.controls.map((control) => control.element));
        this.look();
        return true;
      },
      (trouble) => this.say(trouble.words),
    );
  }

  private get changes(): [number, string][] {
    return this.controls.flatMap((control) => control.changes.map(([number, value]): [number, string] => [number, written(value)]));
  }

  /** The settings with what was moved. */
  private get settings(): string {
    return withSettings(this.inForce(), this.changes);
  }

  private get load(): Load | undefined {
    const hz = input("what-if-load").valueAsNumber;
    const damping = read(this.inForce()).get(DAMPING) ?? this.rows.get(DAMPING)?.default;
    return hz > 0 ? { hz, damping: Number(damping) } : undefined;
  }

  private get isMoved(): boolean {
    return this.changes.length > 0;
  }

  /** A setting is moved, or the program is another. */
  move(): void {
    for (const control of this.controls) control.enable();
    const { isMoved } = this;
    for (const id of ["what-if-keep", "what-if-back"]) button(id).disabled = !isMoved;
    clearTimeout(this.waiting);
    this.after.cancel();
    this.forget();
    if (isMoved) this.waiting = window.setTimeout(() => this.run(), SETTLED_MS);
    else this.say("Move a setting to see what becomes of the time.");
  }

  private run(): void {
    const { load } = this;
    const program = this.program();
    this.say("");
    this.tell(0);
    this.before.ask(program, this.inForce(), load, () => this.show(), () => undefined);
    this.after.ask(program, this.settings, load, () => this.show(), (share) => this.tell(share));
  }

  private show(): void {
    const [before, after] = [this.before.known, this.after.known];
    const trouble = after.trouble ?? before.trouble;
    if (trouble) return this.refuse(reason(trouble.words));
    if (!before.found || !after.found) return;
    this.tell(undefined);
    const stopped = after.found.stopped ?? before.found.stopped;
    if (stopped) return this.refuse(`${after.found.stopped ? "It would" : "As set, it does"} not come to its end: ${stopped}`);
    this.say(becomes(before.found.program_s, after.found.program_s));
    this.compare(before, after);
  }

  private compare(before: Known, after: Known): void {
    const rows = figures(before, after);
    part("what-if-figures").replaceChildren(...rows);
    element("what-if-table", HTMLTableElement).hidden = rows.length === 0;
    part("what-if-load-state").textContent = before.unknown ?? after.unknown ?? "";
  }

  private refuse(words: string): void {
    this.forget();
    this.say("");
    part("what-if-refused").textContent = words;
  }

  private forget(): void {
    this.tell(undefined);
    part("what-if-refused").textContent = "";
    this.compare({}, {});
  }

  private say(words: string): void {
    part("what-if-time").textContent = words;
  }

  /** How far the run is, as a share; it is hidden while there is none. */
  private tell(share: number | undefined): void {
    const progress = element("what-if-progress", HTMLProgressElement);
    progress.hidden = share === undefined;
    progress.value = share ?? 0;
  }
}
