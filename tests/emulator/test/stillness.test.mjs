import assert from 'node:assert/strict';
import test from 'node:test';
import { Stillness } from '../src/stillness.mjs';

/** A gantry that steps on command. */
function gantry() {
  const stepWatchers = new Set();
  const step = (cycle) => stepWatchers.forEach((watch) => watch(cycle, 'X'));
  return { stepWatchers, step, tool: { values: { pwm: 0, flood: 0 } } };
}

test('a step by the instant is in time, the first behind it is reported', () => {
  const rig = gantry();
  const stillness = new Stillness(rig);
  rig.step(50);
  stillness.from(1000);
  rig.step(900);
  rig.step(1000);
  assert.equal(stillness.end(), null);
  stillness.from(2000);
  rig.step(2125);
  rig.step(3000);
  assert.equal(stillness.end(), 'a step of X came 1.000 us too late');
});

test('once it has ended steps may come again, and it cannot end twice', () => {
  const rig = gantry();
  const stillness = new Stillness(rig);
  stillness.from(1000);
  assert.equal(stillness.end(), null);
  rig.step(2000);
  assert.match(stillness.end(), /stop-within first/);
});

test('an output that is on at the end is reported', () => {
  const rig = gantry();
  const stillness = new Stillness(rig);
  stillness.from(1000);
  rig.tool.values.flood = 1;
  assert.equal(stillness.end(), 'the output flood is on');
});
