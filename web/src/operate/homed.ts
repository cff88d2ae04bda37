// Which axes are homed. The machine reports when that changes (`H:`); one that does not is known by its answers and alarms.

import { LETTERS } from "./dialect";

/** Alarms that leave the position trusted: soft limit, probe, a move that cannot be planned. */
const TRUSTED = [2, 4, 5, 21];

export class Homed {
  private axes = new Set<string>();
  /** Those that the machine has. */
  private all: readonly string[] = LETTERS.slice(0, 3);
  /** Whether what was before is known: of a board that has been on, it is not. */
  private isKnown = true;

  /** Another machine, which is at power-up or has been on before. */
  begin(isAtPowerUp: boolean): void {
    this.axes.clear();
    this.isKnown = isAtPowerUp;
  }

  /** The machine reports these axes. */
  count(axes: readonly string[]): void {
    this.all = axes;
  }

  /** A report says which are, bit 0 for X. */
  told(mask: number): void {
    this.axes = new Set(LETTERS.filter((_, axis) => (mask >> axis) & 1));
    this.isKnown = true;
  }

  /** A `$` line was accepted. */
  accepted(line: string): void {
    const homed = /^\$H([A-Z]?)$/i.exec(line.trim());
    if (homed) for (const axis of homed[1] ? [homed[1].toUpperCase()] : this.all) this.axes.add(axis);
    if (/^\$SLP/i.test(line)) this.forget();
  }

  /** A message was printed. One says which axes a setting has taken the zero of. */
  reported(message: string): void {
    const lost = /^\[MSG:what the position of((?: [A-Z])+) means has changed/.exec(message)?.[1] ?? "";
    for (const axis of lost.trim().split(" ")) this.axes.delete(axis);
  }

  /** `ALARM:n` was raised. */
  alarmed(alarm: number): void {
    if (!TRUSTED.includes(alarm)) this.forget();
  }

  /** It says a welcome that the page has not asked for: another console may have moved it. */
  doubt(): void {
    if (this.axes.size) this.isKnown = false;
    this.axes.clear();
  }

  forget(): void {
    this.axes.clear();
    this.isKnown = true;
  }

  has(axis: string): boolean {
    return this.axes.has(axis);
  }

  /** In words. */
  get words(): string {
    if (this.all.every((axis) => this.axes.has(axis))) return "yes";
    if (this.axes.size) return `${this.all.filter((axis) => this.axes.has(axis)).join(", ")} only`;
    return this.isKnown ? "no" : "unknown";
  }
}
