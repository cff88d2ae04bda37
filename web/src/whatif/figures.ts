// What becomes of how exactly and how quietly a program is made, as rows of a table: as it is set, and then.

import { made } from "../elements";
import type { Swings } from "../messages";
import type { Known } from "./trial";

/** Null if there is nothing of the kind, undefined while it is not known. */
type Figure = [name: string, of: (known: Known) => number | null | undefined];

const FIGURES: Figure[] = [
  ["corners are left by", ({ found }) => found?.corners_mm],
  ["ends of short moves taken together, beside their line by", ({ found }) => found?.together_mm],
  ["shapers leave that path by", ({ found }) => found?.shaped_mm],
  ["the load swings after stops by", (known) => swing(known, "after_stops_mm")],
  ["the load is off after corners by", (known) => swing(known, "after_corners_mm")],
];

const swing = ({ swings, unknown }: Known, which: keyof Swings): number | null | undefined => (unknown === undefined ? swings?.[which] : null);

function shown(value: number | null | undefined): string {
  if (value === undefined) return "…";
  return value === null ? "–" : `${value.toFixed(4)} mm`;
}

/** A row for each figure that either has: the most of it in the program. */
export function figures(before: Known, after: Known): HTMLElement[] {
  return FIGURES.flatMap(([name, of]) => {
    const values = [of(before), of(after)];
    if (values.every((value) => typeof value !== "number")) return [];
    const row = made("tr", "");
    const head = made("th", name);
    head.setAttribute("scope", "row");
    row.append(head, ...values.map((value) => made("td", shown(value), "number")));
    return [row];
  });
}
