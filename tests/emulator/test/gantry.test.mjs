import assert from 'node:assert/strict';
import test from 'node:test';
import { Carriage } from '../src/carriage.mjs';
import { cyclesOfMicros, MachineClock } from '../src/clock.mjs';
import { DriverTiming } from '../src/driver-timing.mjs';
import { LimitSwitch, seededRandom } from '../src/limit-switch.mjs';
import { HEADER, StepTrace } from '../src/step-trace.mjs';

function switchOn(clock, bounceMicros = 0, seed = 1) {
  const levels = [];
  const onLevel = (high) => levels.push([clock.cycles, high]);
  return { levels, limitSwitch: new LimitSwitch(clock, { bounceMicros, random: seededRandom(seed), onLevel }) };
}

function runAll(clock) {
  while (clock.next < Infinity) {
    clock.core.cycles = clock.next;
    clock.fireDue();
  }
}

test('a carriage presses its switch at its place and below', () => {
  const { levels, limitSwitch } = switchOn(new MachineClock());
  const carriage = new Carriage(0.04, limitSwitch);
  carriage.step(-1);
  assert.equal(limitSwitch.closed, false);
  carriage.step(-1);
  carriage.step(-1);
  assert.equal(limitSwitch.closed, true);
  carriage.home();
  carriage.step(1);
  carriage.step(1);
  assert.equal(limitSwitch.closed, false);
  assert.deepEqual(levels.map(([, high]) => high), [false, true]);
  assert.equal(carriage.positionSteps, 2);
  assert.equal(carriage.placeMm.toFixed(2), '0.02');
  assert.equal(carriage.lowestMm.toFixed(2), '-0.02');
});

test('a stuck switch does not follow its carriage', () => {
  const { levels, limitSwitch } = switchOn(new MachineClock());
  limitSwitch.setMode('stuck-closed');
  limitSwitch.press(true);
  limitSwitch.press(false);
  limitSwitch.setMode('stuck-open');
  limitSwitch.press(true);
  limitSwitch.setMode('normal');
  assert.deepEqual(levels.map(([, high]) => high), [false, true, false]);
});

test('contacts bounce, settle in time, and do so alike for a seed', () => {
  const bounces = (seed) => {
    const clock = new MachineClock();
    const { levels, limitSwitch } = switchOn(clock, 500, seed);
    limitSwitch.press(true);
    runAll(clock);
    assert.equal(limitSwitch.closed, true);
    assert.ok(levels.at(-1)[0] <= cyclesOfMicros(500));
    return levels;
  };
  assert.ok(bounces(1).length > 2);
  assert.deepEqual(bounces(1), bounces(1));
  assert.notDeepEqual(bounces(1), bounces(2));
});

test('edges too close for the driver are counted by rule, the first with their values', () => {
  const timing = new DriverTiming();
  timing.turn('X', 1000);
  timing.rise('X', 1600);
  timing.fall('X', 3000);
  timing.rise('X', 9000);
  timing.enable(false, 9100);
  assert.equal(timing.rise('Y', 20_000), false);
  assert.deepEqual(timing.counts, { dir_setup: 1, step_high: 1, enable_hold: 1, step_while_off: 1 });
  assert.deepEqual(timing.first[0], { rule: 'dir_setup', axis: 'X', t_ns: 1600, value_ns: 600, limit_ns: 650 });
  assert.equal(timing.total, 4);
});

test('the trace has a header and a row per step', () => {
  const trace = new StepTrace();
  trace.step(8, 'X', -1, -1);
  assert.equal(trace.toString(), `${HEADER}\n8,X,-1,-1\n`);
});
