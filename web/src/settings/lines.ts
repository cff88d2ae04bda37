// Settings as lines of `$n=v`, which senders save and load too.

import type { SettingRow } from "../messages";
import { setting } from "../operate/dialect";

/** Those of a file, whatever else stands in it: reports, answers, comments. A later line counts. */
export function read(text: string): Map<number, string> {
  return new Map(text.split(/\r\n|\r|\n/).map(setting).filter((found) => found !== undefined));
}

export const line = (number: number, value: string): string => `$${number}=${value}`;

/** Whether the machine would read it as a number; other characters might act at once. */
export const isNumber = (value: string): boolean => /^[-+]?[\d.]+$/.test(value);

export const isEqual = (a: string | undefined, b: string | undefined): boolean => a === b || Number(a) === Number(b);

/** Those of `wanted` that are not in force. */
export function changes(inForce: ReadonlyMap<number, string>, wanted: ReadonlyMap<number, string>): [number, string][] {
  return [...wanted].filter(([number, value]) => !isEqual(inForce.get(number), value));
}

/** Those that are not as they are by default. */
export function differences(rows: SettingRow[], inForce: ReadonlyMap<number, string>): [number, string][] {
  const defaults = new Map(rows.map((row) => [row.number, row.default]));
  return [...inForce].filter(([number, value]) => !isEqual(defaults.get(number), value));
}

/** A file that a sender, and `isostep sim --settings`, can read. */
export function file(settings: Iterable<[number, string]>): string {
  return [...settings].map(([number, value]) => `${line(number, value)}\n`).join("");
}

/** Why settings were refused, without the place in front, which is shown otherwise. */
export const reason = (words: string): string => words.replace(/^settings(:\d+: `[^`]*`)?: /, "");

/** A text of lines with these settings in it: in place of the lines that set the same, or behind all. Other lines stay. */
export function withSettings(text: string, changes: Iterable<[number, string]>): string {
  const wanted = new Map(changes);
  const written = new Set<number>();
  const replaced = text.split(/\r\n|\r|\n/).flatMap((before) => {
    const number = setting(before)?.[0];
    const value = number === undefined ? undefined : wanted.get(number);
    if (number === undefined || value === undefined) return [before];
    if (written.has(number)) return [];
    written.add(number);
    return [line(number, value)];
  });
  while (replaced.at(-1) === "") replaced.pop();
  const behind = [...wanted].filter(([number]) => !written.has(number)).map(([number, value]) => line(number, value));
  return [...replaced, ...behind].map((each) => `${each}\n`).join("");
}
