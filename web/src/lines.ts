// Words in which each line of the program that they name is a button.

import { made } from "./elements";

/** Calls `go` with the number of a line that is chosen. */
export function linked(words: string, go: (line: number) => void): (string | HTMLElement)[] {
  return words.split(/(\blines? \d+)/).map((piece) => {
    const line = Number(/^lines? (\d+)$/.exec(piece)?.[1]);
    if (!line) return piece;
    const button = made("button", piece, "link") as HTMLButtonElement;
    button.type = "button";
    button.onclick = () => go(line);
    return button;
  });
}
