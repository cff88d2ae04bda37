// What becomes of how exactly and how quietly a program is made, as rows of a table: as it is set, and then.

import { made } from "../elements";
import type { Known } from "./trial";

type Figure = [name: string, of: (known: Known) => number | null | undefined];

const FIGURES: Figure[] = [
  ["corners are left by", ({ found }) => found?.corners_mm],
  ["ends of short moves taken together, beside their line by", ({ found }) => found?.together_mm],
  ["shapers leave that path by", ({ found }) => found?.shaped_mm],
  ["the load swings after stops by", ({ swings }) => swings?.after_stops_mm],
  ["the load is off after corners by", ({ swings }) => swings?.after_corners_mm],
];

/** A row for each figure that either has: the most of it in the program. */
export function figures(before: Known, after: Known): HTMLElement[] {
  return FIGURES.flatMap(([name, of]) => {
    const values = [of(before), of(after)];
    if (values.every((value) => typeof value !== "number")) return [];
    const row = made("tr", "");
    const head = made("th", name);
    head.setAttribute("scope", "row");
    row.append(head, ...values.map((value) => made("td", typeof value === "number" ? `${value.toFixed(4)} mm` : "–", "number")));
    return [row];
  });
}
