import assert from 'node:assert/strict';
import test from 'node:test';
import { Board } from '../src/board.mjs';
import { Console } from '../src/console.mjs';
import { BOARDS } from '../src/pins.mjs';
import { parseScript, ScriptRun } from '../src/script.mjs';
import { Transcript } from '../src/transcript.mjs';

const OPTIONS = { console: 'uart', startMm: [35, 40, 15], bounceMicros: 0, seed: 1, switches: {}, missFactor: null };
const STACK = 0x20001000;
const [SP, PC] = [13, 15];

/** A firmware in machine code: vectors and a program. */
function firmware(program) {
  const vectors = Uint32Array.of(STACK, 0x10000201, 0, 0x10000201);
  return [
    { address: 0x10000100, bytes: new Uint8Array(vectors.buffer) },
    { address: 0x10000200, bytes: new Uint8Array(Uint16Array.from(program).buffer) },
  ];
}

const word = (value) => [value & 0xffff, value >>> 16];

test('a core that hangs does nothing any more, and no interrupt helps it', () => {
  const board = new Board(firmware([0x3001, 0xe7fd]), OPTIONS);
  board.run(1000);
  board.hang();
  const counted = board.core.registers[0];
  board.core.setInterrupt(0, true);
  board.run(2000);
  assert.equal(board.core.registers[0], counted);
  assert.equal(board.core.IPSR, 0);
  assert.ok(board.core.PM);
  assert.deepEqual(board.faults, []);
});

test('a core that hangs for a time goes on where it was, with the interrupts that came', () => {
  const board = new Board(firmware([0x3001, 0xe7fd]), OPTIONS);
  board.run(1000);
  const { cycles } = board.clock;
  board.hang(0.1);
  const counted = board.core.registers[0];
  board.core.enabledInterrupts = 1;
  board.run(cycles + 12_499);
  assert.equal(board.core.registers[0], counted);
  assert.ok(board.core.PM);
  board.run(cycles + 13_000);
  assert.ok(!board.core.PM);
  assert.ok(board.core.registers[0] > counted + 100);
  board.hang(0.1);
  board.core.setInterrupt(0, true);
  board.run(cycles + 25_400);
  assert.equal(board.core.IPSR, 0);
  board.run(cycles + 25_600);
  assert.notEqual(board.core.IPSR, 0, 'the interrupt is served');
});

test('a function that panics is told the place to blame, which its stack leaves alone', () => {
  // b .; and at 0x10000202: push {r0, lr}, b .
  const board = new Board(firmware([0xe7fe, 0xb501, 0xe7fe]), OPTIONS);
  board.run(1000);
  board.panic(0x10000203);
  board.run(2000);
  const location = board.core.registers[0];
  assert.equal(board.core.registers[PC], 0x10000204);
  assert.equal(board.core.registers[SP], location - 8);
  const words = [0, 4, 8, 12].map((offset) => board.chip.readUint32(location + offset));
  assert.deepEqual(words, [0x10000000, 1, 1, 1]);
});

test('after a reset DIR is low again, whatever it was', () => {
  const steps = [];
  const program = [
    0x4805, // ldr r0, =IO_BANK0 GPIO2_CTRL
    0x2105, // movs r1, #5: SIO drives the pin
    0x6001, // str r1, [r0]
    0x6081, // str r1, [r0, #8]: GPIO3 too
    0x4804, // ldr r0, =SIO
    0x210c, // movs r1, #12: GP2 and GP3
    0x6241, // str r1, [r0, #0x24]: outputs
    0x2204, // movs r2, #4
    0x6142, // str r2, [r0, #0x14]: STEP high
    0xe7fe, // b .
    0xbf00,
    0xbf00,
    ...word(0x40014014),
    ...word(0xd0000000),
  ];
  const board = new Board(firmware(program), OPTIONS);
  board.gantry.stepWatchers.add((_cycle, _axis, direction) => steps.push(direction));
  board.run(1000);
  board.chip.writeUint32(0xd0000014, 1 << BOARDS.pico.axes.X.dir);
  board.powerCycle();
  board.run(2000);
  assert.deepEqual(steps, [-1, -1]);
});

test('a script counts on from the instant at which all that it sent has arrived', () => {
  const commands = (text) => parseScript(text);
  const board = new Board(firmware([0xe7fe]), OPTIONS);
  const sent = { at: 0 };
  board.cable.write = (bytes) => {
    sent.left = bytes.length;
    const arrive = board.clock.createOutsideAlarm(() => {
      sent.left -= 1;
      board.onDelivered();
      if (sent.left > 0) arrive.scheduleAt(board.clock.cycles + 500);
    });
    arrive.scheduleAt(board.clock.cycles + 500);
  };
  Object.defineProperty(board.cable, 'unsent', { get: () => sent.left ?? 0 });
  new ScriptRun(new Console(board, new Transcript()), commands('bytes 3f 3f 3f\nwait-arrival\nwait-us 8\n'), { pollHz: 0, timeoutSeconds: 1 }).run();
  // Three bytes of 500 cycles each, followed by 1,000 cycles.
  assert.ok(board.clock.cycles >= 2500 && board.clock.cycles < 2505, `${board.clock.cycles}`);
});

test('a script fails if the gantry was not still, or was not to be', () => {
  const run = (text) => new ScriptRun(new Console(new Board(firmware([0xe7fe]), OPTIONS), new Transcript()), parseScript(text), { pollHz: 0, timeoutSeconds: 1 }).run();
  run('stop-within 10\nwait-us 20\ncheck-stopped');
  assert.throws(() => run('check-stopped'), /line 1 .*stop-within first/);
  assert.throws(() => parseScript('panic 12x'), /12x is no address in hexadecimal; write: panic HEX/);
});
