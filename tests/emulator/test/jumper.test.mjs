import assert from 'node:assert/strict';
import test from 'node:test';
import { Gantry } from '../src/gantry.mjs';
import { jumperOption } from '../src/jumper.mjs';
import { HELP, parseOptions } from '../src/options.mjs';
import { CONDITION, irqSet, jmp, waitGpio } from '../support/pio-assembly.mjs';
import { PIO1, PioBench, REG } from '../support/pio-bench.mjs';

const OPTIONS = { startMm: [35, 40, 15], bounceMicros: 0, seed: 1, switches: {} };
const [OUT, X_LIMIT, ESTOP, FREE] = [28, 9, 12, 23];
const SIO_FUNCTION = 5;
const [GPIO_CTRL, PADS, INTERRUPT_ENABLE] = [0x40014004, 0x4001c004, 0x40014100];
const [GPIO_IN, OUT_SET, OUT_CLEAR, OUTPUTS_SET, OUTPUTS_CLEAR] = [0xd0000004, 0xd0000014, 0xd0000018, 0xd0000024, 0xd0000028];
const [INPUT_AND_PULL_UP, IRQ_IO] = [0x48, 13];

/** A gantry with this wire on a chip whose SIO drives OUT high. */
function wired(to, options = {}) {
  const bench = new PioBench(PIO1);
  const gantry = new Gantry(bench.clock, { ...OPTIONS, jumpers: [{ from: OUT, to }], ...options });
  gantry.attach(bench.chip);
  for (const pin of [OUT, to]) bench.writeAt(PADS + 4 * pin, INPUT_AND_PULL_UP);
  for (const pin of [OUT, to]) bench.writeAt(GPIO_CTRL + 8 * pin, SIO_FUNCTION);
  bench.writeAt(OUT_SET, 1 << OUT);
  bench.writeAt(OUTPUTS_SET, 1 << OUT);
  const reads = () => {
    bench.run(2);
    return (bench.readAt(GPIO_IN) >>> to) & 1;
  };
  return { bench, gantry, reads, low: () => bench.writeAt(OUT_CLEAR, 1 << OUT), high: () => bench.writeAt(OUT_SET, 1 << OUT) };
}

test('an input reads low while the other end of its jumper is driven low, and only then', () => {
  for (const to of [X_LIMIT, ESTOP, FREE]) {
    const { bench, reads, low, high } = wired(to);
    assert.equal(reads(), 1);
    low();
    assert.equal(reads(), 0);
    bench.writeAt(OUTPUTS_CLEAR, 1 << OUT);
    assert.equal(reads(), 1);
    bench.writeAt(OUTPUTS_SET, 1 << OUT);
    assert.equal(reads(), 0);
    high();
    assert.equal(reads(), 1);
  }
});

test('a switch at the jumper still closes, and either keeps the input low', () => {
  const { gantry, reads, low, high } = wired(X_LIMIT);
  const levels = [];
  gantry.watchInputs((pin, level) => pin === X_LIMIT && levels.push(level));
  const limit = gantry.limitSwitch('X');
  limit.setMode('stuck-closed');
  high();
  assert.equal(reads(), 0);
  low();
  limit.setMode('normal');
  assert.equal(reads(), 0);
  limit.setMode('stuck-closed');
  high();
  assert.equal(reads(), 0);
  limit.setMode('normal');
  assert.equal(reads(), 1);
  assert.deepEqual(levels, [true, false, true]);
});

test('PIO and interrupts see it as they see a switch', () => {
  const { bench, low } = wired(X_LIMIT);
  bench.load([waitGpio(0, X_LIMIT), irqSet(0), jmp(CONDITION.always, 2)]);
  bench.configure(0, {});
  bench.run(5);
  bench.write(REG.ctrl, 1);
  // Low level of GP9.
  bench.writeAt(INTERRUPT_ENABLE + 4, 1 << (4 * (X_LIMIT - 8)));
  bench.run(5);
  assert.equal(bench.pending(IRQ_IO), false);
  const fallen = bench.core.cycles;
  low();
  assert.equal(bench.pending(IRQ_IO), true);
  bench.runTo(fallen + 2);
  assert.equal(bench.read(REG.irq), 0);
  bench.runTo(fallen + 3);
  assert.equal(bench.read(REG.irq), 1);
});

test('while the machine steps, it is the cause of a stop', () => {
  const stopOf = (to, options) => {
    const { bench, gantry, low } = wired(to, options);
    const causes = [];
    gantry.stops.note = (input) => causes.push([input, bench.clock.cycles]);
    bench.run(1000);
    const at = bench.core.cycles;
    low();
    return causes.map(([input, cycle]) => [input, cycle - at]);
  };
  assert.deepEqual(stopOf(X_LIMIT), [['X_LIMIT', 0]]);
  assert.deepEqual(stopOf(ESTOP), [['ESTOP', 0]]);
  assert.deepEqual(stopOf(ESTOP, { estop: 'nc' }), []);
  assert.deepEqual(stopOf(FREE), []);
});

test('a chip that is reset lets go', () => {
  const { gantry, low } = wired(X_LIMIT);
  low();
  const next = new PioBench();
  gantry.attach(next.chip);
  assert.equal(next.chip.gpio[X_LIMIT].rawInputValue, true);
});

test('its option names two pads', () => {
  assert.deepEqual(jumperOption('28:9'), { from: 28, to: 9 });
  for (const text of ['28', '28:30', '9:9', 'a:9', '1:2:3', ':9', '-1:9']) assert.throws(() => jumperOption(text), /give two different pads by their GP numbers, from 0 to 29/);
  assert.deepEqual(parseOptions(['--elf', 'a', '--live', '--jumper', '28:9', '--jumper', '28:12']).jumpers, [{ from: 28, to: 9 }, { from: 28, to: 12 }]);
  assert.ok(HELP.includes('--jumper'));
});
