import assert from 'node:assert/strict';
import test from 'node:test';
import { run } from '../src/core.mjs';
import { DMA, PIO0, PioBench, RAM, REG } from '../support/pio-bench.mjs';
import { axes, INHIBIT_FLAG, openBarrier, OVERHEAD_CYCLES, rises } from '../support/step-program.mjs';

const CHANNEL = 0x40;
const CH = { read: 0x00, write: 0x04, count: 0x08, trigger: 0x0c, al1Ctrl: 0x10, al3ReadTrigger: 0x3c };
const [INTR, INTE0, INTS0, MULTI, ABORT] = [0x400, 0x404, 0x40c, 0x430, 0x444];
const UNPACED = 63;

const control = ({ chainTo, request = UNPACED, size = 2, read = 1, write = 0, quiet = 0, ring = 0, enabled = 1 }) =>
  (quiet << 21) | (request << 15) | (chainTo << 11) | (ring << 6) | (write << 5) | (read << 4) | (size << 2) | enabled;

function channel(bench, index, { from, to, count, ctrl, trigger = false }) {
  const base = DMA + index * CHANNEL;
  bench.writeAt(base + CH.read, from);
  bench.writeAt(base + CH.write, to);
  bench.writeAt(base + CH.count, count);
  bench.writeAt(base + (trigger ? CH.trigger : CH.al1Ctrl), ctrl);
}

test('memory to memory: a word a cycle, an interrupt at the end', () => {
  const bench = new PioBench();
  bench.bus.ram32.set([1, 2, 3, 4], 0);
  bench.writeAt(DMA + INTE0, 1 << 3);
  channel(bench, 3, { from: RAM, to: RAM + 64, count: 4, ctrl: control({ chainTo: 3, write: 1 }), trigger: true });
  bench.run(6);
  assert.equal(bench.readAt(DMA + 3 * CHANNEL + CH.count), 1);
  assert.equal(bench.readAt(DMA + 3 * CHANNEL + CH.trigger) >>> 24, 1);
  assert.equal(bench.pending(11), false);
  bench.run(1);
  assert.deepEqual([...bench.bus.ram32.slice(16, 20)], [1, 2, 3, 4]);
  assert.equal(bench.pending(11), true);
  assert.equal(bench.readAt(DMA + INTS0), 1 << 3);
  bench.writeAt(DMA + INTR, 1 << 3);
  assert.equal(bench.pending(11), false);
});

test('bytes, rings and aborts', () => {
  const bench = new PioBench();
  bench.bus.ram8.set([1, 2, 3, 4], 0);
  channel(bench, 0, { from: RAM, to: RAM + 64, count: 6, ctrl: control({ chainTo: 0, size: 0, write: 1, ring: 2 }), trigger: true });
  bench.run(20);
  assert.deepEqual([...bench.bus.ram8.slice(64, 70)], [1, 2, 3, 4, 1, 2]);
  channel(bench, 0, { from: RAM, to: RAM + 128, count: 1000, ctrl: control({ chainTo: 0, size: 0, write: 1 }), trigger: true });
  bench.run(10);
  bench.writeAt(DMA + ABORT, 1);
  bench.run(100);
  assert.equal(bench.readAt(DMA + CH.count), 993);
  assert.equal(bench.readAt(DMA + CH.trigger) >>> 24, 0);
});

test('a null trigger starts nothing, and ends a quiet chain with an interrupt', () => {
  const bench = new PioBench();
  channel(bench, 1, { from: RAM, to: RAM + 64, count: 1, ctrl: control({ chainTo: 1, quiet: 1 }), trigger: true });
  bench.run(10);
  assert.equal(bench.readAt(DMA + INTR), 0);
  bench.writeAt(DMA + CHANNEL + CH.al3ReadTrigger, 0);
  assert.equal(bench.readAt(DMA + INTR), 2);
});

test('a bad address halts the channel and says so', () => {
  const bench = new PioBench();
  channel(bench, 0, { from: 0x30000000, to: RAM, count: 2, ctrl: control({ chainTo: 0 }), trigger: true });
  bench.run(10);
  assert.equal(bench.readAt(DMA + CH.trigger) >>> 24, 0xe0);
});

const WORDS = 64;
const PULSE = 14;
const MEGAHERTZ = 125 - OVERHEAD_CYCLES - PULSE;

/** Two channels that supply each axis in turn, from one buffer each. */
function pingPong(bench, axis) {
  const buffers = [RAM + 0x1000 * (axis + 1), RAM + 0x1000 * (axis + 1) + 4 * WORDS];
  for (const buffer of buffers) bench.bus.ram32.fill(MEGAHERTZ | 0, (buffer - RAM) / 4, (buffer - RAM) / 4 + WORDS);
  buffers.forEach((from, turn) => {
    const index = 2 * axis + turn;
    const ctrl = control({ chainTo: 2 * axis + 1 - turn, request: axis, ring: 8 });
    channel(bench, index, { from, to: PIO0 + REG.txf + 4 * axis, count: WORDS, ctrl });
  });
  bench.writeAt(DMA + MULTI, 1 << (2 * axis));
}

test('three axes at 1,000,000 steps/s by two channels each, without a gap', () => {
  const bench = new PioBench();
  const edges = axes(bench, 3, PULSE);
  for (const axis of [0, 1, 2]) pingPong(bench, axis);
  bench.run(100);
  assert.equal(bench.read(REG.flevel), 0x080808);
  openBarrier(bench);
  bench.run(125 * 1000);
  for (const each of edges.map(rises)) {
    assert.ok(each.length >= 999);
    assert.ok(each.every((cycle, index) => index === 0 || cycle - each[index - 1] === 125));
  }
  assert.equal(bench.readAt(DMA + INTR) & 0x3f, 0x3f);
});

test('a chain that is cut on the fly ends with its buffer', () => {
  const bench = new PioBench();
  const [edges] = axes(bench, 1, PULSE);
  pingPong(bench, 0);
  bench.run(100);
  openBarrier(bench);
  bench.run(125 * 20);
  bench.writeAt(DMA + CH.al1Ctrl, control({ chainTo: 0, request: 0, ring: 8 }));
  bench.run(125 * 200);
  assert.equal(rises(edges).length, WORDS);
  assert.equal(bench.read(REG.irq), 1 | (1 << INHIBIT_FLAG));
});

/**
 * The core runs two-cycle loads of one word, with code in another bank or the same one, while the DMA moves a word on
 * every cycle.
 */
function loads(bench, { code, data, dma }) {
  const [LDR, COUNT] = [0x6808, 16];
  bench.bus.ram16.fill(LDR, (code - RAM) / 2, (code - RAM) / 2 + COUNT);
  Object.assign(bench.bus.registers, { 1: data, 15: code });
  if (dma !== undefined) channel(bench, 0, { from: dma, to: PIO0 + REG.irqForce, count: 1000, ctrl: control({ chainTo: 0, read: 0 }), trigger: true });
  bench.run(10);
  const started = bench.core.cycles;
  for (let index = 0; index < COUNT; index++) run(bench.core, bench.bus, bench.clock, bench.core.cycles + 1);
  return bench.core.cycles - started;
}

test('the core waits a cycle for a bank of RAM that the DMA uses', () => {
  const [code, small] = [RAM + 0x40000, RAM + 0x41000];
  const taken = (places) => loads(new PioBench(), { code, data: RAM + 0x100, ...places });
  assert.equal(taken({}), 32);
  // Consecutive words are in the striped banks in turn. Those above are in one bank each.
  assert.equal(taken({ dma: RAM + 0x204 }), 32);
  assert.equal(taken({ dma: small }), 32);
  assert.equal(taken({ dma: RAM + 0x210 }), 32 + 16);
  // Of two instructions in a word, one is fetched together with the other.
  assert.equal(taken({ dma: code + 0x100 }), 32 + 8);
  assert.equal(taken({ dma: small, data: small + 4 }), 32 + 16);
});

test('a core that sleeps waits for no bank', () => {
  const bench = new PioBench();
  bench.core.waiting = true;
  bench.bus.read32(RAM);
  channel(bench, 0, { from: RAM, to: RAM + 64, count: 8, ctrl: control({ chainTo: 0, read: 0 }), trigger: true });
  bench.runTo(100);
  assert.equal(bench.core.cycles, 100);
});
