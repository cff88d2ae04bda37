import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test from 'node:test';
import { Belts } from '../src/belts.mjs';
import { Carriage } from '../src/carriage.mjs';
import { cyclesOfMicros, MachineClock } from '../src/clock.mjs';
import { DRIVERS, DriverTiming } from '../src/driver-timing.mjs';
import { EdgeFile } from '../src/edge-file.mjs';
import { LimitSwitch, seededRandom } from '../src/limit-switch.mjs';
import { OffTimes } from '../src/off-times.mjs';
import { HEADER, StepTrace } from '../src/step-trace.mjs';
import { Stops } from '../src/stops.mjs';

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

test('a hard end blocks a carriage, which loses the steps against it', () => {
  const { limitSwitch } = switchOn(new MachineClock());
  const carriage = new Carriage(0.04, limitSwitch, -0.02);
  for (let step = 0; step < 5; step++) carriage.step(-1);
  assert.deepEqual([carriage.placeMm.toFixed(2), carriage.positionSteps, carriage.lostSteps], ['-0.02', -5, 2]);
  assert.deepEqual([carriage.blocked(-1), carriage.blocked(1)], [true, false]);
  carriage.step(1);
  carriage.step(1, false);
  assert.deepEqual([carriage.placeMm.toFixed(2), carriage.lostSteps], ['0.00', 3]);
  // 0.58 mm are 28.999999999999996 steps in the computer.
  const rounded = new Carriage(0.58, limitSwitch, 0);
  for (let step = 0; step < 29; step++) rounded.step(-1);
  assert.equal(rounded.lostSteps, 0);
});

/** Two carriages on crossed belts, 0.04 mm above their switches, with hard ends 0.02 mm below these. */
function belts() {
  const carriages = {};
  for (const axis of ['X', 'Y']) carriages[axis] = new Carriage(0.04, switchOn(new MachineClock()).limitSwitch, -0.02);
  const each = (of) => Object.values(carriages).map(of);
  return { belts: new Belts(carriages), carriages, counts: () => each((one) => one.positionSteps), places: () => each((one) => one.travelSteps) };
}

test('a step of either motor moves both axes by half a step, and their switches follow', () => {
  const { belts: crossed, carriages, counts, places } = belts();
  crossed.step('X', 1);
  assert.deepEqual([counts(), places()], [[1, 0], [0.5, 0.5]]);
  crossed.step('Y', 1);
  assert.deepEqual([counts(), places(), crossed.placesOf([1, 1, 7])], [[1, 1], [1, 0], [1, 0, 7]]);
  for (let step = 0; step < 2; step++) crossed.step('Y', 1);
  assert.deepEqual([places(), carriages.Y.limitSwitch.closed], [[2, -1], false]);
  for (let step = 0; step < 2; step++) crossed.step('Y', 1);
  assert.deepEqual([places(), carriages.X.limitSwitch.closed, carriages.Y.limitSwitch.closed], [[3, -2], false, true]);
  assert.deepEqual([carriages.Y.lowestMm.toFixed(3), carriages.Y.highestMm.toFixed(3), carriages.X.highestMm.toFixed(3)], ['0.000', '0.050', '0.100']);
});

test('an end of either axis keeps both where they are, and the motor loses the step', () => {
  const { belts: crossed, carriages, counts, places } = belts();
  for (let step = 0; step < 7; step++) crossed.step('Y', 1);
  assert.deepEqual([counts(), places(), carriages.Y.lostSteps, carriages.X.lostSteps], [[0, 7], [3, -3], 1, 0]);
  assert.deepEqual([crossed.blocked('Y', 1), crossed.blocked('X', -1), crossed.blocked('X', 1), crossed.blocked('Y', -1)], [true, true, false, false]);
  crossed.step('X', 1, false);
  assert.deepEqual([counts(), places(), carriages.X.lostSteps], [[1, 7], [3, -3], 1]);
});

test('the counts of belts that homed along one axis keep the place along the other', () => {
  const { belts: crossed, carriages, counts } = belts();
  const at = (x, y) => ([carriages.X.positionSteps, carriages.Y.positionSteps] = [x, y]);
  at(30, 10);
  crossed.home('X');
  assert.deepEqual(counts(), [10, -10]);
  at(30, 10);
  crossed.home('Y');
  assert.deepEqual(counts(), [20, 20]);
  // Half a step beside a whole one: towards zero, as the firmware has it.
  at(-30, -11);
  crossed.home('X');
  assert.deepEqual(counts(), [-9, 9]);
  crossed.home('Y');
  assert.deepEqual(counts(), [0, 0]);
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

test('a faster driver takes shorter pulses', () => {
  const timing = new DriverTiming(DRIVERS.tmc2209);
  timing.rise('Z', 1000);
  timing.fall('Z', 1104);
  timing.rise('Z', 1200);
  assert.deepEqual(timing.counts, { step_low: 1 });
});

/** The content of a recorder's file. */
function written(Recorder, steps) {
  const folder = mkdtempSync(join(tmpdir(), 'isostep-'));
  const path = join(folder, 'steps');
  const recorder = new Recorder(path);
  for (const step of steps) recorder.step(...step);
  recorder.close();
  const content = readFileSync(path);
  rmSync(folder, { recursive: true });
  return content;
}

test('the trace has a header and a row per step', () => {
  assert.equal(written(StepTrace, [[8, 'X', -1, -1]]).toString(), `${HEADER}\n8,X,-1,-1\n`);
});

test('an edge takes eight bytes, whatever its cycle', () => {
  const cycle = 2 ** 40 + 3;
  const edges = written(EdgeFile, [[1, 'X', -1], [cycle, 'Z', 1]]);
  assert.equal(edges.length, 16);
  assert.equal(edges.readBigUInt64LE(0), 8n);
  assert.equal(edges.readBigUInt64LE(8), BigInt(cycle) * 8n + 5n);
  assert.equal(written(EdgeFile, Array(70_000).fill([1, 'Y', 1])).length, 560_000);
});

/** Steps of X every `interval` cycles, beginning with `cycle`. */
function stepping(stops, clock, cycle, interval, count) {
  for (let step = 0; step < count; step++) {
    clock.core.cycles = cycle + step * interval;
    stops.step('X', clock.core.cycles);
  }
}

test('a stop is reported with the last step before rest', () => {
  const clock = new MachineClock();
  const stops = new Stops(clock, new OffTimes(clock));
  stops.note('ESTOP');
  stepping(stops, clock, 1000, 1000, 10);
  clock.core.cycles = 10_500;
  stops.note('X_LIMIT');
  stops.note('X_LIMIT');
  stepping(stops, clock, 11_000, 1000, 2);
  stepping(stops, clock, 1_000_000, 1000, 2);
  const nanos = (cycle) => cycle * 8;
  assert.deepEqual(stops.summary(), [{ input: 'X_LIMIT', t_ns: nanos(10_500), last_edge_ns: nanos(12_000), latency_ns: nanos(1500), edges_after: 2, outputs_off_ns: 0, outputs_on_again_ns: null }]);
});

test('a reset byte says stop if the machine still brakes for another', () => {
  const clock = new MachineClock();
  const stops = new Stops(clock, new OffTimes(clock));
  const reset = (cycle) => {
    clock.core.cycles = cycle;
    stops.reset();
  };
  reset(500);
  stepping(stops, clock, 1000, 1000, 10);
  reset(10_500);
  stepping(stops, clock, 11_000, 1000, 2);
  reset(12_500);
  assert.deepEqual(stops.summary().map(({ input, t_ns }) => [input, t_ns]), [['RESET', 12_500 * 8]]);
  // A rest, and then another move.
  stepping(stops, clock, 1_000_000, 1000, 2);
  reset(1_001_500);
  assert.equal(stops.summary().length, 1);
});

test('an axis that turns has stopped before', () => {
  const clock = new MachineClock();
  const stops = new Stops(clock, new OffTimes(clock));
  stepping(stops, clock, 1000, 1000, 10);
  stops.note('RESET');
  stops.turn();
  stepping(stops, clock, 20_000, 1000, 10);
  assert.deepEqual(stops.summary().map(({ edges_after, latency_ns }) => [edges_after, latency_ns]), [[0, 0]]);
});
