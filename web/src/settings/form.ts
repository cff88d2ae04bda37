// The settings of a machine as a form, in groups.

import { element, input, made, part, select } from "../elements";
import type { SettingRow } from "../messages";
import { Row } from "./row";

const NOT_DESCRIBED = "Not described here";

export class Form {
  rows: Row[] = [];

  constructor(private readonly changed: () => void) {
    for (const id of ["only-differences", "find-setting"]) input(id).oninput = () => this.filter();
    select("setting-group").onchange = () => this.filter();
    element("settings-form", HTMLFormElement).onsubmit = (event) => event.preventDefault();
  }

  /** Rows for what this machine has. */
  show(table: SettingRow[], inForce: ReadonlyMap<number, string>): void {
    const has = new Set(inForce.keys());
    const isBuilt = this.rows.length === has.size && this.rows.every((row) => has.has(row.about.number));
    if (!isBuilt) this.build(described(table, [...has]));
    for (const row of this.rows) row.set(inForce.get(row.about.number) ?? "");
    this.filter();
  }

  private build(table: SettingRow[]): void {
    this.rows = table.map((about) => new Row(about, this.changed));
    const names = [...new Set(table.map((about) => about.group))];
    const chosen = select("setting-group");
    chosen.replaceChildren(new Option("all", ""), ...names.map((name) => new Option(name)));
    part("setting-groups").replaceChildren(...names.map((name) => group(name, this.rows.filter((row) => row.about.group === name))));
  }

  private filter(): void {
    const wanted = input("find-setting").value.trim().toLowerCase();
    for (const row of this.rows) {
      const { number, name, group } = row.about;
      const isFound = `$${number} ${name} ${group}`.toLowerCase().includes(wanted);
      const isHidden = input("only-differences").checked && row.isDefault && !row.isChanged;
      const isElsewhere = ![group, ""].includes(select("setting-group").value);
      row.element.hidden = isHidden || !isFound || isElsewhere;
    }
    for (const group of part("setting-groups").children) {
      if (group instanceof HTMLElement) group.hidden = !group.querySelector(".setting:not([hidden])");
    }
  }
}

function group(name: string, rows: Row[]): HTMLElement {
  const created = made("fieldset", "");
  created.append(made("legend", name), ...rows.map((row) => row.element));
  return created;
}

/** What the machine has, whether it is in the table of this page or not. */
function described(table: SettingRow[], numbers: number[]): SettingRow[] {
  const rows = new Map(table.map((row) => [row.number, row]));
  const other = { group: NOT_DESCRIBED, name: "another firmware's setting", remark: "", unit: "", min: 0, max: Infinity, default: "", kind: "number", options: [] } as const;
  const found = numbers.map((number): SettingRow => rows.get(number) ?? { ...other, options: [], number });
  const groups = [...new Set(table.map((row) => row.group)), NOT_DESCRIBED];
  return found.sort((a, b) => groups.indexOf(a.group) - groups.indexOf(b.group) || a.number - b.number);
}
