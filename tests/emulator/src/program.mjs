const RX_BUFFER_BYTES = 128;
const BOOT_SECONDS = 10;
const SHOWN_CHARACTERS = 60;

/** Streams a program as a sender does, and keeps every reply. */
export class ProgramRun {
  /**
   * @param {import('./console.mjs').Console} console
   * @param {Uint8Array[]} lines
   * @param {{stream: 'wait' | 'counting', pollHz: number, timeoutSeconds: number}} options
   */
  constructor(console, lines, { stream, pollHz, timeoutSeconds }) {
    Object.assign(this, { console, lines, stream, pollHz, timeoutSeconds });
    this.sent = [];
  }

  run() {
    const { console } = this;
    console.waitFor('welcome line (Grbl ...)', () => console.take('message', 'Grbl'), BOOT_SECONDS);
    if (this.pollHz > 0) console.pollEvery(this.pollHz);
    for (const line of this.lines) {
      this.#waitUntil(() => this.#fits(line));
      this.sent.push(console.sendLine(line));
    }
    this.#waitUntil(() => console.unanswered.length === 0);
    console.waitIdle(this.timeoutSeconds);
  }

  /** What a line and its answer were, for the summary. */
  replies() {
    return this.sent.map(({ text, reply, sentNanos, repliedNanos }, index) => ({
      line: index + 1,
      text,
      reply,
      sent_ns: sentNanos,
      replied_ns: repliedNanos ?? null,
    }));
  }

  /** What is wrong with a run that came to its end, if anything. */
  verdict() {
    const refused = this.sent.filter(({ reply }) => reply !== 'ok').length;
    return refused > 0 ? `${refused} of ${this.lines.length} lines were refused` : null;
  }

  describe() {
    return `line ${this.sent.length} of ${this.lines.length}`;
  }

  /** With nothing unanswered any line goes; counting characters, as long as the controller's buffer has room. */
  #fits(line) {
    const { unanswered } = this.console;
    if (unanswered.length === 0) return true;
    const bytes = unanswered.reduce((sum, { length }) => sum + length, line.length);
    return this.stream === 'counting' && bytes <= RX_BUFFER_BYTES;
  }

  #waitUntil(condition) {
    while (!condition()) this.#nextReply();
  }

  #nextReply() {
    const { console } = this;
    const [oldest] = console.unanswered;
    const name = `line ${this.sent.indexOf(oldest) + 1} of ${this.lines.length} (${oldest.text.slice(0, SHOWN_CHARACTERS)})`;
    const probe = () => this.#stopped(name) ?? console.take('reply');
    console.waitFor(`reply to ${name}`, probe, this.timeoutSeconds);
  }

  #stopped(name) {
    const { board, alarm } = this.console;
    if (board.faults.length > 0) throw new Error(`a hard fault at pc ${board.faults[0].pc} (${board.faults[0].what}), waiting for the reply to ${name}`);
    if (board.resets.length > 0) throw new Error(`the watchdog reset the board at ${seconds(board.resets[0].t_ns)} s, waiting for the reply to ${name}`);
    if (alarm !== null) throw new Error(`${alarm} at ${seconds(board.nanos)} s, waiting for the reply to ${name}`);
    return null;
  }
}

const seconds = (nanos) => (nanos / 1e9).toFixed(6);
