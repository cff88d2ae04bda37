// The speed laws side by side, for a move with numbers of one's own.

import { Charts, type Data } from "./charts";
import { element, input, made, part } from "./elements";
import { Task } from "./job";
import type { Laws } from "./messages";

const NAMES = ["Speed, mm/s", "Acceleration, mm/s²", "Jerk, mm/s³"];
/** As many colours as laws. */
const COLOURS = ["x", "y", "z", "tool", "law-5", "law-6", "muted"];

/** A move, in mm and s, in the order in which the machine takes it. */
interface Asked {
  distanceMm: number;
  stepsPerMm: number;
  startMmS: number;
  topMmS: number;
  accelMmS2: number;
  decelMmS2: number;
  jerkMmS3: number;
}

export class SpeedLaws {
  private readonly task = new Task();
  private charts: Charts | undefined;
  private laws: Laws | undefined;
  private end = 1;

  constructor() {
    const form = element("laws-form", HTMLFormElement);
    form.oninput = () => this.ask();
    form.onsubmit = (event) => {
      event.preventDefault();
      this.ask();
    };
  }

  /** Shows them when they are first looked at. */
  look(): void {
    if (!this.laws) this.ask();
  }

  private ask(): void {
    const number = (name: string): number => input(`law-${name}`).valueAsNumber;
    const asked: Asked = {
      distanceMm: number("distance"),
      stepsPerMm: number("steps"),
      startMmS: number("start") / 60,
      topMmS: number("top") / 60,
      accelMmS2: number("accel"),
      decelMmS2: number("decel"),
      jerkMmS3: number("jerk"),
    };
    if (Object.values(asked).some(Number.isNaN)) return this.say("Every field takes a number.");
    this.task.ask(
      { do: "laws", asked: Object.values(asked) },
      (said) => {
        if (said.is === "laws") this.show(said.laws, asked);
        return true;
      },
      (trouble) => this.say(trouble.words),
    );
  }

  private say(words: string): void {
    part("laws-trouble").textContent = words;
  }

  private show(laws: Laws, asked: Asked): void {
    this.laws = laws;
    this.say(laws.names.length ? "" : "No law can make this move.");
    part("laws-refused").replaceChildren(...laws.refused.map(({ name, words }) => made("li", `${name}: ${words}`)));
    part("laws-command").textContent = command(laws.names, asked);
    this.table(laws);
    this.end = Math.max(...laws.curves.map(({ times }) => times.at(-1) ?? 0), 1e-3);
    part("laws-charts").replaceChildren();
    const lines = laws.names.map((name, index) => ({ name, colour: COLOURS[index % COLOURS.length] ?? "ink" }));
    this.charts = new Charts(part("laws-charts"), NAMES.map((name) => ({ name, lines })), {
      data: () => data(laws),
      zoomed: (from, to) => this.charts?.show(from, to),
      picked: () => this.charts?.show(0, this.end),
    });
    this.charts.show(0, this.end);
  }

  private table({ names, rows }: Laws): void {
    const head = made("tr", "");
    head.append(made("td", ""), ...names.map((name) => made("th", name)));
    const body = rows.map(({ name, cells }) => {
      const row = made("tr", "");
      row.append(made("th", name), ...cells.map((cell) => made("td", cell, "number")));
      return row;
    });
    part("laws-rows").replaceChildren(head, ...body);
  }
}

/** What prints the same figures. */
function command(names: string[], asked: Asked): string {
  const steps = (mm: number): number => Number((mm * asked.stepsPerMm).toPrecision(12));
  const jerk = names.includes("s-curve") ? ` --jerk ${steps(asked.jerkMmS3)}` : "";
  const start = asked.startMmS ? ` --start-speed ${steps(asked.startMmS)}` : "";
  return `isostep profile --law ${names.join(",")} --steps ${Math.round(steps(asked.distanceMm))}${start} --top-speed ${steps(asked.topMmS)} --accel ${steps(asked.accelMmS2)} --decel ${steps(asked.decelMmS2)}${jerk}`;
}

/** The curves of all laws over the times of all: between its own times each is a straight line. */
function data({ curves }: Laws): Data[] {
  const times = [...new Set(curves.flatMap((curve) => curve.times))].sort((one, other) => one - other);
  return (["speed", "accel", "jerk"] as const).map((quantity) => [
    times,
    ...curves.map((curve) => {
      let at = 0;
      return times.map((time) => {
        while (at < curve.times.length && (curve.times[at] ?? 0) < time) at++;
        const [before, after] = [Math.max(0, at - 1), Math.min(at, curve.times.length - 1)];
        const [from, to] = [curve.times[before] ?? 0, curve.times[after] ?? 0];
        if (time > to) return null;
        const share = to > from ? (time - from) / (to - from) : 1;
        return (curve[quantity][before] ?? 0) * (1 - share) + (curve[quantity][after] ?? 0) * share;
      });
    }),
  ]);
}
