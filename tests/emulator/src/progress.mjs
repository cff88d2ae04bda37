const EVERY_MS = 1000;

/** Says on stderr, once a second of the wall clock, how far the run is. It shows, and never steers. */
export class Progress {
  constructor(board, shown, describe) {
    this.board = board;
    this.describe = describe;
    this.startedMs = performance.now();
    this.lastMs = this.startedMs;
    if (shown) board.onSlice = () => this.#tick();
  }

  /** How fast it went, at the end. */
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
