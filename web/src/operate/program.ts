// The lines of a program, as they are sent.

export interface ProgramLine {
  /** From 1, as in the editor. */
  number: number;
  text: string;
}

/** Characters of a line that the machine takes, without spaces. */
const CHARACTERS_MAX = 79;

/** Without comments and empty lines. */
export function linesOf(program: string): ProgramLine[] {
  const lines = program.split(/\r\r\n|\r\n|\r|\n/).map((text, index) => ({ number: index + 1, text: text.replace(/;.*|\([^)]*\)/g, "").trim() }));
  return lines.filter(({ text }) => text);
}

/** The first line with a byte that would act at once. */
export const realTime = (lines: ProgramLine[]): ProgramLine | undefined => lines.find(({ text }) => /[?!~]/.test(text));

/** With its number as N, so that the machine reports which line is under way. A program with N of its own keeps it. */
export function numbered(lines: ProgramLine[]): ProgramLine[] {
  if (lines.some(({ text }) => /^[^$]*N\s*\d/i.test(text))) return lines;
  return lines.map(({ number, text }) => {
    const named = `N${number} ${text}`;
    const isTaken = /^[$%/]/.test(text) || named.replace(/\s/g, "").length > CHARACTERS_MAX;
    return { number, text: isTaken ? text : named };
  });
}
