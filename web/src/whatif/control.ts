// What knobs and choices have in common: some settings, moved together, and how they are called.

import { made } from "../elements";
import type { SettingRow } from "../messages";
import type { Rows, Values } from "./knobs";

export abstract class Control {
  readonly element = made("div", "", "knob");
  protected values = new Map<number, number>();

  /** `along` go with the others where they are not 0, as then they follow anyway. */
  constructor(
    protected readonly numbers: number[],
    protected readonly rows: Rows,
    private readonly along: number[] = [],
  ) {}

  /** The settings in force. What was moved is forgotten. */
  set(inForce: Values): void {
    const value = (number: number): number => Number(inForce.get(number) ?? this.rows.get(number)?.default);
    this.values = new Map([...this.numbers, ...this.along].map((number) => [number, value(number)]));
    this.back();
  }

  /** The settings that it has moved. */
  abstract get changes(): [number, number][];
  abstract back(): void;
  /** Whether it matters, as others are set. */
  abstract enable(): void;

  /** Those that it moves. */
  protected get all(): number[] {
    return [...this.numbers, ...this.along.filter((number) => this.values.get(number))];
  }

  protected get row(): SettingRow {
    const row = this.rows.get(this.first);
    if (!row) throw new Error(`the machine has no $${this.first}`);
    return row;
  }

  protected get first(): number {
    return this.numbers[0] ?? 0;
  }

  /** "Acceleration of X and Y", by the names of the rows. */
  protected get name(): string {
    const [axis, ...words] = this.row.name.split(" ");
    const isOfAxes = /^[A-Z]$/.test(axis ?? "");
    const axes = this.numbers.map((number) => this.rows.get(number)?.name[0]);
    const name = isOfAxes ? `${words.join(" ")} of ${axes.join(", ").replace(/, (.)$/, " and $1")}` : this.row.name;
    return name.replace(/^./, (letter) => letter.toUpperCase());
  }
}
