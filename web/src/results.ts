// What became of a program: its figures, and every promise.

import { placesInWords } from "./axes";
import { duration, made, part } from "./elements";
import type { Summary } from "./messages";

export function tellFigures(summary: Summary, isRotary: boolean): void {
  const place = placesInWords(summary.position_mm.map((mm, axis) => ({ axis, words: mm.toFixed(2) })), isRotary);
  const rows: [string, string][] = [
    ["the program takes", duration(summary.duration_s - summary.homing_s)],
    ["homing", summary.homing_s ? duration(summary.homing_s) : "none"],
    ["moves", summary.moves.toLocaleString("en")],
    ["steps", summary.steps.toLocaleString("en")],
    ["ends at", place],
  ];
  part("figures").replaceChildren(
    ...rows.map(([name, value]) => {
      const row = made("div", "");
      row.append(made("dt", name), made("dd", value));
      return row;
    }),
  );
  const pauses = summary.pauses.map(({ line, text, comment }) => `line ${line} \`${text.trim()}\`${comment ? ` (${comment})` : ""} waited for a person, and was resumed at once`);
  part("pauses").replaceChildren(...pauses.map((words) => made("li", words)));
}

/** Nothing was run, so nothing is kept or broken. */
export function forgetChecks(): void {
  part("checks-total").textContent = "";
  for (const id of ["figures", "pauses", "checks"]) part(id).replaceChildren();
}

export function tellChecks({ verdicts }: Summary): void {
  const broken = verdicts.filter((verdict) => !verdict.kept).length;
  part("checks-total").textContent = broken ? `${broken} of ${verdicts.length} broken` : `all ${verdicts.length} kept`;
  part("checks-total").className = broken ? "broken" : "kept";
  part("checks").replaceChildren(
    ...verdicts.map(({ kept, promise, detail }) => {
      const row = made("tr", "");
      const name = made("th", promise);
      name.setAttribute("scope", "row");
      row.append(made("td", kept ? "kept" : "broken", kept ? "kept" : "broken"), name, made("td", detail, "found"));
      return row;
    }),
  );
}
