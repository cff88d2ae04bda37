import assert from 'node:assert/strict';
import test from 'node:test';
import { seededRandom } from '../src/limit-switch.mjs';
import { CONDITION, FROM, jmp, mov, push, set, shiftIn, TO, waitGpio } from '../support/pio-assembly.mjs';
import { PIO0, PIO1, PioBench, REG, SM } from '../support/pio-bench.mjs';

const PIN = 5;
/** Counts X down by one every two cycles, and pushes it at each rising edge. */
const STAMPER = [
  jmp(CONDITION.pin, 2),
  jmp(CONDITION.xCounts, 0),
  mov(TO.isr, FROM.x),
  push({ block: 0 }),
  jmp(CONDITION.pin, 6),
  jmp(CONDITION.xCounts, 0),
  jmp(CONDITION.xCounts, 4),
];
const STAMP_AT = 2;

/** A machine of PIO1 that stamps the pin, with X at its highest, in step with the cycle on which it is enabled. */
function stamper(slow = false, program = STAMPER) {
  const bench = new PioBench(PIO1);
  bench.load(program);
  bench.input(PIN, false);
  bench.run(4);
  bench.configure(0, { execctrl: (PIN << 24) | 0x1f000, shiftctrl: 0xc0000 });
  bench.force(0, set(TO.x, 0), mov(TO.x, FROM.x, 1));
  if (slow) bench.chip.pio[1].machines[0].pollsOn = () => false;
  bench.steps = 0;
  const [machine] = bench.chip.pio[1].machines;
  const { step } = machine;
  machine.step = (cycle) => {
    bench.steps += 1;
    step.call(machine, cycle);
  };
  bench.write(REG.ctrl, 1);
  bench.start = bench.core.cycles;
  return bench;
}

const x = (bench) => {
  bench.force(0, mov(TO.isr, FROM.x), push());
  return bench.read(REG.rxf);
};

test('a loop that polls a pin and counts takes no steps until the pin changes', () => {
  const bench = stamper();
  bench.run(1_000_000);
  assert.ok(bench.steps <= 3, `${bench.steps} steps`);
  bench.input(PIN, true);
  bench.run(1_000_000);
  assert.ok(bench.steps <= 10, `${bench.steps} steps`);
});

test('side-set that changes nothing, and autopush, do not make it be stepped', () => {
  const bench = stamper();
  bench.write(REG.ctrl, 0);
  // In the high round of this program the jump by the pin comes last.
  bench.load([jmp(CONDITION.pin, 2), jmp(CONDITION.xCounts, 0), shiftIn(FROM.x, 32), jmp(CONDITION.xCounts, 4), jmp(CONDITION.pin, 3), jmp(CONDITION.always, 0)]);
  bench.configure(0, { execctrl: (PIN << 24) | 0x1f000, shiftctrl: 0xd0000, pinctrl: (1 << 29) | (20 << 10) });
  bench.force(0, jmp(CONDITION.always, 0));
  bench.steps = 0;
  bench.write(REG.ctrl, 1);
  bench.run(100_000);
  bench.input(PIN, true);
  bench.run(100_000);
  bench.input(PIN, false);
  bench.run(100_000);
  assert.ok(bench.steps <= 20, `${bench.steps} steps`);
  assert.equal((bench.read(REG.flevel) >> 4) & 15, 1);
});

test('side-set that changes a pin in the loop makes every round a step', () => {
  const bench = stamper(false, [jmp(CONDITION.pin, 2, 0x10), jmp(CONDITION.xCounts, 0)]);
  bench.write(REG.ctrl, 0);
  bench.configure(0, { execctrl: (PIN << 24) | 0x1f000, pinctrl: ((1 << 29) | (1 << 26) | (20 << 10) | (20 << 5)) >>> 0 });
  bench.force(0, set(TO.directions, 1));
  const edges = bench.watch(20);
  bench.write(REG.ctrl, 1);
  bench.run(20);
  assert.ok(edges.length >= 18, `${edges.length} edges`);
});

test('jmp pin sees an edge two cycles after it came', () => {
  for (const at of [1000, 1001, 1002, 1003]) {
    const bench = stamper();
    bench.runTo(bench.start + at);
    bench.input(PIN, true);
    // The first look is on the cycle after the start, and the others every two cycles from there.
    const seen = bench.start + at + 2 + ((at + 1 + 2) % 2 === 0 ? 0 : 1);
    bench.runTo(seen - 1);
    assert.ok(bench.read(bench.sm(0, SM.addr)) < STAMP_AT);
    bench.runTo(seen);
    assert.equal(bench.read(bench.sm(0, SM.addr)), STAMP_AT);
    bench.run(10);
    assert.equal(0xffffffff - bench.read(REG.rxf), (seen - 1 - bench.start) / 2);
  }
});

test('two machines that start a cycle apart tell the cycle of an edge', () => {
  for (const at of [2000, 2001, 2002, 2003]) {
    const bench = stamper();
    bench.configure(1, { execctrl: (PIN << 24) | 0x1f000, shiftctrl: 0xc0000 });
    bench.force(1, set(TO.x, 0), mov(TO.x, FROM.x, 1));
    bench.runTo(bench.start + 1);
    bench.write(REG.ctrl, 3);
    bench.runTo(bench.start + at);
    bench.input(PIN, true);
    bench.run(20);
    const [first, second] = [0, 4].map((fifo) => 0xffffffff - bench.read(REG.rxf + fifo));
    assert.equal(first + second - 1, at);
  }
});

/** What a stamper says of random pulses, while its registers are looked at now and then. */
function stampsOf(seed, slow) {
  const random = seededRandom(seed);
  const bench = stamper(slow);
  const seen = [];
  for (let pulse = 0; pulse < 60; pulse++) {
    bench.run(1 + Math.floor(random() * 40));
    bench.input(PIN, pulse % 2 === 0);
    if (random() < 0.3) {
      bench.run(Math.floor(random() * 5));
      seen.push(bench.read(bench.sm(0, SM.addr)));
    }
    bench.run(4);
    while ((bench.read(REG.fstat) & 0x100) === 0) seen.push(bench.read(REG.rxf));
  }
  bench.run(9);
  return [...seen, x(bench)];
}

test('stamps are the same whether rounds are taken at once or one by one', () => {
  for (let seed = 1; seed <= 15; seed++) assert.deepEqual(stampsOf(seed, false), stampsOf(seed, true));
});

test('a counter that reaches 0 ends the rounds, on its cycle', () => {
  for (const count of [0, 1, 2, 3, 9, 30]) {
    const bench = stamper(false, [jmp(CONDITION.pin, 5), jmp(CONDITION.xCounts, 0), jmp(CONDITION.always, 2)]);
    bench.write(REG.ctrl, 0);
    bench.run(1);
    bench.force(0, set(TO.x, count), jmp(CONDITION.always, 0));
    bench.write(REG.ctrl, 1);
    bench.run(2 * count + 1);
    assert.equal(bench.read(bench.sm(0, SM.addr)), 1, `after ${count} rounds`);
    bench.run(1);
    assert.equal(bench.read(bench.sm(0, SM.addr)), 2, `after ${count} rounds`);
    assert.equal(x(bench), 0xffffffff);
  }
});

/** Blocks whose machines 0 and 1 poll the pin by jumps, on alternate cycles, and whose machine 2 waits for it. */
function watchedBy(both, driver) {
  const bench = new PioBench(driver);
  bench.watch(PIN);
  bench.chip.gpio[PIN].padValue |= 0x40;
  bench.configure(3, { pinctrl: (1 << 26) | (PIN << 5) });
  bench.force(3, set(TO.directions, 1), set(TO.pins, 0));
  for (const base of both) {
    bench.base = base;
    bench.load([jmp(CONDITION.pin, 2), jmp(CONDITION.xCounts, 0), jmp(CONDITION.always, 2)]);
    bench.load([waitGpio(1, PIN), jmp(CONDITION.always, 11)], 10);
    for (const index of [0, 1, 2]) {
      bench.configure(index, { execctrl: (PIN << 24) | 0x1f000 });
      bench.force(index, set(TO.x, 0), mov(TO.x, FROM.x, 1));
    }
    bench.force(2, jmp(CONDITION.always, 10));
  }
  for (const base of both) bench.writeAt(base + REG.ctrl, 0b101);
  bench.run(1);
  for (const base of both) bench.writeAt(base + REG.ctrl, 0b111);
  bench.run(1000);
  bench.base = driver;
  return bench;
}

test('machines of both blocks see one edge of a pad on the same cycle, whichever block drives it', () => {
  for (const driver of [PIO0, PIO1]) {
    const bench = watchedBy([PIO0, PIO1], driver);
    const arrived = (base) => {
      bench.base = base;
      return [2, 2, 11].map((at, index) => at === bench.read(bench.sm(index, SM.addr)));
    };
    const risen = bench.core.cycles;
    bench.force(3, set(TO.pins, 1));
    bench.runTo(risen + 1);
    assert.deepEqual([...arrived(PIO0), ...arrived(PIO1)], new Array(6).fill(false));
    bench.runTo(risen + 2);
    const [first, second] = [arrived(PIO0), arrived(PIO1)];
    assert.deepEqual(first, second);
    assert.equal(first[2], true);
    assert.notEqual(first[0], first[1]);
    bench.runTo(risen + 3);
    assert.deepEqual([...arrived(PIO0), ...arrived(PIO1)], new Array(6).fill(true));
  }
});
