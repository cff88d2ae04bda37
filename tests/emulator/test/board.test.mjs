import assert from 'node:assert/strict';
import test from 'node:test';
import { Board } from '../src/board.mjs';

const OPTIONS = { console: 'uart', startMm: [35, 40, 15], bounceMicros: 0, seed: 1, switches: {} };
const STACK = 0x20001000;
const ENTRY = 0x10000201;
const FAULT_HANDLER = 0x10000301;

/** A firmware in machine code: vectors, a program, and a HardFault handler that stays where it is. */
function firmware(program) {
  const vectors = Uint32Array.of(STACK, ENTRY, 0, FAULT_HANDLER);
  return [
    { address: 0x10000100, bytes: new Uint8Array(vectors.buffer) },
    { address: 0x10000200, bytes: new Uint8Array(Uint16Array.from(program).buffer) },
    { address: 0x10000300, bytes: new Uint8Array(Uint16Array.of(0xe7fe).buffer) },
  ];
}

const word = (value) => [value & 0xffff, value >>> 16];

test('a program drives the pins, and a step is traced at its cycle', () => {
  const steps = [];
  const board = new Board(
    firmware([
      0x4805, // ldr r0, =IO_BANK0 GPIO2_CTRL
      0x2105, // movs r1, #5: SIO drives the pin
      0x6001, // str r1, [r0]
      0x6081, // str r1, [r0, #8]: GPIO3 too
      0x4804, // ldr r0, =SIO
      0x210c, // movs r1, #12: GP2 and GP3
      0x6241, // str r1, [r0, #0x24]: outputs
      0x2208, // movs r2, #8
      0x6142, // str r2, [r0, #0x14]: DIR high
      0x2204, // movs r2, #4
      0x6142, // str r2, [r0, #0x14]: STEP high
      0xe7fe, // b .
      ...word(0x40014014),
      ...word(0xd0000000),
    ]),
    OPTIONS,
  );
  board.gantry.onStep = (...step) => steps.push(step);
  board.run(1000);
  // ldr 2, movs 1, two peripheral writes of 5, ldr 2, movs 1, then SIO's single cycles: STEP rises with the 21st.
  assert.deepEqual(steps, [[21 * 8, 'X', 1, 1]]);
  assert.equal(board.gantry.timing.counts.dir_setup, 1);
  assert.equal(board.gantry.carriages.X.placeMm, 35.02);
});

test('a sleeping core costs no time, and the clock stays exact', () => {
  const board = new Board(firmware([0xbf20, 0xe7fd]), OPTIONS);
  board.run(125e6 * 3600);
  assert.equal(board.clock.cycles, 125e6 * 3600);
  assert.ok(board.clock.awakeCycles < 100);
});

test('a bad address is a hard fault, told with its instruction', () => {
  const board = new Board(firmware([0x2003, 0x6800]), OPTIONS);
  board.run(1000);
  assert.equal(board.faults[0].pc, '0x10000202');
  assert.match(board.faults[0].what, /unaligned read of address 0x3/);
  assert.equal(board.core.IPSR, 3);
});
