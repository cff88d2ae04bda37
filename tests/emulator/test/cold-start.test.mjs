import assert from 'node:assert/strict';
import test from 'node:test';
import { MachineClock } from '../src/clock.mjs';
import { Console } from '../src/console.mjs';
import { parseScript, ScriptRun } from '../src/script.mjs';
import { Transcript } from '../src/transcript.mjs';
import { FlashCounts, XipCache } from '../src/xip-cache.mjs';

const FLASH = 0x10000000;

/** A board whose bytes stay on the cable until the test releases some. */
function cabled() {
  const clock = new MachineClock();
  const cable = { unsent: 0 };
  const board = { clock, cable, nanos: 0, send: (bytes) => (cable.unsent += bytes.length) };
  const arrive = (count, nanos) => {
    cable.unsent -= count;
    board.nanos = nanos;
    board.onDelivered();
  };
  return { board, arrive };
}

const line = (text) => new TextEncoder().encode(`${text}\n`);

test('a line has arrived with its last byte, whatever else is on the cable', () => {
  const { board, arrive } = cabled();
  const sender = new Console(board, new Transcript());
  sender.send(Uint8Array.of(0x3f));
  const [first, second] = [sender.sendLine(line('G0 X1')), sender.sendLine(line('G0'))];
  arrive(6, 800);
  assert.equal(first.arrivedNanos, null);
  arrive(3, 1600);
  assert.deepEqual([first.arrivedNanos, second.arrivedNanos], [1600, null]);
  arrive(1, 2400);
  assert.equal(second.arrivedNanos, 2400);
});

test('a cold cache holds nothing, and is at leisure', () => {
  const clock = new MachineClock();
  const cache = new XipCache(clock, new FlashCounts(), 1);
  cache.setWordCycles(34);
  const miss = cache.read(FLASH);
  clock.core.cycles += 1000;
  assert.ok(miss > 34);
  assert.equal(cache.read(FLASH), 0);
  const { board } = cabled();
  const script = new ScriptRun(new Console({ ...board, clock, cache }, new Transcript()), parseScript('cold-cache'), { pollHz: 0, timeoutSeconds: 1 });
  script.run();
  assert.equal(cache.read(FLASH), miss);
});
