import assert from 'node:assert/strict';
import test from 'node:test';
import { BOARDS } from '../src/pins.mjs';
import { REGISTER } from '../src/tmc2209-registers.mjs';
import { TmcBench } from '../support/tmc-bench.mjs';

const { GCONF, TPWMTHRS, TCOOLTHRS, SGTHRS, SG_RESULT } = REGISTER;
const X_LIMIT = BOARDS['skr-pico'].axes.X.limit;
/** Of X: 8 microsteps, each 32/256 of a full step. 4,000 steps/s are a TSTEP of 93; 2^20 clocks are 87 ms. */
const FAST_CYCLES = 31_250;
const STANDSTILL_CYCLES = 10_922_667;
const [NEAR, FAR] = [{ startMm: [1, 40, 15] }, { startMm: [35, 40, 15] }];
const DIAG = { diag: ['X'], hardEndsMm: 0 };

/** X goes down fast, with a threshold of 50 at TSTEPs up to 200. */
function machine(options) {
  const bench = new TmcBench().withGantry(options);
  const driver = bench.gantry.drivers.of('X');
  driver.write(SGTHRS, 50);
  driver.write(TCOOLTHRS, 200);
  return { bench, driver, gantry: bench.gantry, limit: () => bench.chip.gpio[X_LIMIT].rawInputValue, carriage: bench.gantry.carriages.X };
}

test('a motor that runs freely shows some 200, always even, and the same for a seed', () => {
  const loads = (seed) => {
    const { bench, driver } = machine({ ...FAR, seed });
    // The first full step is measured with the first step, at no speed.
    bench.step('X', 1, FAST_CYCLES);
    return Array.from({ length: 40 }, () => {
      bench.step('X', 8, FAST_CYCLES);
      return driver.read(SG_RESULT);
    });
  };
  const first = loads(1);
  assert.ok(first.every((load) => load >= 180 && load <= 220 && load % 2 === 0));
  assert.ok(new Set(first).size > 5);
  assert.deepEqual(loads(1), first);
  assert.notDeepEqual(loads(2), first);
});

test('at an end the load goes to 0 with the next full step, and DIAG rises', () => {
  const { bench, driver, limit, carriage } = machine({ ...NEAR, ...DIAG });
  bench.step('X', 50, FAST_CYCLES);
  assert.deepEqual([carriage.placeMm, carriage.lostSteps, limit()], [0, 0, false]);
  bench.step('X', 8, FAST_CYCLES);
  assert.deepEqual([carriage.placeMm, carriage.lostSteps, limit()], [0, 8, true]);
  assert.ok(driver.read(SG_RESULT) <= 4);
  assert.equal(carriage.positionSteps, -58);
});

test('DIAG falls with the next full step away from the end, or when the motor stands', () => {
  const away = machine({ ...NEAR, ...DIAG });
  away.bench.step('X', 58, FAST_CYCLES);
  away.bench.set('X', 'dir', true);
  away.bench.step('X', 9, FAST_CYCLES);
  assert.deepEqual([away.limit(), away.carriage.placeMm.toFixed(2)], [false, '0.18']);
  const { bench, limit } = machine({ ...NEAR, ...DIAG });
  bench.step('X', 58, FAST_CYCLES);
  bench.run(STANDSTILL_CYCLES - 101);
  assert.equal(limit(), true);
  bench.run(1);
  assert.equal(limit(), false);
});

test('no stall is seen below the speed of TCOOLTHRS, beyond that of TPWMTHRS, in SpreadCycle, or at a lower threshold', () => {
  const stalls = (register, value, cycles = FAST_CYCLES) => {
    const { bench, driver, limit } = machine({ ...NEAR, ...DIAG });
    driver.write(register, value);
    bench.step('X', 66, cycles);
    return limit();
  };
  assert.equal(stalls(TCOOLTHRS, 200), true);
  assert.equal(stalls(TCOOLTHRS, 90), false);
  assert.equal(stalls(TCOOLTHRS, 200, 3 * FAST_CYCLES), false);
  assert.equal(stalls(TPWMTHRS, 90), true);
  assert.equal(stalls(TPWMTHRS, 150), false);
  assert.equal(stalls(GCONF, 4), false);
  assert.equal(stalls(TCOOLTHRS, 0), false);
});

test('a threshold above the load of a free motor takes it for a stall', () => {
  const { bench, driver, limit } = machine({ ...FAR, ...DIAG });
  bench.step('X', 40, FAST_CYCLES);
  const load = driver.read(SG_RESULT);
  driver.write(SGTHRS, load / 2 - 1);
  assert.equal(limit(), false);
  driver.write(SGTHRS, load / 2);
  assert.equal(limit(), true);
});

test('with the jumper DIAG is the limit input, high for a stall, and the cause of a stop', () => {
  const { bench, gantry } = machine({ ...NEAR, ...DIAG });
  const causes = [];
  gantry.stops.note = (input) => causes.push(input);
  bench.step('X', 58, FAST_CYCLES);
  assert.deepEqual(causes, ['X_LIMIT']);
  assert.equal(gantry.limitSwitch('X').closed, true);
  assert.ok(!gantry.floatingInputs().includes(X_LIMIT));
});

test('without the jumper it is the switch, and without hard ends the carriage goes on', () => {
  const { bench, limit, carriage } = machine(NEAR);
  assert.equal(limit(), true);
  bench.step('X', 60, FAST_CYCLES);
  assert.equal(limit(), false);
  assert.equal(carriage.placeMm.toFixed(2), '-0.20');
});

test('a driver that trips raises DIAG, and its motor stands', () => {
  const { bench, driver, limit, carriage, gantry } = machine({ ...FAR, ...DIAG });
  bench.step('X', 5, FAST_CYCLES);
  driver.set('overheated');
  assert.equal(limit(), true);
  bench.step('X', 5, FAST_CYCLES);
  assert.deepEqual([carriage.travelSteps, carriage.positionSteps, carriage.lostSteps], [-5, -10, 5]);
  driver.set('well');
  bench.set('X', 'enable', true);
  assert.equal(limit(), false);
  assert.equal(gantry.drivers.of('Y').read(REGISTER.IOIN) & 1, 0);
});
