// Rows of what the tool says: a name, words, and the places that they are about.

import { made } from "./elements";
import type { CheckRow } from "./messages";

/** A row of a table. `worded` makes what is shown of words. */
export function rowOf({ name, words, places }: CheckRow, worded: (words: string) => (string | HTMLElement)[]): HTMLElement {
  const row = made("tr", "");
  const head = made("th", name);
  head.setAttribute("scope", "row");
  const said = made("td", "");
  said.append(...worded(words));
  if (places.length) {
    const list = made("ul", "");
    list.append(...places.map((place) => {
      const item = made("li", "");
      item.append(...worded(place));
      return item;
    }));
    said.append(list);
  }
  row.append(head, said);
  return row;
}
