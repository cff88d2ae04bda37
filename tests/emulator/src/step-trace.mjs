import { closeSync, openSync, writeSync } from 'node:fs';

export const HEADER = 't_ns,axis,direction,position_steps';
const BUFFERED_ROWS = 10_000;

/** The step trace: a row for every rising edge of STEP, written as they come. */
export class StepTrace {
  /** @param {string} path */
  constructor(path) {
    this.file = openSync(path, 'w');
    this.rows = [HEADER];
  }

  step(nanos, axis, direction, positionSteps) {
    this.rows.push(`${nanos},${axis},${direction},${positionSteps}`);
    if (this.rows.length >= BUFFERED_ROWS) this.#flush();
  }

  close() {
    this.#flush();
    closeSync(this.file);
  }

  #flush() {
    if (this.rows.length > 0) writeSync(this.file, this.rows.join('\n') + '\n');
    this.rows = [];
  }
}
