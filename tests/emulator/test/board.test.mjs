import assert from 'node:assert/strict';
import test from 'node:test';
import { Board } from '../src/board.mjs';
import { Console } from '../src/console.mjs';
import { parseScript, ScriptRun } from '../src/script.mjs';
import { Transcript } from '../src/transcript.mjs';
import { CONDITION, irqWait, jmp, set, TO } from '../support/pio-assembly.mjs';

const OPTIONS = { console: 'uart', startMm: [35, 40, 15], bounceMicros: 0, seed: 1, switches: {}, missFactor: null };
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
  board.gantry.stepWatchers.add((...step) => steps.push(step));
  board.run(1000);
  // ldr 2, movs 1, two peripheral writes of 5, ldr 2, movs 1, then SIO's single cycles: STEP rises with the 21st.
  assert.deepEqual(steps, [[21, 'X', 1, 1]]);
  assert.equal(board.gantry.timing.counts.dir_setup, 1);
  assert.equal(board.gantry.carriages.X.placeMm, 35.02);
});

test('a sleeping core costs no time, and the clock stays exact', () => {
  const board = new Board(firmware([0xbf20, 0xe7fd]), OPTIONS);
  board.run(125e6 * 3600);
  assert.equal(board.clock.cycles, 125e6 * 3600);
  assert.ok(board.clock.awakeCycles < 100);
});

test('a bad address is a hard fault, reported with its instruction', () => {
  const board = new Board(firmware([0x2003, 0x6800]), OPTIONS);
  board.run(1000);
  assert.equal(board.faults[0].pc, '0x10000202');
  assert.match(board.faults[0].what, /unaligned read of address 0x3/);
  assert.equal(board.core.IPSR, 3);
});

/**
 * Drives the tool's enable (GP14) high on cycle 14: ldr 2, movs 1, a peripheral write of 5, ldr 2, movs 1, lsls 1, and SIO's
 * single cycles.
 */
const ENABLES = [
  0x4804, // ldr r0, =IO_BANK0 GPIO14_CTRL
  0x2105, // movs r1, #5: SIO drives the pin
  0x6001, // str r1, [r0]
  0x4804, // ldr r0, =SIO
  0x2101, // movs r1, #1
  0x0389, // lsls r1, r1, #14
  0x6241, // str r1, [r0, #0x24]: an output
  0x6141, // str r1, [r0, #0x14]: high
  0xe7fe, // b .
  0xbf00,
  ...word(0x40014074),
  ...word(0xd0000000),
];

test('an output that a crash leaves on is on until the chip is reset', () => {
  const board = new Board(firmware(ENABLES), OPTIONS);
  const changes = [];
  board.gantry.tool.watchers.add((...change) => changes.push(change));
  board.run(1000);
  board.crash();
  board.run(2000);
  board.run(3000);
  board.powerCycle();
  assert.deepEqual(changes.map(([, ...change]) => change), [['enable', 1], ['enable', 0]]);
  assert.equal(changes[0][0], 14);
  const [crash, fault, power] = board.gantry.toolStops.summary();
  assert.deepEqual([crash, fault, power].map(({ input }) => input), ['CRASH', 'FAULT', 'POWER']);
  assert.deepEqual([crash.t_ns + crash.outputs_off_ns, power.outputs_off_ns], [board.nanos, 0]);
});

test('a script waits for an output of the tool, and counts on from its change', () => {
  const board = new Board(firmware(ENABLES), OPTIONS);
  const commands = parseScript('wait-output enable on\nwait-us 10\nwait-output enable on\nwait-output mist off\n');
  new ScriptRun(new Console(board, new Transcript()), commands, { pollHz: 0, timeoutSeconds: 1 }).run();
  assert.ok(board.clock.cycles >= 14 + 1250 && board.clock.cycles < 14 + 1250 + 3);
  const never = new ScriptRun(new Console(board, new Transcript()), parseScript('wait-output mist on'), { pollHz: 0, timeoutSeconds: 0.001 });
  assert.throws(() => never.run(), /no output mist on within 0.001 s/);
});

test('a sleeping core is woken by PIO on the cycle of its flag, and the edges between are reported with theirs', () => {
  const board = new Board(
    firmware([
      0x4808, // ldr r0, =NVIC_ISER
      0x2180, // movs r1, #0x80: PIO0_IRQ_0
      0x6001, // str r1, [r0]
      0xb672, // cpsid i: woken, but no handler
      0x4807, // ldr r0, =IO_BANK0 GPIO2_CTRL
      0x2106, // movs r1, #6: PIO0 drives the pin
      0x6001, // str r1, [r0]
      0x4807, // ldr r0, =PIO0
      0x2101, // movs r1, #1
      0x6001, // str r1, [r0]: machine 0 runs
      0xbf30, // wfi
      0xe7fe, // b .
      ...Array(6).fill(0xbf00),
      ...word(0xe000e100),
      ...word(0x40014014),
      ...word(0x50200000),
    ]),
    OPTIONS,
  );
  const steps = [];
  board.gantry.stepWatchers.add((cycle) => steps.push(cycle));
  const write = (offset, value) => board.chip.writeUint32(0x50200000 + offset, value);
  const program = [set(TO.directions, 1), set(TO.x, 31), set(TO.pins, 1), set(TO.pins, 0), jmp(CONDITION.xCounts, 2, 29), irqWait(0)];
  program.forEach((instruction, index) => write(0x48 + 4 * index, instruction));
  write(0xdc, (1 << 26) | (2 << 5));
  write(0x12c, 1 << 8);
  board.run(5000);
  assert.equal(steps.length, 32);
  assert.ok(steps.every((cycle, index) => index === 0 || cycle - steps[index - 1] === 32));
  assert.equal(board.core.waiting, false);
  // Asleep from one cycle before the first edge (WFI takes two after the store) until the flag.
  assert.equal(board.clock.asleepCycles, steps.at(-1) + 32 - (steps[0] - 1));
});
