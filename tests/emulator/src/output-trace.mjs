import { CsvFile } from './csv-file.mjs';

export const HEADER = 't_ns,output,value';

/** The trace of the tool's outputs: a row for every change of an output. All outputs are 0 before their first row. */
export class OutputTrace {
  #file;

  /** @param {string} path */
  constructor(path) {
    this.#file = new CsvFile(path, HEADER);
  }

  /** @param {number} value the duty as a fraction, or 0 or 1 */
  change(nanos, output, value) {
    this.#file.row(nanos, output, value);
  }

  close() {
    this.#file.close();
  }
}
