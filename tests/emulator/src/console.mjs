import { CLOCK_HZ } from './clock.mjs';
import { homedAxes, lineEnds, printable, trimmedText } from './lines.mjs';

const IDLE_POLL_HZ = 10;

/** What a received line is: a `reply` answers a line sent, a `status` a `?`, anything else is a `message`. */
export function kindOf(line) {
  if (line === 'ok' || line.startsWith('error:')) return 'reply';
  return line.startsWith('<') ? 'status' : 'message';
}

/**
 * Runs the machine until `probe` returns something.
 *
 * @template T
 * @param {{board: import('./board.mjs').Board, lastStatus: string | null}} console
 * @param {string} what what is waited for, for the error
 * @param {() => T | null} probe
 * @param {number} timeoutSeconds of machine time
 * @returns {T}
 */
export function waitFor(console, what, probe, timeoutSeconds) {
  const { board } = console;
  const deadline = board.clock.cycles + Math.round(timeoutSeconds * CLOCK_HZ);
  for (;;) {
    const found = probe();
    if (found !== null) return found;
    if (board.bootsel !== null) throw new Error(`no ${what}: the firmware rebooted into BOOTSEL at ${(board.bootsel.t_ns / 1e9).toFixed(6)} s`);
    if (board.clock.cycles >= deadline) throw new Error(timedOut(board, what, timeoutSeconds, console.lastStatus));
    board.run(deadline);
  }
}

function timedOut(board, what, seconds, lastStatus) {
  return `no ${what} within ${seconds} s of machine time: it is ${(board.nanos / 1e9).toFixed(3)} s, the last status is ${lastStatus ?? 'none'}`;
}

/** The sender's end of the cable: lines in and out, each with its machine time. */
export class Console {
  /**
   * @param {import('./board.mjs').Board} board
   * @param {import('./transcript.mjs').Transcript} transcript
   */
  constructor(board, transcript) {
    this.board = board;
    this.transcript = transcript;
    this.partial = [];
    /** Lines received and not yet taken, by kind. */
    this.inbox = { reply: [], status: [], message: [] };
    /** Lines sent and not yet fully answered, oldest first. */
    this.unanswered = [];
    /** Every line sent, with its answer. */
    this.sent = [];
    /** The sent lines that have not fully reached the chip yet, oldest first; and the number of bytes sent so far. */
    this.underWay = [];
    this.sentBytes = 0;
    this.lastStatus = null;
    this.alarm = null;
    this.poll = board.clock.createOutsideAlarm(() => this.#pollStatus());
    board.onBytes = (bytes) => bytes.forEach((byte) => this.#receive(byte));
    board.onDelivered = () => this.#delivered();
  }

  /** Sends bytes that nothing answers: real-time commands. */
  send(bytes) {
    this.transcript.sent(this.board.nanos, bytes);
    this.sentBytes += bytes.length;
    this.board.send(bytes);
  }

  /** Sends a line. Every line end in it (two in CRLF) is answered; of several answers an error is kept. */
  sendLine(bytes) {
    const line = { text: trimmedText(bytes), length: bytes.length, left: lineEnds(bytes), reply: null, sentNanos: this.board.nanos, arrivedNanos: null, repliedNanos: null };
    this.unanswered.push(line);
    this.sent.push(line);
    this.underWay.push({ line, end: this.sentBytes + bytes.length });
    this.send(bytes);
    return line;
  }

  /** Asks for a status report `hz` times a second of machine time. */
  pollEvery(hz) {
    this.pollNanos = 1e9 / hz;
    this.poll.schedule(this.pollNanos);
  }

  /** Takes the oldest line of a kind that begins with the prefix, with every older one of its kind. */
  take(kind, prefix = '') {
    const index = this.inbox[kind].findIndex(({ text }) => text.startsWith(prefix));
    return index < 0 ? null : this.inbox[kind].splice(0, index + 1).at(-1);
  }

  /** Runs the machine until `probe` returns something: see the function `waitFor`. */
  waitFor(what, probe, timeoutSeconds) {
    return waitFor(this, what, probe, timeoutSeconds);
  }

  /** Waits until two reports in a row, from now on, say Idle. */
  waitIdle(timeoutSeconds) {
    this.inbox.status.length = 0;
    const polling = this.poll.scheduled;
    if (!polling) this.pollEvery(IDLE_POLL_HZ);
    let inARow = 0;
    const idle = () => {
      const status = this.take('status')?.text ?? '';
      if (status.startsWith('<Alarm')) throw new Error(`the machine is in alarm instead of Idle: ${this.alarm ?? status}`);
      if (status !== '') inARow = status.startsWith('<Idle') ? inARow + 1 : 0;
      return inARow >= 2 ? status : null;
    };
    const status = this.waitFor('status Idle', idle, timeoutSeconds);
    if (!polling) this.poll.cancel();
    return status;
  }

  /** Some bytes have reached the chip: perhaps the last ones of a line. */
  #delivered() {
    const reached = this.sentBytes - this.board.cable.unsent;
    while (this.underWay.length > 0 && this.underWay[0].end <= reached) this.underWay.shift().line.arrivedNanos = this.board.nanos;
  }

  #pollStatus() {
    this.send(Uint8Array.of(0x3f));
    this.poll.schedule(this.pollNanos);
  }

  #receive(byte) {
    if (byte === 0x0a) this.#line(printable(this.partial.filter((each) => each !== 0x0d)));
    else this.partial.push(byte);
  }

  #line(text) {
    this.partial = [];
    if (text === '') return;
    const { nanos } = this.board;
    this.transcript.received(nanos, text);
    const kind = kindOf(text);
    this.inbox[kind].push({ text, nanos });
    if (kind === 'status') this.lastStatus = text;
    if (kind === 'reply') this.#answered(text, nanos);
    if (text.startsWith('ALARM:')) this.alarm = text;
    // After a reset, nothing sent before is answered.
    if (text.startsWith('Grbl')) this.forgetUnanswered();
    this.board.pause();
  }

  forgetUnanswered() {
    for (const line of this.unanswered) line.reply = 'reset';
    this.unanswered = [];
  }

  #answered(text, nanos) {
    const [line] = this.unanswered;
    if (line === undefined) return;
    if (line.reply === null || text !== 'ok') line.reply = text;
    line.left -= 1;
    if (line.left > 0) return;
    line.repliedNanos = nanos;
    this.unanswered.shift();
    if (line.reply === 'ok') this.board.gantry.home(homedAxes(line.text));
  }
}
