import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test from 'node:test';
import { OffTimes } from '../src/off-times.mjs';
import { OnTime } from '../src/on-time.mjs';
import { HEADER, OutputTrace } from '../src/output-trace.mjs';
import { ToolOutputs } from '../src/tool.mjs';
import { ToolStops } from '../src/tool-stops.mjs';
import { BOARDS } from '../src/pins.mjs';
import { CC, CSR, CTR, FUNCTION, PIN, PwmBench } from '../support/pwm-bench.mjs';

const [ENABLE, MIST] = [14, 17];
const [OUT_SET, OUT_CLEAR, OUTPUTS_SET] = [0xd0000014, 0xd0000018, 0xd0000024];
const PADS = 0x4001c004;
const OUTPUT_DISABLE = 0x80;
const OUTPUT = { inverted: 1 << 8, low: 2 << 8, high: 3 << 8, disabled: 2 << 12 };

function tool() {
  const bench = new PwmBench();
  const outputs = new ToolOutputs(bench.clock, BOARDS.pico.tool);
  const changes = [];
  outputs.watchers.add((...change) => changes.push(change));
  outputs.attach(bench.chip);
  return { bench, outputs, changes };
}

test('a pad that the chip does not drive is off', () => {
  const { bench, outputs, changes } = tool();
  bench.writeAt(OUT_SET, 1 << ENABLE);
  bench.control(ENABLE, FUNCTION.sio);
  assert.deepEqual(outputs.values, { pwm: 0, enable: 0, direction: 0, flood: 0, mist: 0 });
  assert.deepEqual(changes, []);
});

test('outputs are followed at their pads, and their changes reported with their cycles', () => {
  const { bench, changes, outputs } = tool();
  bench.control(ENABLE, FUNCTION.sio);
  bench.control(MIST, FUNCTION.sio);
  bench.writeAt(OUTPUTS_SET, (1 << ENABLE) | (1 << MIST));
  bench.runTo(10);
  bench.writeAt(OUT_SET, (1 << ENABLE) | (1 << MIST));
  bench.runTo(20);
  bench.writeAt(OUT_CLEAR, 1 << MIST);
  bench.runTo(30);
  bench.writeAt(PADS + 4 * ENABLE, OUTPUT_DISABLE);
  assert.deepEqual(changes, [[10, 'enable', 1], [10, 'mist', 1], [20, 'mist', 0], [30, 'enable', 0]]);
  assert.equal(outputs.summary().changes, 4);
});

test('the duty is that in force: from the wrap on', () => {
  const { bench, changes } = tool();
  bench.start({ cc: 0, top: 999 });
  bench.runTo(100);
  bench.write(CC, 333 << 16);
  bench.runTo(1500);
  bench.write(CC, 0);
  bench.write(CTR, 999);
  bench.runTo(5000);
  assert.deepEqual(changes, [[1000, 'pwm', 0.333], [1501, 'pwm', 0]]);
});

test('a duty is reported to a millionth', () => {
  const { bench, outputs } = tool();
  bench.start({ cc: 1, top: 65534 });
  assert.equal(String(outputs.values.pwm), '0.000015');
});

test('a halted slice leaves the duty at its level', () => {
  const { bench, changes } = tool();
  bench.start({ cc: 5, top: 9 });
  bench.runTo(2);
  bench.write(CSR, 0);
  bench.runTo(3);
  bench.write(CSR, 1);
  bench.runTo(7);
  bench.write(CSR, 0);
  assert.deepEqual(changes, [[0, 'pwm', 0.5], [2, 'pwm', 1], [3, 'pwm', 0.5], [7, 'pwm', 0]]);
});

test('CTRL alone overrides an output, on its cycle, whatever its level is then', () => {
  const { bench, changes } = tool();
  bench.start({ cc: 2, top: 9 });
  bench.runTo(5);
  const controls = [OUTPUT.low, 0, OUTPUT.high, OUTPUT.inverted, OUTPUT.disabled | OUTPUT.high];
  for (const override of controls) {
    bench.runTo(bench.core.cycles + 10);
    assert.equal(bench.pin.outputValue, [OUTPUT.high, OUTPUT.inverted].includes(bench.pin.ctrl & OUTPUT.high));
    bench.control(PIN, FUNCTION.pwm | override);
  }
  bench.runTo(100);
  bench.control(PIN, FUNCTION.pwm);
  bench.runTo(105);
  bench.control(PIN, FUNCTION.sio);
  const expected = [[0, 0.2], [15, 0], [25, 0.2], [35, 1], [45, 0.8], [55, 0], [100, 0.2], [105, 0]];
  assert.deepEqual(changes, expected.map(([cycle, duty]) => [cycle, 'pwm', duty]));
});

test('a fresh chip drives nothing', () => {
  const { bench, outputs, changes } = tool();
  bench.start({ cc: 2, top: 9 });
  outputs.attach(new PwmBench().chip);
  assert.equal(outputs.values.pwm, 0);
  assert.equal(changes.length, 2);
});

test('the time with the power on is counted, and that of it without a step for 50 ms', () => {
  const onTime = new OnTime();
  const second = 125e6;
  onTime.set(true, second);
  onTime.set(false, 2 * second);
  onTime.step(3 * second);
  onTime.set(true, 3 * second);
  onTime.step(3.01 * second);
  assert.deepEqual(onTime.summary(3.02 * second), { on_s: 1.02, on_at_standstill_s: 1 });
  assert.deepEqual(onTime.summary(4.01 * second), { on_s: 2.01, on_at_standstill_s: 2 });
});

test('a stop is reported with the time until all outputs were off, and with that until one was on again', () => {
  const clock = { cycles: 0 };
  const offTimes = new OffTimes(clock);
  const stops = new ToolStops(clock, offTimes);
  const at = (cycle, action) => {
    clock.cycles = cycle;
    action();
  };
  at(10, () => stops.note('ESTOP'));
  at(20, () => offTimes.set(true, 20));
  at(30, () => stops.note('X_LIMIT'));
  at(35, () => stops.note('X_LIMIT'));
  at(50, () => offTimes.set(false, 50));
  at(80, () => offTimes.set(true, 80));
  at(90, () => stops.note('RESET'));
  assert.deepEqual(stops.summary(), [
    { input: 'X_LIMIT', t_ns: 240, outputs_off_ns: 160, outputs_on_again_ns: 400 },
    { input: 'RESET', t_ns: 720, outputs_off_ns: null, outputs_on_again_ns: null },
  ]);
});

test('the trace of the outputs has a header and a row per change', () => {
  const folder = mkdtempSync(join(tmpdir(), 'isostep-'));
  const trace = new OutputTrace(join(folder, 'outputs.csv'));
  trace.change(8, 'pwm', 0.333);
  trace.change(16, 'flood', 1);
  trace.close();
  assert.equal(readFileSync(join(folder, 'outputs.csv')).toString(), `${HEADER}\n8,pwm,0.333\n16,flood,1\n`);
  rmSync(folder, { recursive: true });
});
