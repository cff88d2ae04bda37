import { CsvFile } from './csv-file.mjs';

export const HEADER = 't_ns,axis,direction,position_steps';

/** The step trace: a row for every rising edge of STEP. */
export class StepTrace {
  #file;

  /** @param {string} path */
  constructor(path) {
    this.#file = new CsvFile(path, HEADER);
  }

  step(nanos, axis, direction, positionSteps) {
    this.#file.row(nanos, axis, direction, positionSteps);
  }

  close() {
    this.#file.close();
  }
}
