// A choice among what a setting may be, for all axes.

import { made } from "../elements";
import { Control } from "./control";
import type { Rows } from "./knobs";

export class Choice extends Control {
  private readonly select = document.createElement("select");

  constructor(numbers: number[], rows: Rows, changed: () => void) {
    super(numbers, rows);
    const label = made("label", "");
    for (const [value, name] of this.row.options) this.select.add(new Option(name, String(value)));
    this.select.onchange = changed;
    this.select.dataset["number"] = String(this.first);
    label.append(made("span", this.name), this.select);
    this.element.append(label);
  }

  get value(): number {
    return Number(this.select.value);
  }

  get changes(): [number, number][] {
    const isMoved = this.value !== this.values.get(this.first);
    return isMoved ? this.numbers.map((number): [number, number] => [number, this.value]) : [];
  }

  back(): void {
    this.select.value = String(this.values.get(this.first));
  }

  enable(): void {}
}
