import assert from 'node:assert/strict';
import test from 'node:test';
import { DOUBLES } from '../src/rom/doubles.mjs';
import { FLOATS } from '../src/rom/floats.mjs';
import { RomBench } from '../support/rom-bench.mjs';

const words = (value) => [...new Int32Array(new Float64Array([value]).buffer)];
const double = (low, high) => new Float64Array(new Int32Array([low, high]).buffer)[0];
const NUMBERS = [0, -0, 1, -1, 1.5, -2.5, Math.PI, 1e10, 1e-10, 1e300, -1e300, 1e-300, 2 ** -1022, Infinity, -Infinity, 4.9e-324, 3, 7];

/** A function of the double table, called with doubles. */
function doubleFunction(bench, offset) {
  const address = bench.soft('SD', offset);
  return (...args) => {
    bench.call(address, ...args.flatMap(words));
    return double(bench.bus.registers[0], bench.bus.registers[1]);
  };
}

const flushed = (value) => (Math.abs(value) < 2 ** -1022 ? value * 0 : value);

test('the tables are found as the datasheet says, and an unknown code is not', () => {
  const bench = new RomBench();
  assert.equal(bench.bus.read32(0x10), 0x0301754d);
  assert.equal(bench.functionAt('P3') & 1, 1);
  assert.equal(bench.functionAt('??'), 0);
  assert.notEqual(bench.dataAt('SD'), 0);
});

test('doubles are added, subtracted, multiplied and divided as JavaScript does, but without denormals', () => {
  const bench = new RomBench();
  const operations = [[0x00, (a, b) => a + b], [0x04, (a, b) => a - b], [0x08, (a, b) => a * b], [0x0c, (a, b) => a / b]];
  for (const [offset, expected] of operations) {
    const operation = doubleFunction(bench, offset);
    for (const a of NUMBERS.map(flushed)) {
      for (const b of NUMBERS.map(flushed)) {
        const wanted = flushed(expected(a, b));
        if (!Number.isNaN(wanted)) assert.ok(Object.is(operation(a, b), wanted), `${offset}: ${a}, ${b}`);
      }
    }
  }
});

test('every float function takes the cycles of the datasheet', () => {
  const bench = new RomBench();
  for (const [table, functions] of [['SF', FLOATS], ['SD', DOUBLES]]) {
    for (const [offset, name, cycles] of functions) {
      bench.call(bench.soft(table, offset), 0, 0x40000000, 0, 0x3ff80000);
      assert.equal(bench.took, cycles, name);
    }
  }
});
