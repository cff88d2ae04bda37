// The rest of a program, from a line on: what the lines before it would have left (place, modes, tool) is made by a few lines in their stead.

import { LETTERS, MM_PER_INCH } from "./dialect";

/** What the lines before would have left. */
export interface Left {
  /** The words of `$G`. */
  modes: string[];
  /** The length of the tool in force, in the unit of reports. */
  length: number;
  /** Where the machine would be, and how high it has been or is, mm of the machine. */
  placeMm: number[];
  highestMm: number;
  isInches: boolean;
}

/** Lines that are made instead of those before. */
const LINES = 6;
/** Words of `$G` that are sent again behind the place. */
const AGAIN = /^(G0|G1|G1[789]|G2[01]|G9[0134]|G5[4-9](\.[123])?|G61(\.1)?|G64|G9[89]|F[\d.]+|S[\d.]+)$/;
const MOTION = /^G(0|1|2|3|38\.[2-5]|73|8[0-9])$/;
const OWN_MOTION = /G\s*(0*[0-3]|38\.[2-5]|73|8\d)(?![\d.])/i;
/** A line without a motion of its own goes on with the one before. */
const GOES_ON = /[XYZAIJKR]\s*[-+.\d]/i;
/** What moves the zero of the work, or what is remembered, would have to be made too. */
const SETS = /G\s*(10|92|28\.1|30\.1)(?![\d.])/i;

/** Why a program cannot be begun at a line, from 1, by its text alone; empty if it can. */
export function whyNotFrom(lines: string[], line: number): string {
  if (!Number.isInteger(line) || line < 1 || line > lines.length) return `There is no line ${line}: the program has ${lines.length}.`;
  if (line <= LINES) return `Line ${line} is so near the beginning that the program goes from line 1, or from line ${LINES + 1} on.`;
  const plain = lines.map(withoutComments);
  const computed = plain.findIndex((text) => /#|^\s*O\s*[<\d]|\[/i.test(text) && !/^\s*O\d+\s*$/i.test(text));
  if (computed >= 0) return `Line ${computed + 1} computes or calls (#, [], O): such a program goes from its first line only.`;
  const sets = plain.slice(0, line - 1).findIndex((text) => SETS.test(text));
  if (sets >= 0) return `Line ${sets + 1} sets offsets or places (${SETS.exec(plain[sets] ?? "")?.[0]}): a program goes on behind it only if it is sent too.`;
  return "";
}

/** Why it cannot be begun there by what the lines before leave; empty if it can. What goes on with their motion may stand behind lines without a motion. */
export function whyNotAfter(lines: string[], line: number, { modes }: Left): string {
  if (modes.includes("G93")) return `Line ${line} is in inverse time (G93), so no feed is known by which to go down to it: take one behind G94.`;
  const motion = modes.find((mode) => MOTION.test(mode)) ?? "G0";
  const rest = lines.slice(line - 1).map(withoutComments);
  const index = rest.findIndex((text) => OWN_MOTION.test(text) || GOES_ON.test(text));
  const goesOn = index >= 0 && !OWN_MOTION.test(rest[index] ?? "");
  return goesOn && !["G0", "G1", "G80"].includes(motion) ? `Line ${line + index} goes on with ${motion} of a line before: take the line with ${motion}.` : "";
}

const withoutComments = (text: string): string => text.replace(/;.*|\([^)]*\)/g, "");

/** The program from a line on. Its lines keep their numbers. */
export function restFrom(lines: string[], line: number, left: Left): { text: string; words: string } {
  const { modes, length, placeMm, highestMm, isInches } = left;
  const find = (letter: string): string | undefined => modes.find((mode) => mode.startsWith(letter));
  const feedMmPerMin = Number(find("F")?.slice(1) ?? 0) * (isInches ? MM_PER_INCH : 1);
  const place = (axes: string): string => [...axes].map((axis) => `${axis}${(placeMm[LETTERS.indexOf(axis)] ?? 0).toFixed(3)}`).join(" ");
  const across = placeMm.length > 3 ? "XYA" : "XY";
  const tool = [find("M3") ?? find("M4"), find("S"), find("M7"), find("M8")].filter(Boolean).join(" ");
  const isOn = modes.some((mode) => mode === "M3" || mode === "M4");
  const down = feedMmPerMin ? `G53 G1 ${place("Z")} F${feedMmPerMin.toFixed(1)}` : `G53 G0 ${place("Z")}`;
  const lengthWords = length ? `${isInches ? "G20" : "G21"} G43.1 Z${length}` : "G49";
  const again = modes.filter((mode) => AGAIN.test(mode)).join(" ");
  const made = [`G21 G90 G94 G53 G0 Z${highestMm.toFixed(3)}`, `G53 G0 ${place(across)}`, isOn || /M[78]/.test(tool) ? tool : "", down, lengthWords, again];
  const head = Array.from({ length: line - 1 }, (_, index) => made[index - (line - 1 - LINES)] ?? "");
  const number = find("T")?.slice(1);
  const words = [
    `From line ${line}: up to Z ${highestMm.toFixed(3)}, over to ${place(across)}, ${isOn ? `${tool}, ` : ""}down to ${place("Z")} of the machine`,
    `with ${again}.`,
    number && number !== "0" ? `It goes on with tool ${number}, which has to be in.` : "",
  ];
  return { text: [...head, ...lines.slice(line - 1)].join("\n"), words: words.filter(Boolean).join(" ") };
}
