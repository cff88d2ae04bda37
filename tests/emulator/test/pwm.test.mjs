import assert from 'node:assert/strict';
import test from 'node:test';
import { ALIAS, CC, CSR, CTR, DIV, PIN, PwmBench, SLICE_BIT, TOP } from '../support/pwm-bench.mjs';

const [EN, INTR, INTE, INTF, INTS] = [0xa0, 0xa4, 0xa8, 0xac, 0xb0];
const IRQ_PWM_WRAP = 4;

test('an output is high while the counter is below its compare value, from 0 to TOP', () => {
  const bench = new PwmBench();
  bench.start({ cc: 3, top: 4 });
  assert.equal(bench.levels(12), '111001110011');
  assert.equal(bench.read(CTR), 12 % 5);
  assert.equal(bench.duty, 0.6);
});

test('nothing is due while nobody changes anything', () => {
  const bench = new PwmBench();
  bench.start({ cc: 3, top: 4 });
  assert.equal(bench.clock.next, Infinity);
  bench.runTo(10_000_000_002);
  assert.equal(bench.read(CTR), 2);
});

test('a compare value of 0 is always low, one beyond TOP always high', () => {
  const low = new PwmBench();
  low.start({ cc: 0, top: 2 });
  assert.deepEqual([low.levels(6), low.duty], ['000000', 0]);
  const high = new PwmBench();
  high.start({ cc: 3, top: 2 });
  assert.deepEqual([high.levels(6), high.duty], ['111111', 1]);
});

test('what is written comes into force with the next wrap, on its cycle', () => {
  const bench = new PwmBench();
  bench.start({ cc: 1, top: 9 });
  bench.runTo(4);
  bench.write(CC, 5 << 16);
  bench.write(TOP, 7);
  assert.deepEqual([bench.read(CC), bench.read(TOP)], [5 << 16, 7]);
  bench.runTo(9);
  assert.equal(bench.duty, 0.1);
  bench.runTo(10);
  assert.equal(bench.duty, 5 / 8);
  assert.equal(bench.levels(10), '1111100011');
});

test('what is written back before the wrap changes nothing', () => {
  const bench = new PwmBench();
  bench.start({ cc: 1, top: 9 });
  bench.write(CC, 5 << 16);
  bench.write(CC, 1 << 16);
  assert.equal(bench.clock.next, Infinity);
});

test('a counter set to TOP wraps with the next tick, and a new period begins', () => {
  const bench = new PwmBench();
  bench.start({ div: 2, cc: 5, top: 999 });
  bench.runTo(8);
  bench.write(CC, 0);
  bench.write(CTR, 999);
  assert.equal(bench.duty, 0.005);
  bench.runTo(9);
  assert.equal(bench.duty, 0.005);
  bench.runTo(10);
  assert.deepEqual([bench.duty, bench.read(CTR)], [0, 0]);
  bench.runTo(12);
  assert.equal(bench.read(CTR), 1);
});

test('a wrap that an instruction overtakes comes before what it writes', () => {
  const bench = new PwmBench();
  bench.start({ cc: 1, top: 9 });
  bench.write(CC, 5 << 16);
  bench.core.cycles = 12;
  bench.write(CC, 7 << 16);
  assert.deepEqual([bench.duty, bench.read(CTR)], [0.5, 2]);
  assert.equal(bench.clock.next, 20);
});

test('a counter beyond TOP counts on through all its bits', () => {
  const bench = new PwmBench();
  bench.start({ cc: 1, top: 9 });
  bench.write(CTR, 0xfffe);
  bench.runTo(1);
  assert.equal(bench.read(CTR), 0xffff);
  bench.runTo(2);
  assert.equal(bench.read(CTR), 0);
});

test('a fraction of the divider spreads the ticks, on the whole part of N times the period', () => {
  const bench = new PwmBench();
  bench.start({ div: 2.5, cc: 1, top: 99 });
  const ticks = [];
  for (let cycle = 0, before = 0; cycle <= 15; cycle++) {
    bench.runTo(cycle);
    if (bench.read(CTR) !== before) ticks.push(cycle);
    before = bench.read(CTR);
  }
  assert.deepEqual(ticks, [2, 5, 7, 10, 12, 15]);
});

test('a divider of 0 divides by 256', () => {
  const bench = new PwmBench();
  bench.start({ div: 0, cc: 1, top: 99 });
  bench.runTo(255);
  assert.equal(bench.read(CTR), 0);
  bench.runTo(256);
  assert.equal(bench.read(CTR), 1);
});

test('a halted slice keeps its count and its level, and takes what is written at once', () => {
  const bench = new PwmBench();
  bench.start({ cc: 5, top: 9 });
  bench.runTo(2);
  bench.write(CSR, 1, ALIAS.clear);
  bench.runTo(100);
  assert.deepEqual([bench.read(CTR), bench.duty], [2, 1]);
  bench.write(CC, 0);
  assert.equal(bench.duty, 1);
  bench.write(CSR, 1, ALIAS.set);
  assert.deepEqual([bench.duty, bench.pin.outputValue], [0, false]);
  bench.runTo(101);
  assert.equal(bench.read(CTR), 3);
});

test('EN starts slices together, and its aliases change single bits', () => {
  const bench = new PwmBench();
  bench.write(EN, SLICE_BIT | 1);
  assert.equal(bench.read(EN), SLICE_BIT | 1);
  assert.equal(bench.read(CSR), 1);
  bench.write(EN, 1, ALIAS.xor);
  assert.equal(bench.read(EN), SLICE_BIT);
  bench.write(CSR, 0);
  assert.equal(bench.read(EN), 0);
});

test('an inverted output is high for the rest of its time', () => {
  const bench = new PwmBench();
  bench.start({ cc: 1, top: 3 });
  bench.write(CSR, 1 << 3, ALIAS.set);
  assert.deepEqual([bench.levels(5), bench.duty], ['01110', 0.75]);
});

test('channel A and the upper pins of a slice have their own', () => {
  const bench = new PwmBench();
  bench.start({ cc: 3, top: 3 });
  bench.write(CC, 1, ALIAS.set);
  bench.runTo(4);
  assert.deepEqual([12, 13, 28, 29].map((pin) => bench.chip.pwm.dutyOf(pin)), [0.25, 0.75, 0.25, 0.75]);
});

test('a wrap raises its flag, and an interrupt if that is enabled', () => {
  const bench = new PwmBench();
  bench.start({ cc: 1, top: 9 });
  const pending = () => ((bench.core.pendingInterrupts >>> IRQ_PWM_WRAP) & 1) !== 0;
  bench.runTo(10);
  assert.deepEqual([bench.read(INTR), bench.read(INTS), pending()], [SLICE_BIT, 0, false]);
  bench.write(INTR, SLICE_BIT);
  bench.write(INTE, SLICE_BIT);
  bench.runTo(19);
  assert.deepEqual([bench.read(INTR), pending()], [0, false]);
  bench.runTo(20);
  assert.deepEqual([bench.read(INTS), pending()], [SLICE_BIT, true]);
  bench.write(INTR, SLICE_BIT);
  assert.equal(pending(), false);
  bench.write(INTF, 1);
  assert.deepEqual([bench.read(INTS), pending()], [1, true]);
});

test('the edges at a pin come on their cycles once they are to be shown', () => {
  const bench = new PwmBench();
  const edges = [];
  bench.start({ cc: 3, top: 9 });
  bench.chip.pwm.showEdges(PIN);
  bench.pin.addListener((level) => edges.push([bench.clock.cycles, level]));
  bench.runTo(20);
  bench.write(CC, 4 << 16);
  // The core passes the edge and the wrap within one instruction.
  bench.core.cycles = 31;
  bench.write(DIV, 16);
  bench.runTo(35);
  assert.deepEqual(edges, [[3, 0], [10, 1], [13, 0], [20, 1], [23, 0], [30, 1], [34, 0]]);
});

test('other modes are refused with a warning', () => {
  const bench = new PwmBench();
  bench.write(CSR, 0x13);
  assert.equal(bench.read(CSR), 1);
  assert.deepEqual(bench.warnings, ['PWM: CSR 0x13: slices run free and trailing-edge only']);
});
