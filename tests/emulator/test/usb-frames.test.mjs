import assert from 'node:assert/strict';
import test from 'node:test';
import { parseOptions } from '../src/options.mjs';
import { UsbHost } from '../src/usb-host.mjs';
import { PioBench } from '../support/pio-bench.mjs';

const USB = 0x50110000;
const [MAIN_CTRL, SOF_RD, SIE_STATUS, INTR, INTE, INTS] = [0x40, 0x48, 0x50, 0x8c, 0x90, 0x98].map((offset) => USB + offset);
const [CONTROLLER_ON, BUS_RESET, DEV_SOF] = [1, 1 << 19, 1 << 17];
const IRQ_USB = 5;
const MILLI = 125_000;

/** A chip that connects 5 ms after power-up to a host, which resets it 10 ms later. */
function connected(framePpm) {
  const bench = new PioBench();
  const host = new UsbHost(bench.clock, { onData: () => {}, onDelivered: () => {} }, framePpm);
  host.attach(bench.chip);
  const runTo = (cycle) => {
    while (bench.clock.next <= cycle) {
      bench.core.cycles = bench.clock.next;
      bench.clock.fireDue();
    }
    bench.core.cycles = cycle;
  };
  const frameAt = (cycle) => {
    runTo(cycle);
    return bench.readAt(SOF_RD);
  };
  assert.equal(frameAt(5 * MILLI), 0);
  bench.writeAt(MAIN_CTRL, CONTROLLER_ON);
  runTo(15 * MILLI);
  assert.equal(bench.readAt(SIE_STATUS) & BUS_RESET, BUS_RESET);
  assert.equal(bench.readAt(SOF_RD), 0);
  bench.writeAt(SIE_STATUS, BUS_RESET);
  return { bench, frameAt, runTo };
}

test('frames are counted each millisecond, modulo 2048', () => {
  const { frameAt } = connected();
  const frames = [16 * MILLI - 1, 16 * MILLI, 17 * MILLI - 1, 17 * MILLI, 2047 * MILLI, 2048 * MILLI, 2050 * MILLI].map(frameAt);
  assert.deepEqual(frames, [15, 16, 16, 17, 2047, 0, 2]);
});

test('longer frames come later by their parts per million, shorter ones earlier', () => {
  for (const ppm of [40, -25]) {
    const { frameAt } = connected(ppm);
    const starts = 10_000 * (MILLI + (MILLI * ppm) / 1e6);
    assert.deepEqual([frameAt(starts - 1), frameAt(starts)], [9999 & 2047, 10_000 & 2047]);
  }
});

test('a frame sets its flag until its number is read', () => {
  const { bench, runTo } = connected();
  assert.equal(bench.readAt(INTR) & DEV_SOF, 0);
  runTo(16 * MILLI);
  assert.equal(bench.readAt(INTR) & DEV_SOF, DEV_SOF);
  assert.equal(bench.readAt(INTS) & DEV_SOF, 0);
  bench.readAt(SOF_RD);
  assert.equal(bench.readAt(INTR) & DEV_SOF, 0);
  runTo(17 * MILLI);
  assert.equal(bench.readAt(INTR) & DEV_SOF, DEV_SOF);
});

test('only an interrupt that is enabled costs events, and comes on the cycle of the frame', () => {
  const { bench, runTo } = connected(3);
  runTo(100.5 * MILLI);
  assert.equal(bench.clock.next, Infinity);
  bench.readAt(SOF_RD);
  bench.writeAt(INTE, DEV_SOF);
  assert.equal(bench.pending(IRQ_USB), false);
  for (const frame of [101, 102, 103]) {
    assert.equal(bench.clock.next, Math.ceil(frame * (MILLI + 0.375)));
    runTo(bench.clock.next);
    assert.equal(bench.pending(IRQ_USB), true);
    assert.equal(bench.readAt(SOF_RD), frame);
    assert.equal(bench.pending(IRQ_USB), false);
  }
  bench.writeAt(INTE, 0);
  runTo(110 * MILLI);
  assert.equal(bench.pending(IRQ_USB), false);
  assert.equal(bench.clock.next, Infinity);
});

test('the length of frames is an option', () => {
  const ppm = (...args) => parseOptions(['--elf', 'a', '--live', ...args]).framePpm;
  assert.deepEqual([ppm(), ppm('--frame-ppm', '37.5'), ppm('--frame-ppm=-50')], [0, 37.5, -50]);
  assert.throws(() => ppm('--frame-ppm', '1e5'), /--frame-ppm 1e5: give a number from -10000 to 10000/);
});
