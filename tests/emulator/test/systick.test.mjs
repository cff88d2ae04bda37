import assert from 'node:assert/strict';
import test from 'node:test';
import { Board } from '../src/board.mjs';
import { run } from '../src/core.mjs';
import { PioBench } from '../support/pio-bench.mjs';

const [CSR, RVR, CVR] = [0xe000e010, 0xe000e014, 0xe000e018];
const [ENABLE, INTERRUPT, CORE_CLOCK, COUNTED] = [1, 2, 4, 1 << 16];

function counting(reload, control) {
  const bench = new PioBench();
  bench.writeAt(RVR, reload);
  bench.writeAt(CVR, 0);
  bench.writeAt(CSR, control);
  return bench;
}

test('it counts core cycles, from the reload value down to 0 and over', () => {
  const bench = counting(9, ENABLE | CORE_CLOCK);
  const values = Array.from({ length: 13 }, () => {
    bench.run(1);
    return bench.readAt(CVR);
  });
  assert.deepEqual(values, [9, 8, 7, 6, 5, 4, 3, 2, 1, 0, 9, 8, 7]);
});

test('at 0 it sets its flag, until that is read, and its exception', () => {
  const bench = counting(99, ENABLE | CORE_CLOCK | INTERRUPT);
  const runTo = (cycle) => {
    bench.core.cycles = cycle;
    bench.clock.fireDue();
  };
  runTo(99);
  assert.equal(bench.readAt(CSR) & COUNTED, 0);
  assert.equal(bench.core.pendingSystick, false);
  runTo(100);
  assert.equal(bench.core.pendingSystick, true);
  assert.equal(bench.readAt(CSR), COUNTED | ENABLE | CORE_CLOCK | INTERRUPT);
  assert.equal(bench.readAt(CSR) & COUNTED, 0);
  runTo(205);
  assert.equal(bench.readAt(CVR), 95);
  assert.equal(bench.readAt(CSR) & COUNTED, COUNTED);
});

test('without CLKSOURCE it counts microseconds; stopped it keeps its count', () => {
  const bench = counting(0xffffff, ENABLE);
  bench.run(125 * 11);
  assert.equal(bench.readAt(CVR), 0xffffff - 10);
  bench.writeAt(CSR, 0);
  bench.run(1000);
  assert.equal(bench.readAt(CVR), 0xffffff - 10);
});

test('firmware can time itself: two readings differ by the cycles between them', () => {
  const bench = counting(0xffffff, ENABLE | CORE_CLOCK);
  // ldr r1, [r0]; four nops; ldr r2, [r0]
  bench.bus.ram16.set([0x6801, 0xbf00, 0xbf00, 0xbf00, 0xbf00, 0x6802], 0);
  const { registers } = bench.core;
  registers[0] = CVR;
  registers[15] = 0x20000000;
  run(bench.core, bench.bus, bench.clock, bench.core.cycles + 8);
  assert.equal(registers[1] - registers[2], 4 + 2);
});

const OPTIONS = { console: 'uart', startMm: [35, 40, 15], bounceMicros: 0, seed: 1, switches: {}, missFactor: null };
const [PROGRAM, HANDLER] = [0x10000200, 0x10000300];
const IRQ = 26;
const SLEEP = { wfi: 0xbf30, wfe: 0xbf20 };

/** A firmware that starts SysTick, reads it (r2), sleeps with interrupts masked, reads it again (r3), and unmasks them. */
function sleeper(sleep) {
  const vectors = new Uint32Array(16 + IRQ + 1).fill(HANDLER | 1);
  vectors.set([0x20001000, PROGRAM | 1]);
  const program = [
    0x4806, // ldr r0, =SysTick
    0x2100, 0x43c9, 0x0a09, // movs r1, #0; mvns r1, r1; lsrs r1, r1, #8
    0x6041, 0x6081, // str r1, [r0, #4]: reload; str r1, [r0, #8]
    0x2105, // movs r1, #5
    0x6001, // str r1, [r0]: enabled, by the core's clock
    0xb672, // cpsid i
    0x6882, // ldr r2, [r0, #8]
    sleep,
    0x6883, // ldr r3, [r0, #8]
    0xb662, // cpsie i
    0xe7fe, // b .
    0xe010, 0xe000,
  ];
  return [
    { address: 0x10000100, bytes: new Uint8Array(vectors.buffer) },
    { address: PROGRAM, bytes: new Uint8Array(Uint16Array.from(program).buffer) },
    // movs r4, #1; b .
    { address: HANDLER, bytes: new Uint8Array(Uint16Array.of(0x2401, 0xe7fe).buffer) },
  ];
}

test('it counts every cycle for which the core sleeps, and the interrupt that ends WFI is taken when it is unmasked', () => {
  // Long enough to go through 0 once.
  for (const woken of [1000, 1001, 0x1000000 + 5000]) {
    const board = new Board(sleeper(SLEEP.wfi), OPTIONS);
    board.core.enabledInterrupts = 1 << IRQ;
    board.clock.createOutsideAlarm(() => board.core.setInterrupt(IRQ, true)).scheduleAt(woken);
    board.run(woken - 1);
    assert.equal(board.core.waiting, true);
    const { registers } = board.core;
    // ldr 2, three of one cycle, two stores of 2, movs 1, store 2: it starts on cycle 12. The first reading is on 15.
    assert.equal(registers[2], 0xffffff - (15 - 12 - 1));
    board.run(woken + 2);
    assert.equal((registers[2] - registers[3]) & 0xffffff, (woken + 2 - 15) & 0xffffff);
    assert.deepEqual([board.core.waiting, board.core.IPSR, registers[4]], [false, 0, 0]);
    board.run(woken + 30);
    assert.deepEqual([board.core.IPSR, registers[4]], [16 + IRQ, 1]);
  }
});

test('a masked interrupt does not end WFE, for which it counts too', () => {
  const board = new Board(sleeper(SLEEP.wfe), OPTIONS);
  board.core.enabledInterrupts = 1 << IRQ;
  board.clock.createOutsideAlarm(() => board.core.setInterrupt(IRQ, true)).scheduleAt(1000);
  board.run(5000);
  assert.equal(board.core.waiting, true);
  assert.equal(board.chip.readUint32(CVR), 0xffffff - (5000 - 12 - 1));
});
