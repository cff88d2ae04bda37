// Runs a program in virtual time, and shows what became of it.

import { addressOf, handed } from "./address";
import { Advice } from "./advice";
import { AXES, isRotary } from "./axes";
import { ChoiceOfAxes } from "./choice-of-axes";
import { Curves } from "./curves";
import { Downloads } from "./downloads";
import { takeDropped } from "./drops";
import { Editor } from "./editor";
import { area, button, duration, element, made, part } from "./elements";
import { run, Task, type Watcher } from "./job";
import { keepProgram, keptProgram } from "./kept";
import { linked } from "./lines";
import { type Shared, SHARED, sharedBy } from "./link";
import { isListing, Listing } from "./listing";
import { tooLong } from "./long";
import type { Summary, Trouble } from "./messages";
import { tellOfSettings } from "./mistake";
import { Motion } from "./motion";
import type { Picture } from "./picture/picture";
import { Breath } from "./picture/segments";
import { Playback } from "./playback";
import { example, FIRST, Programs } from "./programs";
import { forgetChecks, tellChecks, tellFigures } from "./results";
import { read } from "./settings/lines";
import { offerLink } from "./share";
import { WhatIf } from "./whatif";

/** Problems that are reported one by one. */
const REPORTED_MAX = 50;
/** While a program runs, its path is drawn this often, and for no more than a tenth of the time. */
const PICTURE_EVERY_MS = 300;

export class Run {
  readonly editor = new Editor(() => this.change(), (words) => this.refuse(words));
  private readonly settings = area("settings");
  private readonly task = new Task();
  private readonly curves = new Curves((time) => this.playback.go(time));
  private readonly playback = new Playback((time, isMoved) => this.look(time, isMoved));
  private readonly advice = new Advice((line) => this.go(line));
  private readonly whatIf = new WhatIf(() => this.editor.value, () => this.settingsLines, (settings) => this.keep(settings));
  private readonly listing = new Listing((lines) => this.set(lines), (file) => void this.open(file, true));
  private readonly axes = new ChoiceOfAxes(() => this.changeSettings());
  private motion = new Motion();
  private name = "program.nc";
  /** The text is not that of the file any more. */
  private isChanged = false;
  private drawNextAt = 0;
  private began = 0;
  private time = Infinity;
  private travel: number[] = [];
  private isLooked = true;

  /** `changed` hears that there is another program. */
  constructor(
    private readonly picture: Picture,
    private readonly changed: () => void,
  ) {
    new Programs((name, text) => this.run(name, text), (file) => void this.open(file));
    this.settings.addEventListener("input", () => this.changeSettings());
    takeDropped(part("drop"), (file, at) => {
      location.hash = addressOf("run");
      void this.open(file, part("settings-details").contains(at));
    });
    offerLink(() => this.shared);
    button("run").onclick = () => this.start();
    button("cancel").onclick = () => this.stop("Cancelled.");
    new Downloads(
      this.task,
      () => ({ name: this.name, program: () => this.editor.bytes, settings: this.settingsLines }),
      { busy: (isBusy) => this.setBusy(isBusy), say: (words) => this.say(words), trouble: (trouble) => this.fail(trouble) },
      () => this.picture.file(),
    );
    window.addEventListener("pagehide", () => keepProgram({ ...this.shared, isChanged: this.isChanged }));
    if (!this.openLink()) void this.begin().then(() => this.start());
  }

  private get shared(): Shared {
    return { name: this.name, text: this.editor.value, settings: this.settingsLines, axes: this.axes.value };
  }

  /** With what was there before a reload, or with one of ours. */
  private async begin(): Promise<void> {
    const kept = keptProgram();
    if (!kept) return this.load(FIRST, await example(FIRST));
    this.settings.value = kept.settings;
    this.axes.value = kept.axes ?? AXES;
    this.load(kept.name, kept.text);
    this.isChanged = kept.isChanged;
  }

  /** Runs what a link has in it, if this is one. It goes to no machine by itself. */
  openLink(): boolean {
    const shared = handed(SHARED);
    if (shared === undefined) return false;
    sharedBy(shared).then(
      ({ name, text, settings, axes }) => {
        const words = tooLong(text) ?? tooLong(settings);
        if (words) return this.refuse(`the link: ${words}`);
        this.axes.value = axes;
        this.load(name, text);
        this.keep(settings);
      },
      async (error: Error) => {
        if (!this.editor.value) await this.begin();
        this.refuse(error.message);
      },
    );
    return true;
  }

  /** A file: a program, or the `$$` of a machine, by what is in it. */
  private async open(file: File, isListed = false): Promise<void> {
    const text = await file.text();
    const words = tooLong(text);
    if (words) return this.refuse(`${file.name} was not opened: ${words}.`);
    if (isListed || isListing(text)) return this.listing.read(file.name, text);
    this.run(file.name, text);
  }

  private refuse(words: string): void {
    this.tell([{ line: null, words }]);
  }

  /** The file that the program is of. */
  get title(): string {
    return this.isChanged ? `${this.name}, changed` : this.name;
  }

  private change(): void {
    this.isChanged = true;
    this.outdate();
    this.whatIf.move();
  }

  private changeSettings(): void {
    tellOfSettings(undefined);
    this.outdate();
    this.whatIf.look();
  }

  /** Enters settings as a person does. */
  private set(lines: string): void {
    this.settings.value = lines;
    this.settings.dispatchEvent(new Event("input"));
  }

  private keep(lines: string): void {
    this.set(lines);
    this.start();
  }

  private run(name: string, text: string): void {
    this.load(name, text);
    this.start();
  }

  private load(name: string, text: string): void {
    this.name = name;
    this.isChanged = false;
    this.editor.load(text);
    this.outdate();
    this.whatIf.move();
  }

  /** What is shown belongs to the text and the settings from which it was made. */
  private outdate(): void {
    this.changed();
    this.axes.say("");
    if (part("results").dataset["state"] !== "ended") return;
    part("results").dataset["state"] = "outdated";
    this.say("The program or its settings have changed since this was run: run it again.");
  }

  /** The settings of the machine, as lines. */
  get settingsLines(): string {
    return this.settings.value;
  }

  private start(): void {
    this.playback.stop();
    this.advice.clear();
    this.tell([]);
    tellOfSettings(undefined);
    part("results").dataset["state"] = "running";
    this.motion = new Motion();
    this.motion.isRotary = isRotary(read(this.settingsLines));
    this.began = performance.now();
    this.setBusy(true);
    this.say("The machine homes and runs in virtual time.");
    run(this.task, this.editor.bytes, this.settingsLines, "lines", this.watcher());
  }

  private watcher(): Watcher {
    return {
      progress: (answered, lines, seconds) => this.tellProgress(answered, lines, seconds),
      motion: (pieces) => pieces.forEach((piece) => this.motion.add(piece)),
      rows: () => {},
      lines: (lineTimes) => this.motion.addLines(lineTimes),
      ended: (summary, wallSeconds) => void this.show(summary, wallSeconds),
      trouble: (trouble) => this.fail(trouble),
    };
  }

  private tellProgress(answered: number, lines: number, seconds: number): void {
    element("progress", HTMLProgressElement).value = lines ? answered / lines : 0;
    const passed = (performance.now() - this.began) / 1000;
    const rest = answered ? (lines - answered) / answered : 0;
    const left = rest ? `, some ${duration(Math.ceil(seconds * rest), 0)} left of it; here ${duration(passed, 0)}, some ${duration(Math.ceil(passed * rest), 0)} left` : "";
    this.say(`${((100 * answered) / Math.max(lines, 1)).toFixed(0)} %: ${answered} of ${lines} lines, ${duration(seconds)} of machine time${left}`);
    const now = performance.now();
    if (now < this.drawNextAt) return;
    this.drawNextAt = Infinity;
    void this.draw().then(() => {
      this.drawNextAt = performance.now() + Math.max(PICTURE_EVERY_MS, 9 * (performance.now() - now));
    });
  }

  private stop(words: string): void {
    this.task.cancel();
    this.setBusy(false);
    this.say(words);
    part("results").dataset["state"] = "none";
  }

  private fail(trouble: Trouble): void {
    this.stop("It could not be run.");
    forgetChecks();
    const isOfSettings = trouble.about === "settings";
    this.tell(isOfSettings ? [] : [trouble]);
    tellOfSettings(isOfSettings ? trouble : undefined);
  }

  private setBusy(isBusy: boolean): void {
    button("run").disabled = isBusy;
    for (const kind of ["trace", "waves", "report"]) button(`save-${kind}`).disabled = isBusy;
    button("cancel").hidden = !isBusy;
    element("progress", HTMLProgressElement).hidden = !isBusy;
  }

  private say(words: string): void {
    part("status").textContent = words;
  }

  private async show(summary: Summary, wallSeconds: number): Promise<void> {
    this.setBusy(false);
    if (this.axes.turns(summary.refusals)) return this.start();
    this.drawNextAt = 0;
    const times = summary.duration_s / Math.max(wallSeconds, 1e-3);
    this.say(`${duration(summary.duration_s)} of machine time, run in ${wallSeconds.toFixed(2)} s: ${times.toFixed(0)} times as fast.`);
    tellFigures(summary, this.motion.isRotary);
    tellChecks(summary);
    const stopped = summary.state === "Idle" ? [] : [{ line: null, words: `The machine ended in ${summary.state}` }];
    const refused = summary.refusals.map(({ line, text, code, words }) => ({ line, words: `\`${text.trim()}\`: error:${code} ${words}` }));
    this.tell([...refused, ...stopped]);
    this.travel = summary.travel_mm;
    const { motion } = this;
    this.curves.show(motion);
    // One after the other, so that the page answers in between.
    await new Breath().take();
    if (motion !== this.motion) return;
    this.playback.show(motion);
    part("shaped-note").hidden = !motion.isShaped;
    this.advice.look(this.editor.bytes, this.settingsLines);
    this.whatIf.look();
    await this.draw();
    if (motion === this.motion) part("results").dataset["state"] = "ended";
  }

  /** The run is looked at, or no more: the picture may show the machine meanwhile. */
  showRun(isLooked: boolean): void {
    this.isLooked = isLooked;
    if (isLooked) void this.draw();
  }

  private async draw(): Promise<void> {
    if (!this.isLooked) return;
    part("picture").dataset["of"] = "run";
    await this.picture.show({ motion: this.motion, travel: this.travel });
    this.drawMoment();
  }

  private drawMoment(): void {
    if (this.isLooked) this.picture.at({ made: this.time, tool: this.motion.isHomingAt(this.time) ? undefined : this.motion.places(this.time) });
  }

  /** Shows the machine at a time. */
  private look(time: number, isMoved: boolean): void {
    this.time = time;
    this.drawMoment();
    this.curves.at(time);
    this.editor.mark(isMoved ? this.motion.lineAt(time) : 0, isMoved);
  }

  /** Goes to a line, and to when it moves the machine. */
  private go(line: number): void {
    const time = this.motion.timeOf(line);
    if (time !== undefined) this.playback.go(time);
    this.editor.go(line);
  }

  private tell(troubles: Trouble[]): void {
    this.editor.tell(troubles.flatMap(({ line, words }) => (line ? [{ line, words }] : [])));
    const reported = troubles.slice(0, REPORTED_MAX).map(({ line, words }) => {
      const item = made("li", "");
      const place = line ? `line ${line} ` : "";
      item.append(...linked(`${place}${words.replace(/^line \d+: /, "")}`, (chosen) => this.go(chosen)));
      return item;
    });
    if (troubles.length > REPORTED_MAX) reported.push(made("li", `and ${troubles.length - REPORTED_MAX} more`));
    part("troubles").replaceChildren(...reported);
  }
}
