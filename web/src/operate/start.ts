// From what a program starts: offsets, lengths of tools, modes and the place, as the machine tells them, and as lines that make a machine
// at power-up so. They stand before the program where it is run in virtual time.

import { LETTERS, type Status } from "./dialect";
import type { Machine } from "./machine";

/** What the machine prints of itself. */
export interface Start {
  /** Of `$#`. */
  offsets: string[];
  /** The words of `$G`. */
  modes: string[];
  report: Status;
  isInches: boolean;
}

/** Modes that a program starts with. What is on, and which tool is in, moves nothing. */
const MODES = /^(G17|G18|G19|G20|G21|G90|G91|G94|G5[4-9](\.[123])?|G61(\.1)?|G64|G98|G99|F[\d.]+|S[\d.]+)$/;
const SYSTEMS = ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"];

/** Asks the machine, which must be at rest. Nothing is known if it does not answer, as after a reset. */
export function readStart(machine: Machine, then: (start: Start | undefined) => void): void {
  machine.query("$#", (offsets) => {
    machine.query("$G", (printed, answer) => {
      const modes = printed.find((line) => line.startsWith("[GC:"))?.slice(4, -1).split(" ");
      then(answer === "ok" && modes ? { offsets, modes, report: machine.report, isInches: machine.isInches } : undefined);
    });
  });
}

/** The lines that make a machine so that is at power-up. The last of them waits until it has come to its place. */
export function linesOfStart({ offsets, modes, report, isInches }: Start): string[] {
  const found = new Map(offsets.map((line) => /^\[([A-Z0-9.]+):(.*)\]$/.exec(line)?.slice(1) as [string, string] | undefined ?? ["", ""]));
  const place = (name: string): number[] => (found.get(name) ?? "").split(",").filter(Boolean).map(Number);
  const tools = offsets.flatMap((line) => {
    const [, number, lengths, radius] = /^\[T:(\d+)\|([^|]*)\|([^\]]*)\]$/.exec(line) ?? [];
    return number ? [`G10 L1 P${number} Z${lengths?.split(",")[2] ?? 0} R${radius}`] : [];
  });
  const system = modes.find((mode) => SYSTEMS.includes(mode)) ?? "G54";
  const length = Number(found.get("TLO") ?? 0);
  const lines = [
    isInches ? "G20 G90" : "G21 G90",
    ...SYSTEMS.flatMap((name, index) => (isZero(place(name)) ? [] : [`G10 L2 P${index + 1} ${words(place(name))}`])),
    ...tools,
    ...["G28", "G30"].flatMap((name) => (isZero(place(name)) ? [] : [`G53 G0 ${words(place(name))}`, `${name}.1`])),
    ...(isZero(report.machinePosition) ? [] : [`G53 G0 ${words(report.machinePosition)}`]),
    system,
    ...(length ? [`G43.1 Z${length}`] : []),
    ...(isZero(place("G92")) ? [] : [`G92 ${words(report.workPosition)}`]),
    "G4 P0",
  ];
  return [...lines, modes.filter((mode) => MODES.test(mode) && !SYSTEMS.includes(mode)).join(" ")].filter(Boolean);
}

const isZero = (place: number[]): boolean => place.every((value) => value === 0);

const words = (place: number[]): string => place.map((value, axis) => `${LETTERS[axis]}${value}`).join(" ");
