import assert from 'node:assert/strict';
import test from 'node:test';
import { Gantry } from '../src/gantry.mjs';
import { AXES, BOARDS, namedInputs, namedOutputs } from '../src/pins.mjs';
import { ProbePlate } from '../src/probe-plate.mjs';
import { Waveform } from '../src/waveform.mjs';
import { FUNCTION, PwmBench } from '../support/pwm-bench.mjs';

const { axes: PINS, contacts: TOOL_INPUTS, tool: TOOL_OUTPUTS } = BOARDS.pico;

const OPTIONS = { startMm: [35, 40, 15], bounceMicros: 0, seed: 1, switches: {} };
const [OUT_SET, OUT_CLEAR, OUTPUTS_SET] = [0xd0000014, 0xd0000018, 0xd0000024];
const NANOS_PER_CYCLE = 8;

/** A gantry on a chip whose STEP and DIR pins the test sets, with a plate. */
class Rig {
  constructor(plate, more = {}) {
    this.bench = new PwmBench();
    this.gantry = new Gantry(this.bench.clock, { ...OPTIONS, probePlate: plate, ...more });
    this.gantry.attach(this.bench.chip);
    for (const { step, dir } of Object.values(PINS)) for (const pin of [step, dir]) this.#output(pin);
  }

  get open() {
    return this.bench.chip.gpio[TOOL_INPUTS.probe].rawInputValue;
  }

  get summary() {
    return this.gantry.probe.summary();
  }

  /** All these axes step on one cycle. */
  step(cycle, ...axes) {
    const pins = axes.reduce((bits, axis) => bits | (1 << PINS[axis].step), 0);
    this.bench.runTo(cycle);
    this.bench.writeAt(OUT_SET, pins);
    this.bench.runTo(cycle + 300);
    this.bench.writeAt(OUT_CLEAR, pins);
  }

  up(axis) {
    this.bench.writeAt(OUT_SET, 1 << PINS[axis].dir);
  }

  #output(pin) {
    this.bench.control(pin, FUNCTION.sio);
    this.bench.writeAt(OUTPUTS_SET, 1 << pin);
  }
}

test('a plate closes the contact on the step that reaches its place, and opens it on the one that leaves', () => {
  const rig = new Rig(new ProbePlate('Z', 14.96, 'below'));
  rig.step(1000, 'Z');
  assert.equal(rig.open, true);
  rig.step(2000, 'X');
  rig.step(3000, 'Z');
  assert.equal(rig.open, false);
  rig.step(4000, 'Z');
  rig.up('Z');
  rig.step(5000, 'Z');
  assert.equal(rig.open, false);
  rig.step(6000, 'Z');
  assert.equal(rig.open, true);
  assert.deepEqual(rig.summary.contacts, [{ t_ns: 3000 * NANOS_PER_CYCLE, axis: 'Z', position_steps: [-1, 0, -2] }]);
  assert.deepEqual(rig.summary.releases, [{ t_ns: 6000 * NANOS_PER_CYCLE, axis: 'Z', position_steps: [-1, 0, -1] }]);
});

test('a plate above touches at its place and above', () => {
  const rig = new Rig(new ProbePlate('X', 35.04, 'above'));
  rig.up('X');
  rig.step(1000, 'X');
  assert.equal(rig.open, true);
  rig.step(2000, 'X');
  assert.equal(rig.open, false);
});

test('a contact is reported with all the steps of its cycle', () => {
  const rig = new Rig(new ProbePlate('X', 34.98, 'below'));
  rig.step(1000, 'X', 'Z');
  rig.step(2000, 'Z');
  assert.deepEqual(rig.summary.contacts, [{ t_ns: 1000 * NANOS_PER_CYCLE, axis: 'X', position_steps: [-1, 0, -1] }]);
});

test('every place of a whole step is met, whatever its decimals', () => {
  for (let steps = 1; steps <= 500; steps++) {
    const plate = new ProbePlate('Z', Number((15 - steps / 50).toFixed(2)), 'below');
    assert.equal(plate.touches(15 + -steps / 50), true);
    assert.equal(plate.touches(15 + (1 - steps) / 50), false);
  }
});

test('a hand closes the contact without a plate, and beside one', () => {
  const rig = new Rig(null);
  rig.gantry.probe.press(true);
  assert.equal(rig.open, false);
  rig.gantry.probe.setPlate(new ProbePlate('X', 40, 'below'));
  rig.gantry.probe.press(false);
  assert.equal(rig.open, false);
  rig.gantry.probe.setPlate(null);
  assert.equal(rig.open, true);
  assert.deepEqual(rig.summary, {
    closed: false,
    plate: null,
    contacts: [{ t_ns: 0, axis: null, position_steps: [0, 0, 0] }],
    releases: [{ t_ns: 0, axis: null, position_steps: [0, 0, 0] }],
  });
});

test('a fresh chip finds the contact as it is', () => {
  const rig = new Rig(new ProbePlate('Z', 20, 'below'));
  assert.equal(rig.open, false);
  const { chip } = new PwmBench();
  rig.gantry.attach(chip);
  assert.equal(chip.gpio[TOOL_INPUTS.probe].rawInputValue, false);
  assert.equal(chip.gpio[TOOL_INPUTS.hold].rawInputValue, true);
});

test('buttons pull their pins to ground', () => {
  const { bench, gantry } = new Rig(null);
  gantry.pressButton('hold', true);
  gantry.pressButton('start', true);
  gantry.pressButton('start', false);
  assert.deepEqual([TOOL_INPUTS.hold, TOOL_INPUTS.start].map((pin) => bench.chip.gpio[pin].rawInputValue), [false, true]);
});

test('the alarm of drives is a contact to ground, where there is one', () => {
  const { bench, gantry } = new Rig(null);
  gantry.changeAlarm(true);
  assert.equal(bench.chip.gpio[TOOL_INPUTS.alarm].rawInputValue, false);
  gantry.changeAlarm(false);
  assert.equal(bench.chip.gpio[TOOL_INPUTS.alarm].rawInputValue, true);
  gantry.board = BOARDS['skr-pico'];
  assert.throws(() => gantry.changeAlarm(true), /no input for the alarm of drives/);
});

test('a wave shows every edge of the PWM, and the inputs', () => {
  const { bench, gantry } = new Rig(null);
  const wave = new Waveform(namedOutputs(BOARDS.pico, AXES.slice(0, 3)), namedInputs(BOARDS.pico));
  bench.chip.pwm.showEdges(TOOL_OUTPUTS.pwm);
  wave.attach(bench.chip, () => bench.clock.nanos);
  gantry.watchInputs((pin, high) => wave.input(bench.clock.nanos, pin, high));
  bench.start({ cc: 3, top: 9 });
  bench.runTo(12);
  gantry.pressButton('hold', true);
  const text = wave.toString();
  const code = (name) => new RegExp(`\\$var wire 1 (.) ${name} \\$end`).exec(text)[1];
  const rows = text.split('\n');
  const after = rows.slice(rows.indexOf('#24'), -1);
  assert.deepEqual(after, ['#24', `0${code('TOOL_PWM')}`, '#80', `1${code('TOOL_PWM')}`, '#96', `0${code('HOLD_n')}`]);
});

test('with crossed belts a plate of an axis is touched on the step of either motor', () => {
  const rig = new Rig(new ProbePlate('Y', 39.98, 'below'), { belts: true });
  // Both motors turn down: X goes down, and Y stays.
  rig.step(1000, 'X', 'Y');
  assert.equal(rig.open, true);
  // The motor of X alone.
  rig.step(2000, 'X');
  assert.equal(rig.open, true);
  rig.step(3000, 'X');
  assert.equal(rig.open, false);
  // The motor of Y down takes Y up.
  rig.step(4000, 'Y');
  assert.equal(rig.open, true);
  assert.deepEqual(rig.summary.contacts.map(({ axis, position_steps }) => [axis, position_steps]), [['X', [-3, -1, 0]]]);
  assert.deepEqual(rig.summary.releases.map(({ axis, position_steps }) => [axis, position_steps]), [['Y', [-3, -2, 0]]]);
  assert.deepEqual([rig.gantry.countedSteps(), rig.gantry.carriages.X.travelSteps], [[-2, -0, 0], -2.5]);
  rig.gantry.home(['X', 'Z']);
  assert.deepEqual(rig.gantry.countedSteps(), [0, 0, 0]);
});
