// A setting of the form: what it is, what it is now, and what was made of it.

import { made } from "../elements";
import type { SettingRow } from "../messages";
import { unitInSigns } from "../units";
import { control, type Control } from "./control";
import { isEqual } from "./lines";

export class Row {
  readonly element = made("div", "", "setting");
  private readonly control: Control;
  private readonly refusal = made("p", "", "refused");
  private readonly byDefault = made("span", "", "default");
  private inForce = "";

  constructor(
    readonly about: SettingRow,
    changed: () => void,
  ) {
    const { number, name, unit } = about;
    this.control = control(about, `$${number} ${name}${unit && `, ${unitInSigns(unit)}`}`, () => {
      this.refuse("");
      this.mark();
      changed();
    });
    this.element.dataset["number"] = String(number);
    const what = made("div", "", "what");
    what.append(made("span", name, "name"), made("small", this.remark), this.refusal);
    const value = made("div", "", "value");
    value.append(this.control.element, made("span", unitInSigns(unit), "unit"));
    this.refusal.setAttribute("role", "alert");
    this.element.append(made("code", `$${number}`), what, value, this.byDefault);
    this.refuse("");
  }

  private get remark(): string {
    const { kind, remark, min, max, unit } = this.about;
    const hasRange = ["whole", "number"].includes(kind) && Number.isFinite(max);
    const range = min === max ? `only ${min}` : `${min} to ${max} ${unitInSigns(unit)}`.trim();
    return [remark, hasRange ? range : ""].filter(Boolean).join("; ");
  }

  get value(): string {
    return this.control.value;
  }

  get isChanged(): boolean {
    return !isEqual(this.value, this.inForce);
  }

  get isDefault(): boolean {
    return isEqual(this.inForce, this.about.default);
  }

  /** As a person reads a change. */
  get change(): string {
    const { number, name, unit } = this.about;
    return `$${number} ${name}: ${this.inForce} → ${this.value} ${unitInSigns(unit)}`.trim();
  }

  /** What the machine has now. What a person has entered, or is typing, stays until it is sent. */
  set(inForce: string): void {
    const isTyped = this.value !== this.inForce && this.control.element.matches("input:focus");
    const isEntered = this.isChanged || isTyped;
    this.inForce = short(inForce);
    if (!isEntered) this.control.value = this.inForce;
    this.mark();
  }

  enter(value: string): void {
    this.control.value = value;
    this.refuse("");
    this.mark();
  }

  discard(): void {
    this.enter(this.inForce);
  }

  refuse(words: string): void {
    this.refusal.textContent = words;
    this.refusal.hidden = !words;
  }

  private mark(): void {
    this.element.classList.toggle("changed", this.isChanged);
    this.element.classList.toggle("differs", !this.isDefault);
    this.byDefault.textContent = this.isDefault || !this.about.default ? "" : `default ${short(this.about.default)}`;
  }
}

/** Without the zeros that the machine prints behind the point. */
const short = (value: string): string => value.replace(/(\.\d*?)0+$/, "$1").replace(/\.$/, "");
