import assert from 'node:assert/strict';
import test from 'node:test';
import { MachineClock } from '../src/clock.mjs';
import { Console } from '../src/console.mjs';
import { programLines } from '../src/lines.mjs';
import { ProgramRun } from '../src/program.mjs';
import { parseScript, ScriptRun } from '../src/script.mjs';
import { Transcript } from '../src/transcript.mjs';

const ANSWER_CYCLES = 1000;
const OPTIONS = { stream: 'wait', pollHz: 0, timeoutSeconds: 1 };

/** A board that only imitates a controller's replies: `answer` returns the reply to a line. */
class FakeBoard {
  constructor(answer) {
    this.answer = answer;
    this.clock = new MachineClock();
    Object.assign(this, { faults: [], resets: [], bootsel: null, homed: [], bauds: [], line: '', inFlight: 0, mostInFlight: 0 });
    this.gantry = { home: (axes) => this.homed.push(...axes), stepWatchers: new Set(), timing: { energised: true } };
    this.cable = { setLineCoding: (baud) => this.bauds.push(baud) };
    this.#reply("\r\nGrbl 1.1h ['$' for help]", 0);
  }

  get nanos() {
    return this.clock.cycles * 8;
  }

  send(bytes) {
    bytes.forEach((byte) => this.#accept(byte));
  }

  pause() {
    this.paused = true;
  }

  run(limit) {
    this.paused = false;
    while (!this.paused && this.clock.cycles < limit) {
      this.clock.core.cycles = Math.min(this.clock.next, limit);
      this.clock.fireDue();
    }
  }

  #accept(byte) {
    if (byte === 0x3f) return this.#reply('<Idle|MPos:0.000,0.000,0.000|FS:0,0>', 0);
    this.inFlight += 1;
    this.mostInFlight = Math.max(this.mostInFlight, this.inFlight);
    if (byte !== 0x0a && byte !== 0x0d) {
      this.line += String.fromCharCode(byte);
      return;
    }
    if (this.line === '$BOOT') this.#leave();
    else this.#reply(this.answer(this.line), this.line.length + 1);
    this.line = '';
  }

  /** Enters BOOTSEL without an answer. */
  #leave() {
    const leave = () => {
      this.bootsel = { t_ns: this.nanos, energised: false };
      this.pause();
    };
    this.clock.createOutsideAlarm(leave).scheduleAt(this.clock.cycles + ANSWER_CYCLES);
  }

  #reply(text, answered) {
    if (text === undefined) return;
    const deliver = () => {
      this.inFlight -= answered;
      this.onBytes(Buffer.from(`${text}\r\n`));
    };
    this.clock.createOutsideAlarm(deliver).scheduleAt(this.clock.cycles + ANSWER_CYCLES);
  }
}

function stream(text, answer, options = {}) {
  const board = new FakeBoard(answer);
  const sender = new Console(board, new Transcript());
  const run = new ProgramRun(sender, programLines(Buffer.from(text)), { ...OPTIONS, ...options });
  return { board, sender, run };
}

test('send and wait: a line goes when the one before is answered, CRLF twice', () => {
  const { board, sender, run } = stream('G0 X1\r\nG0 X2\n', () => 'ok');
  run.run();
  assert.equal(run.verdict(), null);
  assert.deepEqual(sender.sent.map(({ text, reply }) => [text, reply]), [['G0 X1', 'ok'], ['G0 X2', 'ok']]);
  assert.equal(board.mostInFlight, 7);
});

test('counting characters fills the buffer, and never beyond 128', () => {
  const { board, run } = stream(`${'X'.repeat(29)}\n`.repeat(20), () => 'ok', { stream: 'counting' });
  run.run();
  assert.equal(board.mostInFlight, 120);
});

test('homing zeroes the axes it names, on its ok only', () => {
  const homed = (answer) => {
    const { board, run } = stream('$H\n$HY\n', answer);
    run.run();
    return board.homed;
  };
  assert.deepEqual(homed(() => 'ok'), ['X', 'Y', 'Z', 'Y']);
  assert.deepEqual(homed(() => 'error:5'), []);
});

test('what goes wrong is reported with the line', () => {
  const refused = stream('G0\nG99\n', (line) => (line === 'G99' ? 'error:20' : 'ok'));
  refused.run.run();
  assert.equal(refused.run.verdict(), '1 of 2 lines were refused');
  const silent = stream('G0\nG1\n', (line) => (line === 'G1' ? undefined : 'ok'));
  assert.throws(() => silent.run.run(), /no reply to line 2 of 2 \(G1\) within 1 s of machine time/);
  const alarmed = stream('$H\n', () => 'ALARM:9');
  assert.throws(() => alarmed.run.run(), /ALARM:9, waiting for the reply to line 1 of 1/);
});

test('a script stops at the first line that is not as it says', () => {
  const script = (text) => {
    const sender = new Console(new FakeBoard((line) => (line === 'G0' ? 'ok' : 'error:20')), new Transcript());
    const run = new ScriptRun(sender, parseScript(text), OPTIONS);
    run.run();
    return sender.transcript.toString();
  };
  assert.match(script('expect Grbl\nsend G0\nexpect ok\nbytes 3f\nexpect <Idle\nwait-idle\n'), /0\.000024 # wait-idle/);
  assert.throws(() => script('send G0\nexpect error:20'), /script line 2 \(expect error:20\): got ok/);
  assert.throws(() => script('wait-edge'), /no STEP edge within 1 s/);
  assert.match(script('wait-us 0.8\nwait-us 2.4\nwait-idle'), /0\.000003 # wait-idle/);
  assert.throws(() => script('wait-reply'), /no line beginning reply within 1 s/);
});

test('a program that ends in BOOTSEL ends well, one that is cut short by it does not', () => {
  const last = stream('G0\n$BOOT\n', () => 'ok');
  last.run.run();
  assert.equal(last.run.verdict(), null);
  const early = stream('$BOOT\nG0\nG1\n', () => 'ok');
  early.run.run();
  assert.equal(early.run.verdict(), 'the firmware rebooted into BOOTSEL before 2 of 3 lines were sent');
});

test('a script that does not expect BOOTSEL fails, and after it nothing answers', () => {
  const script = (text) => {
    const run = new ScriptRun(new Console(new FakeBoard(() => 'ok'), new Transcript()), parseScript(text), OPTIONS);
    run.run();
    return run.verdict();
  };
  assert.equal(script('send $BOOT\nexpect-bootsel'), null);
  assert.match(script('send $BOOT\nwait-ms 1'), /^the firmware rebooted into BOOTSEL at 0\.000008 s/);
  assert.throws(() => script('send G0\nexpect-bootsel'), /no BOOTSEL within 1 s/);
  assert.throws(() => script('send $BOOT\nexpect-bootsel\nexpect ok'), /line 3 .* no line beginning ok: the firmware rebooted into BOOTSEL/);
  assert.throws(() => script('send $BOOT\nexpect-bootsel\npower-cycle'), /the board is in BOOTSEL/);
  assert.equal(script('motors on\nsend $BOOT\nexpect-bootsel\nmotors off'), null);
  assert.throws(() => script('send $BOOT\nexpect-bootsel\nmotors on'), /ENABLE frees the motors/);
  assert.throws(() => script('leave-bootsel'), /the board is not in BOOTSEL: expect-bootsel first/);
});

test('a script sets the baud rate of the USB port', () => {
  const board = new FakeBoard(() => 'ok');
  new ScriptRun(new Console(board, new Transcript()), parseScript('usb-line-coding 1200\nusb-line-coding 4294967295'), OPTIONS).run();
  assert.deepEqual(board.bauds, [1200, 4294967295]);
  for (const wrong of ['', ' 0', ' -1200', ' 12e2', ' 4294967296', ' fast']) {
    assert.throws(() => parseScript(`usb-line-coding${wrong}`), /script line 1: .* is not a baud rate from 1 to 4294967295; write: usb-line-coding BAUD/);
  }
});
