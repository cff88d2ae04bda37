// The lines of a program, as they are sent.

export interface ProgramLine {
  /** From 1, as in the editor. */
  number: number;
  text: string;
  /** As it is sent. */
  sent: string;
}

/** Characters of a line that the machine takes, without spaces. */
const CHARACTERS_MAX = 79;

/** Those that say something, without their comments; of a program that computes or calls those that are made of it. */
export function linesOf(program: string, made?: [number: number, text: string][]): ProgramLine[] {
  const lines = made ? made.map(([number, text]) => plain(text, number)) : program.split(/\r\r\n|\r\n|\r|\n/).map((text, index) => plain(text, index + 1));
  return named(lines.filter(({ text }) => text));
}

/** Whether a text has a byte that would act at once: `?`, `!`, `~`, or one of a letter beyond ASCII, as the second of `Ä`. */
export const actsAtOnce = (text: string): boolean => /[?!~\x18]|[^\x00-\x7f]/.test(text);

/** The first line with such a byte. */
export const realTime = (lines: ProgramLine[]): ProgramLine | undefined => lines.find(({ text }) => actsAtOnce(text));

function plain(line: string, number: number): ProgramLine {
  const text = line.replace(/;.*|\([^)]*\)/g, "").trim();
  return { number, text, sent: text };
}

/** With its number as N, so that the machine reports which line is under way. A program with N of its own keeps it. */
function named(lines: ProgramLine[]): ProgramLine[] {
  if (lines.some(({ text }) => /^[^$]*N\s*\d/i.test(text))) return lines;
  return lines.map((line) => {
    const sent = `N${line.number} ${line.text}`;
    const isTaken = /^[$%/]/.test(line.text) || sent.replace(/\s/g, "").length > CHARACTERS_MAX;
    return isTaken ? line : { ...line, sent };
  });
}
