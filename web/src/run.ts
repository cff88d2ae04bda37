// Runs a program in virtual time, and shows what became of it.

import { area, button, duration, element, input, made, part, save, select } from "./elements";
import { Curves } from "./curves";
import { Editor } from "./editor";
import { JobRunner, type Watcher } from "./job";
import type { Summary, Trouble } from "./messages";
import { AXIS_NAMES, Motion } from "./motion";
import { PathPicture } from "./path";
import { Playback } from "./playback";

/** Ours, with what each shows. */
const PROGRAMS: [string, string][] = [
  ["parking.nc", "a car park: homing, three axes"],
  ["arcs.nc", "arcs and corners"],
  ["square.nc", "a square"],
  ["diagonal.nc", "one long diagonal"],
  ["engraving.nc", "an engraving of short moves"],
  ["ringing.nc", "stops and corners"],
];
/** Problems that are told one by one. */
const TOLD_MAX = 50;
/** While a program runs, its path is drawn this often, and for no more than a tenth of the time. */
const PICTURE_EVERY_MS = 300;

export class Run {
  readonly editor = new Editor();
  private readonly settings = area("settings");
  private readonly jobs = new JobRunner();
  private readonly path = new PathPicture();
  private readonly curves = new Curves((time) => this.playback.go(time));
  private readonly playback = new Playback((time) => {
    this.path.at(time);
    this.curves.at(time);
  });
  private motion = new Motion();
  private name = "program.nc";
  private drawNextAt = 0;

  constructor() {
    const list = select("programs");
    for (const [file, words] of PROGRAMS) list.add(new Option(`${file}: ${words}`, file));
    list.onchange = () => void this.fetch(list.value);
    button("run").onclick = () => this.start();
    button("cancel").onclick = () => this.stop("Cancelled.");
    button("save-trace").onclick = () => this.saveTrace();
    button("save-picture").onclick = () => void this.path.file().then((file) => file && save(`${this.stem}.png`, file));
    select("plane").onchange = () => this.path.look(select("plane").value);
    this.takeFiles();
    void this.fetch("parking.nc").then(() => this.start());
  }

  /** The settings of the machine, as lines. */
  get settingsLines(): string {
    return this.settings.value;
  }

  private get stem(): string {
    return this.name.replace(/\.[^.]*$/, "");
  }

  private async fetch(name: string): Promise<void> {
    const answer = await fetch(new URL(`programs/${name}`, document.baseURI));
    this.name = name;
    this.editor.load(await answer.text());
  }

  private takeFiles(): void {
    const chosen = input("file");
    const take = async (file: File | undefined): Promise<void> => {
      if (!file) return;
      this.name = file.name;
      this.editor.load(await file.text());
    };
    chosen.onchange = () => void take(chosen.files?.[0]);
    button("open").onclick = () => chosen.click();
    const place = part("drop");
    for (const kind of ["dragenter", "dragover"]) {
      place.addEventListener(kind, (event) => {
        event.preventDefault();
        place.classList.add("over");
      });
    }
    place.addEventListener("dragleave", () => place.classList.remove("over"));
    place.addEventListener("drop", (event) => {
      event.preventDefault();
      place.classList.remove("over");
      void take(event.dataTransfer?.files[0]);
    });
  }

  private start(): void {
    this.playback.stop();
    this.editor.mark([]);
    part("troubles").replaceChildren();
    part("results").dataset["state"] = "running";
    this.motion = new Motion();
    this.setBusy(true);
    this.say("The machine homes and runs in virtual time.");
    this.jobs.run(this.editor.value, this.settingsLines, false, this.watcher());
  }

  private watcher(): Watcher {
    return {
      progress: (answered, lines, seconds) => {
        element("progress", HTMLProgressElement).value = lines ? answered / lines : 0;
        this.say(`${answered} of ${lines} lines, ${duration(seconds)} of machine time`);
        const now = performance.now();
        if (now > this.drawNextAt) {
          this.path.show(this.motion, []);
          this.drawNextAt = performance.now() + Math.max(PICTURE_EVERY_MS, 9 * (performance.now() - now));
        }
      },
      motion: (columns) => this.motion.add(columns),
      trace: () => {},
      ended: (summary, wallSeconds) => this.show(summary, wallSeconds),
      trouble: (trouble) => {
        this.stop("It could not be run.");
        this.tell([trouble]);
      },
    };
  }

  private stop(words: string): void {
    this.jobs.cancel();
    this.setBusy(false);
    this.say(words);
    part("results").dataset["state"] = "none";
  }

  private setBusy(isBusy: boolean): void {
    button("run").disabled = isBusy;
    button("cancel").hidden = !isBusy;
    element("progress", HTMLProgressElement).hidden = !isBusy;
  }

  private say(words: string): void {
    part("status").textContent = words;
  }

  private show(summary: Summary, wallSeconds: number): void {
    this.setBusy(false);
    const broken = summary.verdicts.filter((verdict) => !verdict.kept).length;
    const times = summary.duration_s / Math.max(wallSeconds, 1e-3);
    this.say(`${duration(summary.duration_s)} of machine time, run in ${wallSeconds.toFixed(2)} s: ${times.toFixed(0)} times as fast.`);
    this.path.show(this.motion, summary.travel_mm);
    this.curves.show(this.motion);
    this.playback.show(this.motion);
    part("shaped-note").hidden = !this.motion.isShaped;
    this.figures(summary);
    this.checks(summary, broken);
    const stopped = summary.state === "Idle" ? [] : [{ line: null, words: `The machine ended in ${summary.state}` }];
    const refused = summary.refusals.map(({ line, text, code, words }) => ({ line, words: `\`${text.trim()}\`: error:${code} ${words}` }));
    this.tell([...refused, ...stopped]);
    part("results").dataset["state"] = "ended";
  }

  private figures(summary: Summary): void {
    const place = summary.position_mm.map((mm, axis) => `${AXIS_NAMES[axis]} ${mm.toFixed(2)}`).join(", ");
    const rows: [string, string][] = [
      ["the program takes", duration(summary.duration_s - summary.homing_s)],
      ["homing", summary.homing_s ? duration(summary.homing_s) : "none"],
      ["moves", summary.moves.toLocaleString("en")],
      ["steps", summary.steps.toLocaleString("en")],
      ["ends at", `${place} mm`],
    ];
    part("figures").replaceChildren(
      ...rows.map(([name, value]) => {
        const row = made("div", "");
        row.append(made("dt", name), made("dd", value));
        return row;
      }),
    );
    const pauses = summary.pauses.map((pause) => `line ${pause.line} \`${pause.text.trim()}\` waited for a person, and was resumed at once`);
    part("pauses").replaceChildren(...pauses.map((words) => made("li", words)));
  }

  private checks(summary: Summary, broken: number): void {
    part("checks-total").textContent = broken ? `${broken} of ${summary.verdicts.length} broken` : `all ${summary.verdicts.length} kept`;
    part("checks-total").className = broken ? "broken" : "kept";
    part("checks").replaceChildren(
      ...summary.verdicts.map((verdict) => {
        const row = made("tr", "");
        row.append(
          made("td", verdict.kept ? "kept" : "broken", verdict.kept ? "kept" : "broken"),
          made("th", verdict.promise),
          made("td", verdict.detail, "found"),
        );
        row.querySelector("th")?.setAttribute("scope", "row");
        return row;
      }),
    );
  }

  private tell(troubles: Trouble[]): void {
    this.editor.mark(troubles.flatMap(({ line }) => (line ? [line] : [])));
    const told = troubles.slice(0, TOLD_MAX).map(({ line, words }) => {
      const item = made("li", "");
      if (line) {
        const go = made("button", `line ${line}`, "link") as HTMLButtonElement;
        go.type = "button";
        go.onclick = () => this.editor.go(line);
        item.append(go, " ");
      }
      item.append(words.replace(/^line \d+: /, ""));
      return item;
    });
    if (troubles.length > TOLD_MAX) told.push(made("li", `and ${troubles.length - TOLD_MAX} more`));
    part("troubles").replaceChildren(...told);
  }

  /** Runs the program once more, and saves every step. Equal runs are equal to the byte. */
  private saveTrace(): void {
    const rows: Uint8Array[] = [];
    this.setBusy(true);
    this.jobs.run(this.editor.value, this.settingsLines, true, {
      ...this.watcher(),
      motion: () => {},
      progress: (answered, lines) => this.say(`The trace: ${answered} of ${lines} lines`),
      trace: (more) => void rows.push(more),
      ended: () => {
        this.setBusy(false);
        this.say("The trace is saved.");
        save(`${this.stem}.csv`, new Blob(rows as BlobPart[], { type: "text/csv" }));
      },
    });
  }
}
