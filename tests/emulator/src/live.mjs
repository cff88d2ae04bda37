import { CLOCK_HZ, NANOS_PER_CYCLE, nanosOf } from './clock.mjs';
import { waitFor } from './console.mjs';
import { homedAxes, printable, trimmedText } from './lines.mjs';
import { summary } from './report.mjs';
import { print, requests } from './requests.mjs';
import { parseScript, ScriptRun } from './script.mjs';

const LF = 0x0a;
const CR = 0x0d;
const RESET = 0x18;
const STATUS_REQUEST = Uint8Array.of(0x3f);
const LAST_STATUS_CYCLES = 0.1 * CLOCK_HZ;
/** The commands of a script that talk: here the other program does that. */
const TALK = ['send', 'bytes', 'expect', 'wait-reply', 'wait-idle', 'check-position'];
/** How long a command waits at most. */
const PATIENCE_SECONDS = 60;

/**
 * A board that another program runs in steps. That program sets the pace and is the sender. It sends requests, one per
 * line:
 *
 *     run NANOS HEX     sends the bytes now (- for none), runs to that machine time; answered by
 *                       NANOS UNSENT HEX: the machine time, the bytes still to go to the chip, the bytes that came
 *     dtr on|off        opens or closes the USB port; a UART has no such line. Not answered
 *     do COMMAND        what a command of a script does, except to talk; answered by done NANOS, or by error and a reason
 *     look              answered by the summary, as it is now, on one line
 *     end               asks for a last status report, and ends
 */
export class Live {
  /**
   * @param {import('./board.mjs').Board} board
   * @param {import('./transcript.mjs').Transcript | undefined} transcript
   */
  constructor(board, transcript) {
    this.board = board;
    this.transcript = transcript;
    this.lastStatus = null;
    this.alarm = null;
    /** Lines are not stored, because a live board may receive millions. */
    this.sent = [];
    this.ended = false;
    this.dtr = [];
    this.received = [];
    this.partial = { sent: [], received: [] };
    /** Lines that have been sent and not answered yet. They are needed because homing moves the zero of the trace. */
    this.unanswered = [];
    this.script = new ScriptRun(this, [], { pollHz: 0, timeoutSeconds: PATIENCE_SECONDS });
    board.onBytes = (bytes) => bytes.forEach((byte) => this.#receive(byte));
  }

  /** Carries out a request. @returns {string | null} its answer */
  answer(request) {
    const [word, ...rest] = request.split(' ');
    switch (word) {
      case 'run':
        return this.#run(Number(rest[0]), Buffer.from(rest[1] === '-' ? '' : rest[1], 'hex'));
      case 'dtr':
        this.dtr.push(rest[0] === 'on');
        return null;
      case 'do':
        return this.#do(rest.join(' '));
      case 'look':
        return JSON.stringify(summary(this.board, this, null));
      case 'end':
        this.#end();
        return null;
    }
    throw new Error(`no request ${request}`);
  }

  #run(nanos, bytes) {
    const { board } = this;
    this.#setDtr();
    if (bytes.length > 0) this.#send(bytes);
    const until = Math.round(nanos / NANOS_PER_CYCLE);
    while (board.clock.cycles < until) board.run(until);
    if (board.bootsel !== null && !this.script.bootselSeen) throw new Error('the firmware rebooted into BOOTSEL: the board is a drive now');
    return `${board.nanos} ${board.cable.unsent} ${Buffer.from(this.received.splice(0)).toString('hex') || '-'}`;
  }

  #do(source) {
    try {
      const [command] = parseScript(source);
      if (TALK.includes(command.word)) throw new Error(`who drives a live board sends and hears by run, not by ${command.word}`);
      this.script.carryOut(command);
    } catch (error) {
      if (error.name !== 'Error') throw error;
      return `error ${error.message}`;
    }
    return `done ${nanosOf(this.script.edgeCycle ?? this.board.clock.cycles)}`;
  }

  waitFor(what, probe, timeoutSeconds) {
    return waitFor(this, what, probe, timeoutSeconds);
  }

  /** Power was off, or the board was a drive: nothing sent before is answered. */
  forgetUnanswered() {
    this.unanswered = [];
    this.partial = { sent: [], received: [] };
  }

  #end() {
    const { board } = this;
    this.lastStatus = null;
    this.#send(STATUS_REQUEST);
    const until = board.clock.cycles + LAST_STATUS_CYCLES;
    while (this.lastStatus === null && board.clock.cycles < until) board.run(until);
    this.ended = true;
  }

  /** Makes one change of DTR, if the host has set the port up. */
  #setDtr() {
    const { cable } = this.board;
    if (this.dtr.length === 0 || !cable.settled) return;
    const open = this.dtr.shift();
    if (open !== cable.dtr) cable.setDtr(open);
  }

  #send(bytes) {
    for (const byte of bytes) {
      if (byte === RESET) this.partial.sent = [];
      if (!isRealTime(byte)) this.partial.sent.push(byte);
      if (byte === LF || byte === CR) this.#lineSent(Uint8Array.from(this.partial.sent.splice(0)));
    }
    this.board.send(bytes);
  }

  #lineSent(bytes) {
    this.transcript?.sent(this.board.nanos, bytes);
    this.unanswered.push(trimmedText(bytes));
  }

  #receive(byte) {
    this.received.push(byte);
    if (byte === LF) this.#lineReceived(printable(this.partial.received.splice(0)));
    else if (byte !== CR) this.partial.received.push(byte);
  }

  #lineReceived(text) {
    if (text === '') return;
    this.transcript?.received(this.board.nanos, text);
    if (text.startsWith('<')) this.#status(text);
    else if (text.startsWith('ALARM:')) this.alarm = text;
    // After a reset, nothing sent before is answered.
    else if (text.startsWith('Grbl')) this.unanswered = [];
    else if (text === 'ok') this.board.gantry.home(homedAxes(this.unanswered.shift() ?? ''));
    else if (text.startsWith('error:')) this.unanswered.shift();
  }

  #status(text) {
    this.lastStatus = text;
    this.board.pause();
  }
}

/** Bytes that the controller acts on as soon as they come, also in the middle of a line. */
function isRealTime(byte) {
  return byte === RESET || byte >= 0x80 || '?!~'.includes(String.fromCharCode(byte));
}

/**
 * Answers requests from stdin on stdout until `live` or the other program has ended.
 *
 * @param {Live} live
 */
export function serve(live) {
  for (const request of requests()) {
    const answer = live.answer(request);
    if (answer !== null) print(answer);
    if (live.ended) return;
  }
}
