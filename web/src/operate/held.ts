// A jog for as long as a key is held down: short moves, each renewed by the page. If the page hangs or sleeps, the machine comes to
// rest by itself at the end of what it has.

import { LETTERS, MM_PER_INCH, type Status } from "./dialect";

/** How long one move lasts at the feed, s. */
const MOVE_S = 0.1;
/** How much of the way the machine has ahead at most, s at the feed. */
const AHEAD_S = 0.3;
/** For how long it is taken to go on as reported last, s: reports come some five times a second. What is asked for of a machine that is silent would be
 * made when nobody expects it. */
const UNSEEN_S = 0.5;
/** The shortest move, mm. */
const LEAST_MM = 0.001;

export class HeldJog {
  private readonly moveMm: number;
  private readonly aheadMm: number;
  private readonly fromMm: number;
  private askedMm = 0;
  private movedMm = 0;
  private speedMmPerS = 0;
  private reportedAtMs: number;

  /** `ask` sends a line; the way ends after `mostMm`. */
  constructor(
    private readonly axis: number,
    private readonly direction: number,
    private readonly feedMmPerMin: number,
    private readonly mostMm: number,
    report: Status,
    private readonly isInches: boolean,
    private readonly ask: (line: string) => void,
  ) {
    this.moveMm = Math.max(LEAST_MM, (feedMmPerMin / 60) * MOVE_S);
    this.aheadMm = (this.moveMm * AHEAD_S) / MOVE_S;
    this.fromMm = this.placeMm(report);
    this.reportedAtMs = performance.now();
    this.renew();
  }

  /** The machine has said where it is. */
  report(report: Status): void {
    this.movedMm = Math.abs(this.placeMm(report) - this.fromMm);
    this.speedMmPerS = (report.feed * this.unitMm) / 60;
    this.reportedAtMs = performance.now();
  }

  /** Asks for as much more as keeps it moving. To be called again and again, while the key is held down. */
  renew(): void {
    const sinceS = Math.min(UNSEEN_S, (performance.now() - this.reportedAtMs) / 1000);
    const isAtMm = Math.min(this.askedMm, this.movedMm + this.speedMmPerS * sinceS);
    while (this.askedMm - isAtMm + this.moveMm <= this.aheadMm * (1 + 1e-9)) {
      const mm = Math.min(this.moveMm, this.mostMm - this.askedMm);
      if (mm < LEAST_MM) return;
      this.askedMm += mm;
      this.ask(`$J=G21 G91 ${LETTERS[this.axis]}${(this.direction * mm).toFixed(3)} F${this.feedMmPerMin}`);
    }
  }

  private get unitMm(): number {
    return this.isInches ? MM_PER_INCH : 1;
  }

  private placeMm(report: Status): number {
    return (report.machinePosition[this.axis] ?? 0) * this.unitMm;
  }
}
