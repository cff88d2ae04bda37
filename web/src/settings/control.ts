// How a setting is entered: by a switch, by boxes, by a choice, or as a number.

import { made } from "../elements";
import type { SettingRow } from "../messages";

export interface Control {
  element: HTMLElement;
  /** As it would be sent. */
  value: string;
}

export function control(row: SettingRow, label: string, changed: () => void): Control {
  switch (row.kind) {
    case "switch":
      return toggle(label, changed);
    case "mask":
      return mask(row, label, changed);
    case "choice":
      return choice(row, label, changed);
    default:
      return number(label, changed);
  }
}

function box(name: string, changed: () => void): HTMLInputElement {
  const created = made("input", "") as HTMLInputElement;
  created.type = "checkbox";
  created.setAttribute("aria-label", name);
  created.onchange = changed;
  return created;
}

function toggle(label: string, changed: () => void): Control {
  const element = box(label, changed);
  element.setAttribute("role", "switch");
  return {
    element,
    get value() {
      return element.checked ? "1" : "0";
    },
    set value(text) {
      element.checked = Number(text) === 1;
    },
  };
}

function mask(row: SettingRow, label: string, changed: () => void): Control {
  const element = made("div", "", "bits");
  element.setAttribute("role", "group");
  element.setAttribute("aria-label", label);
  const bits = row.options.map(([bit, name]) => {
    const part = made("label", "", "check");
    const created = box(`${label}: ${name}`, changed);
    part.append(created, name);
    element.append(part);
    return [bit, created] as const;
  });
  return {
    element,
    get value() {
      return String(bits.reduce((sum, [bit, { checked }]) => sum + (checked ? bit : 0), 0));
    },
    set value(text) {
      for (const [bit, created] of bits) created.checked = (Number(text) & bit) !== 0;
    },
  };
}

function choice(row: SettingRow, label: string, changed: () => void): Control {
  const element = made("select", "") as HTMLSelectElement;
  for (const [value, name] of row.options) element.add(new Option(`${value} ${name}`, String(value)));
  element.setAttribute("aria-label", label);
  element.onchange = changed;
  return valued(element);
}

function number(label: string, changed: () => void): Control {
  const element = made("input", "") as HTMLInputElement;
  element.inputMode = "decimal";
  element.autocomplete = "off";
  element.setAttribute("aria-label", label);
  element.oninput = changed;
  return valued(element);
}

function valued(element: HTMLInputElement | HTMLSelectElement): Control {
  return {
    element,
    get value() {
      return element.value.trim();
    },
    set value(text) {
      element.value = text;
    },
  };
}
