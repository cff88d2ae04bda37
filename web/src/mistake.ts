// A mistake in the settings, told at the settings, with its line there.

import { area, element, made, part } from "./elements";
import { linked } from "./lines";
import type { Trouble } from "./messages";
import { reason } from "./settings/lines";

/** Tells it, or nothing. */
export function tellOfSettings(trouble: Trouble | undefined): void {
  const told = part("settings-troubles");
  if (!trouble) return told.replaceChildren();
  element("settings-details", HTMLDetailsElement).open = true;
  const item = made("li", "");
  const place = trouble.line ? `line ${trouble.line} of the settings: ` : "";
  item.append(...linked(`${place}${reason(trouble.words)}`, go));
  told.replaceChildren(item);
}

/** Selects a line of them, from 1. */
function go(line: number): void {
  const text = area("settings");
  const lines = text.value.split("\n");
  const from = lines.slice(0, line - 1).reduce((sum, each) => sum + each.length + 1, 0);
  text.focus();
  text.setSelectionRange(from, from + (lines[line - 1]?.length ?? 0));
}
