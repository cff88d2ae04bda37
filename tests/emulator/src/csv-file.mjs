import { closeSync, openSync, writeSync } from 'node:fs';

const BUFFERED_ROWS = 10_000;

/** A table whose rows are written as they come, so that millions of them need no memory. */
export class CsvFile {
  #file;
  #rows;

  /**
   * @param {string} path
   * @param {string} header
   */
  constructor(path, header) {
    this.#file = openSync(path, 'w');
    this.#rows = [header];
  }

  row(...cells) {
    this.#rows.push(cells.join(','));
    if (this.#rows.length >= BUFFERED_ROWS) this.#flush();
  }

  close() {
    this.#flush();
    closeSync(this.#file);
  }

  #flush() {
    if (this.#rows.length > 0) writeSync(this.#file, this.#rows.join('\n') + '\n');
    this.#rows = [];
  }
}
