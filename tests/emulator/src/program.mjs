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
  }

  run() {
    const { console } = this;
    console.waitFor('welcome line (Grbl ...)', () => console.take('message', 'Grbl'), BOOT_SECONDS);
    if (this.pollHz > 0) console.pollEvery(this.pollHz);
    for (const line of this.lines) {
      this.#waitUntil(() => this.#fits(line));
      if (this.#gone) return;
      console.sendLine(line);
    }
    this.#waitUntil(() => console.unanswered.length === 0);
    if (!this.#gone) this.#waitIdle();
  }

  /** The error of a run that reached its end, if there is one. */
  verdict() {
    const { sent } = this.console;
    const unsent = this.lines.length - sent.length;
    if (this.#gone && unsent > 0) return `the firmware rebooted into BOOTSEL before ${unsent} of ${this.lines.length} lines were sent`;
    // The line that requests BOOTSEL may stay unanswered.
    const refused = sent.filter(({ reply }, index) => reply !== 'ok' && !(this.#gone && reply === null && index === sent.length - 1)).length;
    return this.#trouble() ?? (refused > 0 ? `${refused} of ${this.lines.length} lines were refused` : null);
  }

  describe() {
    return `line ${this.console.sent.length} of ${this.lines.length}`;
  }

  /**
   * Whether a line may be sent: always if nothing is unanswered; otherwise, when counting characters, if the
   * controller's buffer has room.
   */
  #fits(line) {
    const { unanswered } = this.console;
    if (unanswered.length === 0) return true;
    const bytes = unanswered.reduce((sum, { length }) => sum + length, line.length);
    return this.stream === 'counting' && bytes <= RX_BUFFER_BYTES;
  }

  #waitUntil(condition) {
    while (!condition() && !this.#gone) this.#nextReply();
  }

  #nextReply() {
    const { console } = this;
    const [oldest] = console.unanswered;
    const name = `line ${console.sent.indexOf(oldest) + 1} of ${this.lines.length} (${oldest.text.slice(0, SHOWN_CHARACTERS)})`;
    const probe = () => this.#stopped(name) ?? console.take('reply') ?? console.board.bootsel;
    console.waitFor(`reply to ${name}`, probe, this.timeoutSeconds);
  }

  /** Waits until Idle, or until the firmware enters BOOTSEL. */
  #waitIdle() {
    try {
      this.console.waitIdle(this.timeoutSeconds);
    } catch (error) {
      if (!this.#gone) throw error;
    }
  }

  /** The board has become a drive. */
  get #gone() {
    return this.console.board.bootsel !== null;
  }

  #stopped(name) {
    const trouble = this.#trouble() ?? this.console.alarm;
    if (trouble === null) return null;
    throw new Error(`${trouble}, waiting for the reply to ${name} at ${(this.console.board.nanos / 1e9).toFixed(6)} s`);
  }

  /** A failure of the chip itself, if there is one. */
  #trouble() {
    const { faults, resets } = this.console.board;
    if (faults.length > 0) return `the firmware took a hard fault (${faults[0].what}, pc ${faults[0].pc})`;
    return resets.length > 0 ? `the watchdog reset the board (${resets[0].reason})` : null;
  }
}
