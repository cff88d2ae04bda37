import assert from 'node:assert/strict';
import test from 'node:test';
import { PioBench } from '../support/pio-bench.mjs';
import { run } from '../src/core.mjs';

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
