const EVERY_MS = 1000;

/** Prints the progress to stderr, once a second of the wall clock. It has no influence on the run. */
export class Progress {
  constructor(board, shown, describe) {
    this.board = board;
    this.describe = describe;
    this.startedMs = performance.now();
    this.lastMs = this.startedMs;
    if (shown) board.onSlice = () => this.#tick();
  }

  /** The speed of the run, for its end. */
  speed() {
    const wallSeconds = (performance.now() - this.startedMs) / 1000;
    return `${wallSeconds.toFixed(1)} s of wall time, ${(this.board.nanos / 1e9 / wallSeconds).toFixed(2)} times real time`;
  }

  #tick() {
    if (performance.now() - this.lastMs < EVERY_MS) return;
    this.lastMs = performance.now();
    process.stderr.write(`${this.describe()}, machine time ${(this.board.nanos / 1e9).toFixed(2)} s, ${this.speed()}\n`);
  }
}
