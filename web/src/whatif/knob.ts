// A slider and a number for one setting, or for one of several axes.

import { made } from "../elements";
import { unitInSigns } from "../units";
import { Control } from "./control";
import type { Rows } from "./knobs";
import { factorAt, placeOf, rounded, STEP } from "./scale";

export class Knob extends Control {
  private readonly slider = document.createElement("input");
  private readonly number = document.createElement("input");
  private readonly others = made("small", "");

  constructor(
    numbers: number[],
    along: number[],
    rows: Rows,
    changed: () => void,
    private readonly isUsed: () => boolean,
  ) {
    super(numbers, rows, along);
    const { min, max, unit } = this.row;
    Object.assign(this.slider, { type: "range", min: "-1", max: "1", step: String(STEP) });
    Object.assign(this.number, { type: "number", min: String(min), max: String(max), step: "any" });
    this.number.dataset["number"] = String(this.first);
    this.slider.setAttribute("aria-label", this.name);
    this.slider.oninput = () => {
      this.number.value = String(this.atSlider);
      this.tell(this.atSlider);
      changed();
    };
    this.number.oninput = () => {
      this.slide(this.number.valueAsNumber);
      changed();
    };
    const label = made("label", "");
    label.append(made("span", unit ? `${this.name}, ${unitInSigns(unit)}` : this.name), this.number);
    this.element.append(label, this.slider, this.others);
  }

  get changes(): [number, number][] {
    const value = this.number.valueAsNumber;
    if (this.number.disabled || Number.isNaN(value) || value === this.inForce) return [];
    return this.all.map((number): [number, number] => [number, this.scaled(number, value)]).filter(([number, moved]) => moved !== this.values.get(number));
  }

  back(): void {
    this.number.value = String(this.inForce);
    this.slide(this.inForce);
  }

  enable(): void {
    const isUsed = this.isUsed();
    this.number.disabled = !isUsed;
    this.slider.disabled = !isUsed;
    this.element.classList.toggle("unused", !isUsed);
  }

  private get inForce(): number {
    return this.values.get(this.first) ?? NaN;
  }

  /** What the slider's middle is: the value in force, or what 0 would be by default. */
  private get middle(): number {
    return this.inForce || Number(this.row.default) || this.row.min || 1;
  }

  private get atSlider(): number {
    const place = this.slider.valueAsNumber;
    return place === 0 ? this.inForce : this.within(this.first, rounded(this.middle * factorAt(place)));
  }

  private slide(value: number): void {
    this.slider.value = String(value > 0 ? placeOf(value / this.middle) : -1);
    this.tell(value);
  }

  private tell(value: number): void {
    this.element.classList.toggle("moved", value !== this.inForce);
    const named = this.all.map((number) => [number, this.scaled(number, value)]);
    this.others.textContent = named.map(([number, moved]) => (moved === value ? `$${number}` : `$${number} ${moved}`)).join(", ");
  }

  /** What another axis has then: in the same ratio as now. */
  private scaled(number: number, value: number): number {
    const [own, first] = [this.values.get(number) ?? 0, this.inForce];
    if (number === this.first || own === first) return value;
    return own && first && value ? this.within(number, rounded((own * value) / first)) : value;
  }

  private within(number: number, value: number): number {
    const { min, max } = this.rows.get(number) ?? this.row;
    return Math.max(min, Math.min(max, value));
  }
}
