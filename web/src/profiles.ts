// The speed profiles side by side, for a move with numbers of one's own.

import { Charts, type Data } from "./charts";
import { element, input, made, part } from "./elements";
import { Task } from "./job";
import type { Profiles } from "./messages";

const NAMES = ["Speed, mm/s", "Acceleration, mm/s²", "Jerk, mm/s³"];
/** As many colours as speed profiles. */
const COLOURS = ["x", "y", "z", "tool", "speed-profile-5", "speed-profile-6", "muted"];

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

export class SpeedProfiles {
  private readonly task = new Task();
  private charts: Charts | undefined;
  private profiles: Profiles | undefined;
  private end = 1;

  constructor() {
    const form = element("profiles-form", HTMLFormElement);
    form.oninput = () => this.ask();
    form.onsubmit = (event) => {
      event.preventDefault();
      this.ask();
    };
  }

  /** Shows them when they are first looked at. */
  look(): void {
    if (!this.profiles) this.ask();
  }

  private ask(): void {
    const number = (name: string): number => input(`profile-${name}`).valueAsNumber;
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
      { do: "profiles", asked: Object.values(asked) },
      (said) => {
        if (said.is === "profiles") this.show(said.profiles, asked);
        return true;
      },
      (trouble) => this.say(trouble.words),
    );
  }

  private say(words: string): void {
    part("profiles-trouble").textContent = words;
  }

  private show(profiles: Profiles, asked: Asked): void {
    this.profiles = profiles;
    this.say(profiles.names.length ? "" : "No speed profile can make this move.");
    part("profiles-refused").replaceChildren(...profiles.refused.map(({ name, words }) => made("li", `${name}: ${words}`)));
    part("profiles-command").textContent = command(profiles.names, asked);
    this.table(profiles);
    this.end = Math.max(...profiles.curves.map(({ times }) => times.at(-1) ?? 0), 1e-3);
    part("profiles-charts").replaceChildren();
    const lines = profiles.names.map((name, index) => ({ name, colour: colourOf(index) }));
    this.charts = new Charts(part("profiles-charts"), NAMES.map((name) => ({ name, lines })), {
      data: () => data(profiles),
      zoomed: (from, to) => this.charts?.show(from, to),
      picked: () => this.charts?.show(0, this.end),
    });
    this.charts.show(0, this.end);
  }

  private table({ names, rows }: Profiles): void {
    const head = made("tr", "");
    head.append(made("td", ""), ...names.map(keyed));
    const body = rows.map(({ name, cells }) => {
      const row = made("tr", "");
      row.append(made("th", name), ...cells.map((cell) => made("td", cell, "number")));
      return row;
    });
    part("profiles-rows").replaceChildren(head, ...body);
  }
}

const colourOf = (index: number): string => COLOURS[index % COLOURS.length] ?? "ink";

/** A name with the colour of its lines. */
function keyed(name: string, index: number): HTMLElement {
  const head = made("th", "");
  const line = made("i", "", "line");
  line.style.background = `var(--${colourOf(index)})`;
  head.append(line, name);
  return head;
}

/** What prints the same figures. */
function command(names: string[], asked: Asked): string {
  const steps = (mm: number): number => Number((mm * asked.stepsPerMm).toPrecision(12));
  const jerk = names.includes("s-curve") ? ` --jerk ${steps(asked.jerkMmS3)}` : "";
  const start = asked.startMmS ? ` --start-speed ${steps(asked.startMmS)}` : "";
  return `isostep profile --speed-profile ${names.join(",")} --steps ${Math.round(steps(asked.distanceMm))}${start} --top-speed ${steps(asked.topMmS)} --accel ${steps(asked.accelMmS2)} --decel ${steps(asked.decelMmS2)}${jerk}`;
}

/** The curves of all speed profiles over the times of all: between its own times each is a straight line. */
function data({ curves }: Profiles): Data[] {
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
