// Which axes are homed. The machine does not report it, so it is what its answers and alarms say.

import { AXIS_NAMES } from "../motion";

/** Alarms that leave the position trusted: soft limit, probe, a move that cannot be planned. */
const TRUSTED = [2, 4, 5, 21];

export class Homed {
  private axes = new Set<string>();

  /** A `$` line was accepted. */
  accepted(line: string): void {
    const homed = /^\$H([A-Z]?)$/i.exec(line.trim());
    if (homed) for (const axis of homed[1] ? [homed[1].toUpperCase()] : AXIS_NAMES) this.axes.add(axis);
    if (/^\$(SLP|RST)/i.test(line)) this.forget();
  }

  /** `ALARM:n` was raised. */
  alarmed(alarm: number): void {
    if (!TRUSTED.includes(alarm)) this.forget();
  }

  forget(): void {
    this.axes.clear();
  }

  has(axis: string): boolean {
    return this.axes.has(axis);
  }

  get all(): boolean {
    return AXIS_NAMES.every((axis) => this.axes.has(axis));
  }

  /** In words. */
  get words(): string {
    if (this.all) return "yes";
    return this.axes.size ? `${[...this.axes].sort().join(", ")} only` : "no";
  }
}
