// Lines that no machine and no editor would take.

/** Characters. The machine takes far fewer; comments may have more. */
const LINE_MAX = 65_536;

/** What is wrong with a text that has a longer line, in words. */
export function tooLong(text: string): string | undefined {
  let from = 0;
  for (let line = 1; from <= text.length; line++) {
    const found = text.indexOf("\n", from);
    const end = found < 0 ? text.length : found;
    if (end - from > LINE_MAX) {
      return `line ${line} has ${(end - from).toLocaleString("en")} characters, and a line has ${LINE_MAX.toLocaleString("en")} at most: it is no G-code, or its line ends are lost`;
    }
    from = end + 1;
  }
  return undefined;
}
