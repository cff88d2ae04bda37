import assert from 'node:assert/strict';
import test from 'node:test';
import { CONDITION, FROM, irqSet, irqWait, jmp, mov, OPERATION, pull, push, REL, set, shiftIn, shiftOut, TO, waitGpio, waitIrq } from '../support/pio-assembly.mjs';
import { PIO1, PioBench, REG, SM } from '../support/pio-bench.mjs';
import { announceEnd, axes, INHIBIT_FLAG, DIR_HIGH, HALTED_AT, openBarrier, OVERHEAD_CYCLES, REST, rises, STARVED_AT, TURN_CYCLES } from '../support/step-program.mjs';

/** A side-set of one pin, without a delay. */
const SIDE_HIGH = 16;

test('a square wave: set pins with delays, exact to the cycle', () => {
  const bench = new PioBench();
  const edges = bench.watch(2);
  bench.load([set(TO.directions, 1), set(TO.pins, 1, 3), set(TO.pins, 0, 5)]);
  bench.configure(0, { execctrl: (2 << 12) | (1 << 7), pinctrl: (1 << 26) | (2 << 5) });
  bench.runTo(100);
  bench.write(REG.ctrl, 1);
  bench.runTo(125);
  assert.deepEqual(edges, [[102, 1], [106, 0], [112, 1], [116, 0], [122, 1]]);
});

test('the divider stretches ticks, by its fraction too', () => {
  const bench = new PioBench();
  const edges = bench.watch(2);
  bench.load([set(TO.pins, 1), set(TO.pins, 0)]);
  bench.configure(0, { clkdiv: 0x28000, execctrl: 1 << 12, pinctrl: (1 << 26) | (2 << 5) });
  bench.force(0, set(TO.directions, 1));
  bench.runTo(10);
  bench.write(REG.ctrl, 1);
  bench.runTo(22);
  assert.deepEqual(edges, [[11, 1], [13, 0], [16, 1], [18, 0], [21, 1]]);
});

test('a machine that counts X down on the spot shows X and its place when asked', () => {
  const bench = new PioBench();
  bench.load([set(TO.x, 20), jmp(CONDITION.xCounts, 1, 1), irqWait(0)]);
  bench.configure(0, {});
  bench.write(REG.ctrl, 1);
  // `set` is on cycle 1. Rounds of two cycles begin on 2, 4, ... 42. After five of them X is 15.
  bench.runTo(11);
  assert.equal(bench.read(bench.sm(0, SM.addr)), 1);
  bench.force(0, mov(TO.isr, FROM.x), push());
  assert.equal(bench.read(REG.rxf), 15);
  bench.runTo(43);
  assert.equal(bench.read(bench.sm(0, SM.addr)), 2);
  bench.runTo(44);
  assert.equal(bench.read(REG.irq), 1);
});

test('a machine that begins by counting X down on the spot is given another X on the way', () => {
  const bench = new PioBench();
  bench.load([jmp(CONDITION.xCounts, 0), irqWait(0)]);
  bench.configure(0, {});
  bench.force(0, set(TO.x, 20));
  bench.write(REG.ctrl, 1);
  bench.runTo(15);
  bench.force(0, set(TO.x, 20));
  assert.equal(bench.clock.lockstep.next, 16);
  bench.runTo(16);
  assert.equal(bench.clock.lockstep.next, 37, 'the rounds cost nothing');
  bench.runTo(36);
  assert.equal(bench.read(REG.irq), 0);
  bench.runTo(37);
  assert.equal(bench.read(REG.irq), 1);
});

test('a machine that only jumps to the same instruction costs nothing, until its program changes or it is made to jump', () => {
  const bench = new PioBench();
  const edges = bench.watch(2);
  bench.load([jmp(CONDITION.always, 0), set(TO.pins, 1), set(TO.pins, 0), jmp(CONDITION.always, 0)]);
  bench.configure(0, { clkdiv: 0x28000, pinctrl: (1 << 26) | (2 << 5) });
  bench.force(0, set(TO.directions, 1));
  bench.write(REG.ctrl, 1);
  bench.runTo(20);
  assert.equal(bench.clock.lockstep.next, Infinity);
  assert.equal(bench.read(bench.sm(0, SM.addr)), 0);
  // Its ticks are at 1, 3.5, 6, ... 21, 23.5, 26 and 28.5.
  bench.force(0, jmp(CONDITION.always, 1));
  bench.runTo(40);
  assert.deepEqual(edges, [[21, 1], [23, 0]]);
  bench.load([jmp(CONDITION.always, 2), set(TO.pins, 0), set(TO.pins, 1)]);
  bench.runTo(50);
  assert.deepEqual(edges.slice(2), [[43, 1]]);
});

test('a machine that only jumps to the same instruction lowers its side pin after another instruction raised it', () => {
  const bench = new PioBench();
  const edges = bench.watch(2);
  bench.load([jmp(CONDITION.always, 0)]);
  bench.configure(0, { pinctrl: (1 << 29) | (1 << 26) | (2 << 10) | (2 << 5) });
  bench.force(0, set(TO.directions, 1));
  bench.write(REG.ctrl, 1);
  bench.runTo(20);
  bench.force(0, set(TO.x, 0, SIDE_HIGH));
  bench.runTo(30);
  assert.deepEqual(edges, [[20, 1], [21, 0]]);
});

/** Looks at pins 9 to 12 every four cycles, from the third on, and at each change raises its flag and keeps the levels in X. */
const WATCH = [irqSet(REL), mov(TO.x, FROM.y), mov(TO.isr, FROM.null), shiftIn(FROM.pins, 4), mov(TO.y, FROM.isr), jmp(CONDITION.different, 0)];

function watchPins(bench, { clkdiv = 0x10000 } = {}) {
  bench.load(WATCH);
  bench.configure(0, { clkdiv, execctrl: (5 << 12) | (2 << 7), shiftctrl: 0x80000, pinctrl: 9 << 15 });
  bench.force(0, set(TO.x, 0), jmp(CONDITION.always, 2));
  bench.write(REG.ctrl, 1);
}

test('a machine that only looks at pins costs nothing, and looks when it would have', () => {
  for (let wait = 100; wait < 108; wait++) {
    for (const [clkdiv, period] of [[0x10000, 1], [0x28000, 2.5]]) {
      const bench = new PioBench();
      watchPins(bench, { clkdiv });
      bench.runTo(wait);
      assert.equal(bench.clock.lockstep.next, Infinity);
      // Other pins are not its business, and change while it is at rest.
      bench.input(8, true);
      bench.input(13, true);
      assert.equal(bench.clock.lockstep.next, Infinity);
      bench.input(11, true);
      // Its ticks are on 1, 1 + period and so on, and every fourth is a look, from the second on.
      const look = Math.ceil((wait + 2 - 1 - period) / (4 * period));
      const flag = Math.floor(1 + period + look * 4 * period + 3 * period);
      bench.runTo(flag - 1);
      assert.equal(bench.read(REG.irq), 0, `${wait}`);
      bench.runTo(flag);
      assert.equal(bench.read(REG.irq), 1, `${wait}`);
      bench.runTo(flag + 100);
      assert.equal(bench.clock.lockstep.next, Infinity);
    }
  }
});

test('a pulse between two looks is not seen, and one that a look falls into is', () => {
  const seen = [0, 1, 2, 3, 4, 5, 6, 7].map((wait) => {
    const bench = new PioBench();
    watchPins(bench);
    bench.runTo(100 + wait);
    bench.input(9, true);
    bench.run(1);
    bench.input(9, false);
    bench.run(20);
    return bench.read(REG.irq);
  });
  // The looks are on 98, 102 and so on, and see what came two cycles before.
  assert.deepEqual(seen, [1, 0, 0, 0, 1, 0, 0, 0]);
});

test('a machine that only looks at pins shows its place when asked, and goes on from it', () => {
  const bench = new PioBench();
  watchPins(bench);
  const places = [];
  for (let cycle = 101; cycle < 109; cycle++) {
    bench.runTo(cycle);
    places.push(bench.read(bench.sm(0, SM.addr)));
  }
  assert.deepEqual(places, [3, 4, 5, 2, 3, 4, 5, 2]);
  bench.runTo(150);
  bench.input(10, true);
  // The change is seen from 152 on, and the look is on 154: until then it has been looking at the old levels.
  bench.runTo(153);
  assert.equal(bench.read(bench.sm(0, SM.addr)), 3);
  bench.runTo(156);
  assert.equal(bench.read(REG.irq), 0);
  bench.runTo(157);
  assert.equal(bench.read(REG.irq), 1);
  // While it is disabled it sees nothing.
  bench.runTo(200);
  bench.write(REG.ctrl, 0);
  bench.write(REG.irq, 1);
  bench.input(10, false);
  bench.runTo(300);
  assert.equal(bench.read(REG.irq), 0);
  bench.write(REG.ctrl, 1);
  bench.run(20);
  assert.equal(bench.read(REG.irq), 1);
});

test('forced instructions run on a disabled machine, and one that stalls waits', () => {
  const bench = new PioBench();
  bench.configure(0, {});
  bench.force(0, set(TO.x, 7), mov(TO.y, FROM.x, OPERATION.invert), mov(TO.isr, FROM.y), push());
  assert.equal(bench.read(REG.rxf), 0xfffffff8);
  bench.force(0, pull());
  assert.equal(bench.read(bench.sm(0, SM.execctrl)) >>> 31, 1);
  bench.write(REG.txf, 0x1234);
  bench.run(2);
  assert.equal(bench.read(bench.sm(0, SM.execctrl)) >>> 31, 0);
  bench.force(0, mov(TO.isr, FROM.osr, OPERATION.reverse), push());
  assert.equal(bench.read(REG.rxf), 0x2c480000);
  bench.force(0, jmp(CONDITION.always, 9));
  assert.equal(bench.read(bench.sm(0, SM.addr)), 9);
});

test('joined FIFOs are eight deep, and joining empties them', () => {
  const bench = new PioBench();
  bench.configure(1, {});
  for (let word = 0; word < 5; word++) bench.write(REG.txf + 4, word);
  assert.equal(bench.read(REG.flevel), 4 << 8);
  assert.equal(bench.read(REG.fdebug), 1 << 17);
  bench.configure(1, { shiftctrl: 0x400c0000 });
  assert.equal(bench.read(REG.flevel), 0);
  for (let word = 0; word < 8; word++) bench.write(REG.txf + 4, word);
  assert.equal((bench.read(REG.fstat) >> 16) & 0xf, 2);
  assert.equal(bench.read(REG.flevel), 8 << 8);
  bench.read(REG.rxf);
  assert.equal(bench.read(REG.fdebug) & 0x100, 0x100);
});

test('autopull and autopush keep a stream going at a word a cycle', () => {
  const bench = new PioBench();
  bench.load([shiftOut(TO.x, 8), shiftIn(FROM.x, 8)]);
  bench.configure(0, { execctrl: 1 << 12, shiftctrl: 0x000f0000 });
  for (const word of [0x04030201, 0x08070605]) bench.write(REG.txf, word);
  bench.write(REG.ctrl, 1);
  bench.run(40);
  assert.deepEqual([bench.read(REG.rxf), bench.read(REG.rxf)], [0x04030201, 0x08070605]);
  assert.equal(bench.read(REG.fdebug) >>> 24, 1);
});

test('out exec and mov exec bring in an instruction, with its delay and not their own', () => {
  const bench = new PioBench();
  bench.load([pull(), shiftOut(TO.outExec, 16, 7), irqWait(1)]);
  bench.configure(0, {});
  bench.write(REG.txf, set(TO.y, 9, 3));
  bench.write(REG.ctrl, 1);
  // `pull` on 1, `out` on 2, `set y` on 3 with three more cycles, `irq` on 7.
  bench.runTo(6);
  assert.equal(bench.read(REG.irq), 0);
  bench.runTo(7);
  assert.equal(bench.read(REG.irq), 2);
  bench.force(0, mov(TO.isr, FROM.y), push());
  assert.equal(bench.read(REG.rxf), 9);
});

test('an input is seen two cycles later, by waiting and by jumping', () => {
  const bench = new PioBench(PIO1);
  bench.load([waitGpio(0, 9), irqWait(REL)]);
  bench.input(9, true);
  bench.write(REG.inte, 1 << 10);
  bench.configure(2, {});
  bench.run(5);
  bench.write(REG.ctrl, 4);
  bench.runTo(100);
  bench.input(9, false);
  bench.runTo(102);
  assert.equal(bench.read(bench.sm(2, SM.addr)), 1);
  assert.equal(bench.pending(9), false);
  bench.runTo(103);
  assert.equal(bench.read(REG.irq), 4);
  assert.equal(bench.read(REG.ints), 1 << 10);
  assert.equal(bench.pending(9), true);
  bench.write(REG.irq, 4);
  assert.equal(bench.pending(9), false);
  bench.run(1);
  assert.equal(bench.read(bench.sm(2, SM.addr)), 2);
});

test('waiting for a flag takes it, and of two that set and clear one on one cycle both are heard', () => {
  const bench = new PioBench();
  bench.load([waitIrq(1, 5), set(TO.x, 3), jmp(CONDITION.always, 2)]);
  bench.configure(0, {});
  bench.write(REG.ctrl, 1);
  bench.runTo(50);
  assert.equal(bench.read(bench.sm(0, SM.addr)), 0);
  bench.write(REG.irqForce, 0x20);
  bench.runTo(51);
  assert.equal(bench.read(REG.irq), 0);
  assert.equal(bench.read(bench.sm(0, SM.addr)), 1);
});

test('set, clear and toggle aliases work on CTRL', () => {
  const bench = new PioBench();
  bench.write(REG.ctrl | 0x2000, 5);
  bench.write(REG.ctrl | 0x3000, 4);
  bench.write(REG.ctrl | 0x1000, 3);
  assert.equal(bench.read(REG.ctrl), 2);
});

test('a start barrier of flag 6 starts three axes on one cycle', () => {
  const bench = new PioBench();
  const edges = axes(bench, 3, 10);
  for (const index of [0, 1, 2]) bench.write(REG.txf + 4 * index, 40);
  bench.runTo(500);
  assert.deepEqual(edges, [[], [], []]);
  openBarrier(bench);
  bench.runTo(700);
  const [x, y, z] = edges.map(rises);
  // The start barrier is seen on 501. Then come six instructions with 41 rounds of the wait, and the edge.
  assert.deepEqual(x, [501 + 6 + 41 + 1]);
  assert.deepEqual([y, z], [x, x]);
  assert.deepEqual(edges[0][1], [x[0] + 1 + 1 + 11 + 1, 0]);
});

test('steps follow each other by their words, and a rest is only time', () => {
  const bench = new PioBench();
  const [edges] = axes(bench, 1, 10);
  for (const word of [0, 89, REST + 50, 0]) bench.write(REG.txf, word);
  bench.runTo(500);
  openBarrier(bench);
  bench.runTo(1000);
  const [first, second, third] = rises(edges);
  assert.equal(second - first, OVERHEAD_CYCLES + 10 + 89);
  // A rest: eight instructions and 51 rounds.
  assert.equal(third - second, OVERHEAD_CYCLES + 10 + 8 + 51);
});

test('DIR changes with the word of a step, and a rest leaves it', () => {
  const bench = new PioBench();
  const [edges] = axes(bench, 1, 10);
  const turns = bench.watch(3);
  for (const word of [DIR_HIGH + 5, DIR_HIGH + 5, REST + 50, 5]) bench.write(REG.txf, word);
  openBarrier(bench);
  bench.run(500);
  const falls = edges.filter(([, level]) => level === 0).map(([cycle]) => cycle);
  const [first] = rises(edges);
  // Before the wait of six rounds, the look at the inhibit, and the edge.
  assert.deepEqual(turns, [[first - 1 - 1 - 6 - 1, 1], [falls[1] + 8 + 51 + TURN_CYCLES, 0]]);
});

test('an inhibit of flag 7 stops the edges at once, leaves pulses whole, and Y has counted them', () => {
  const bench = new PioBench();
  const [edges] = axes(bench, 1, 30);
  for (let step = 0; step < 8; step++) bench.write(REG.txf, 80);
  openBarrier(bench);
  const start = bench.core.cycles;
  const period = OVERHEAD_CYCLES + 30 + 80;
  // In the middle of the third pulse.
  bench.runTo(start + 88 + 2 * period + 5);
  bench.write(REG.irqForce, 1 << 7);
  bench.run(2000);
  assert.equal(edges.length, 6);
  assert.equal(edges[5][0] - edges[4][0], 34);
  bench.write(REG.ctrl, 0);
  bench.configure(0, { shiftctrl: 0xc0000 });
  bench.force(0, mov(TO.isr, FROM.y), push());
  assert.equal(0xffffffff - bench.read(REG.rxf), 3);
});

test('a machine that runs dry before its end says so by its flag, halts, and inhibits the others', () => {
  const bench = new PioBench();
  const [first, second] = axes(bench, 2, 10);
  for (const word of [20, 20]) bench.write(REG.txf, word);
  for (const word of [20, 40, 40]) bench.write(REG.txf + 4, word);
  openBarrier(bench);
  bench.run(400);
  assert.deepEqual([rises(first).length, rises(second).length], [2, 2]);
  assert.equal(bench.read(REG.irq), 1 | (1 << INHIBIT_FLAG));
  assert.equal(bench.read(bench.sm(0, SM.addr)), STARVED_AT);
});

test('a machine that runs dry at its end says so by its flag, and halts', () => {
  const bench = new PioBench();
  bench.write(REG.inte, 1 << 8);
  const [edges] = axes(bench, 1, 10);
  for (const word of [20, 20]) bench.write(REG.txf, word);
  announceEnd(bench, 0);
  openBarrier(bench);
  bench.run(40);
  assert.equal(bench.pending(7), false);
  bench.run(60);
  assert.equal(bench.pending(7), true);
  assert.equal(bench.read(bench.sm(0, SM.addr)), HALTED_AT);
  assert.equal(rises(edges).length, 2);
  assert.equal(bench.read(REG.fdebug) >>> 24, 0);
});
