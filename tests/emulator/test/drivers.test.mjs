import assert from 'node:assert/strict';
import test from 'node:test';
import { Board } from '../src/board.mjs';
import { parseOptions } from '../src/options.mjs';
import { REGISTER } from '../src/tmc2209-registers.mjs';
import { TmcBench } from '../support/tmc-bench.mjs';

const { GSTAT, IFCNT, TCOOLTHRS } = REGISTER;
const STEP_CYCLES = 31_250;

test('an SKR Pico has four drivers on its UART1, each with its address and pins', () => {
  const bench = new TmcBench().withGantry();
  const readInputs = ['05 00 06 6f', '05 02 06 34', '05 01 06 d9', '05 03 06 82'];
  const inputs = () => readInputs.map((request) => bench.exchange(request).slice(9, 20));
  assert.deepEqual(inputs(), ['21 00 00 40', '21 00 00 48', '21 00 00 44', '21 00 00 4c']);
  bench.set('Y', 'enable', true);
  bench.set('Z', 'dir', true);
  bench.set('A', 'step', true);
  assert.deepEqual(inputs(), ['21 00 00 40', '21 00 00 49', '21 00 02 44', '21 00 00 cc']);
  assert.deepEqual(bench.gantry.drivers.summary().Z, { address: 1, microsteps: 32, irun: 31, ihold: 16, chopper: 'StealthChop', reads: 2, writes: 0, refused: 0 });
});

test('a Pico has none', () => {
  const bench = new TmcBench().withGantry({ board: 'pico' });
  assert.equal(bench.gantry.drivers, null);
  bench.send('05 00 06 6f');
  bench.run(1_000_000);
  assert.equal(bench.received(), '');
});

test('the second motor has the fourth driver', () => {
  const bench = new TmcBench().withGantry({ startMm: [35, 0.04, 15], hardEndsMm: 0, second: { axis: 'Y', skewMm: 0 }, driverStates: [['2', 'open']] });
  const { gantry } = bench;
  bench.step('A', 3, STEP_CYCLES);
  assert.deepEqual([gantry.second.carriage.lostSteps, gantry.drivers.of('2').address], [3, 3]);
  gantry.drivers.of('2').set('well');
  bench.step('A', 3, STEP_CYCLES);
  assert.equal(gantry.second.carriage.lostSteps, 4);
});

test('a chip that restarts finds the drivers as they are, and one whose power was off finds them new', () => {
  const loop = [{ address: 0x10000100, bytes: new Uint8Array(Uint32Array.of(0x20001000, 0x10000109, 0xe7fe).buffer) }];
  const board = new Board(loop, { board: 'skr-pico', console: 'uart', startMm: [35, 40, 15], bounceMicros: 0, seed: 1, switches: {}, driverStates: [['Y', 'off']] });
  const [x, y] = ['X', 'Y'].map((axis) => board.gantry.drivers.of(axis));
  x.write(GSTAT, 1);
  x.write(TCOOLTHRS, 1);
  board.leaveBootsel();
  assert.deepEqual([x.read(IFCNT), x.read(GSTAT)], [2, 0]);
  board.powerCycle();
  assert.deepEqual([x.read(IFCNT), x.read(GSTAT)], [0, 1]);
  assert.equal(y.powered, false);
});

test('a chip that restarts no longer drives ENABLE, which is low then', () => {
  const bench = new TmcBench().withGantry();
  const driver = bench.gantry.drivers.of('X');
  bench.set('X', 'enable', true);
  assert.equal(driver.energised, false);
  bench.gantry.attach(new TmcBench().chip);
  assert.equal(driver.energised, true);
});

test('jumpers, ends and the drivers’ states are options, of a board that talks to its drivers', () => {
  const options = (...args) => parseOptions(['--elf', 'a', '--live', ...args]);
  const { diag, hardEndsMm, driverStates } = options('--board', 'skr-pico', '--diag', 'X,Z', '--hard-ends', '0.5', '--driver-state', 'X=late');
  assert.deepEqual([diag, hardEndsMm, driverStates], [['X', 'Z'], 0.5, [['X', 'late']]]);
  assert.deepEqual([options().diag, options().hardEndsMm, options().driverStates], [[], null, []]);
  assert.throws(() => options('--diag', 'X'), /--diag: the drivers of a pico have no UART: use --board skr-pico/);
  assert.throws(() => options('--driver-state', 'X=off'), /--driver-state: the drivers of a pico have no UART/);
  assert.throws(() => options('--board', 'skr-pico', '--diag', 'A'), /--diag A: choose X or Y or Z/);
  assert.throws(() => options('--board', 'skr-pico', '--driver-state', 'X=cold'), /--driver-state cold: choose on or off or late/);
  assert.throws(() => options('--hard-ends=-1'), /--hard-ends -1: give a number from 0 to 1000/);
});
