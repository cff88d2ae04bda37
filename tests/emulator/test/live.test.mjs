import assert from 'node:assert/strict';
import test from 'node:test';
import { Live } from '../src/live.mjs';
import { MachineClock } from '../src/clock.mjs';

const hex = (text) => Buffer.from(text).toString('hex');
const CYCLE_NANOS = 8;

/** A board whose firmware sends what the test specifies. */
class FakeBoard {
  constructor() {
    Object.assign(this, { clock: new MachineClock(), sent: '', homed: [], levels: [], bootsel: null });
    this.gantry = { home: (axes) => this.homed.push(...axes) };
    this.cable = { unsent: 3, settled: false, dtr: true, setDtr: (open) => this.#setDtr(open) };
  }

  get nanos() {
    return this.clock.cycles * CYCLE_NANOS;
  }

  pause() {}

  run(limit) {
    this.clock.core.cycles = limit;
  }

  send(bytes) {
    this.sent += Buffer.from(bytes).toString();
    if (this.sent.endsWith('?')) this.onBytes(Buffer.from('<Idle|MPos:1.000,0.000,0.000>\r\n'));
  }

  #setDtr(open) {
    this.cable.dtr = open;
    this.levels.push(open);
  }
}

test('a run sends, goes as far as it is asked, and answers with what came', () => {
  const board = new FakeBoard();
  const live = new Live(board);
  board.onBytes(Buffer.from('\r\nGrbl'));
  assert.equal(live.answer(`run 8000 ${hex('$I\n')}`), `8000 3 ${hex('\r\nGrbl')}`);
  assert.equal(live.answer('run 4000 -'), '8000 3 -');
  assert.equal(board.sent, '$I\n');
});

test('homing moves the zero of the trace when it is answered, whatever is polled meanwhile', () => {
  const board = new FakeBoard();
  const live = new Live(board);
  live.answer(`run 8 ${hex('G0 X1\n$?')}`);
  live.answer(`run 16 ${hex('H\n')}`);
  board.onBytes(Buffer.from('error:20\r\n'));
  assert.deepEqual(board.homed, []);
  board.onBytes(Buffer.from('ok\r\n'));
  assert.deepEqual(board.homed, ['X', 'Y', 'Z']);
});

test('a reset forgets what was sent', () => {
  const board = new FakeBoard();
  const live = new Live(board);
  live.answer(`run 8 ${hex('$H\nG0')}`);
  live.answer(`run 16 ${hex('\x18')}`);
  board.onBytes(Buffer.from("ALARM:6\r\n\r\nGrbl 1.1h ['$' for help]\r\n"));
  live.answer(`run 24 ${hex('$HX\n')}`);
  board.onBytes(Buffer.from('ok\r\n'));
  assert.deepEqual(board.homed, ['X']);
  assert.equal(live.alarm, 'ALARM:6');
});

test('DTR moves once the host has set the port up, a change at a time', () => {
  const board = new FakeBoard();
  const live = new Live(board);
  live.answer('dtr off');
  live.answer('dtr on');
  live.answer('run 8 -');
  assert.deepEqual(board.levels, []);
  board.cable.settled = true;
  live.answer('run 16 -');
  live.answer('run 24 -');
  live.answer('run 32 -');
  assert.deepEqual(board.levels, [false, true]);
});

test('what a script does to the board is done, and answered by the machine time or by a reason', () => {
  const board = new FakeBoard();
  const live = new Live(board);
  const done = [];
  board.gantry.pressButton = (button, pressed) => done.push([button, pressed]);
  live.answer('run 8000 -');
  assert.equal(live.answer('do hold pressed'), 'done 8000');
  assert.deepEqual(done, [['hold', true]]);
  assert.match(live.answer('do hold pushed'), /^error script line 1: pushed is none of pressed, released/);
  assert.match(live.answer('do send G0 X1'), /^error who drives a live board sends and hears by run, not by send/);
});

test('a board that has become a drive ends it', () => {
  const board = new FakeBoard();
  const live = new Live(board);
  board.bootsel = { t_ns: 8 };
  assert.throws(() => live.answer('run 16 -'), /BOOTSEL: the board is a drive/);
});

test('the end asks for a last status', () => {
  const board = new FakeBoard();
  const live = new Live(board);
  assert.equal(live.answer('end'), null);
  assert.equal(live.lastStatus, '<Idle|MPos:1.000,0.000,0.000>');
  assert.ok(live.ended);
  assert.throws(() => live.answer('jump'), /no request jump/);
});
