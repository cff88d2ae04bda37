import assert from 'node:assert/strict';
import test from 'node:test';
import { Fault } from '../src/fault.mjs';
import { seededRandom } from '../src/limit-switch.mjs';
import { DOUBLES } from '../src/rom/doubles.mjs';
import { FLOATS } from '../src/rom/floats.mjs';
import { RAM, RomBench } from '../support/rom-bench.mjs';

const SMALLEST = { d: 2 ** -1022, f: 2 ** -126 };
const DENORMAL = { d: 2 ** -1030, f: 2 ** -130 };
const NUMBERS = [0, 1, 1.5, 2.5, 3, 7, Math.PI, 1e10, 1e-10, 1e30, 1e-30, Infinity].flatMap((each) => [each, -each]);
const RANDOM_PAIRS = 2000;

const words = (value) => [...new Int32Array(Float64Array.of(value).buffer)];
const bits = (value) => new Int32Array(Float32Array.of(value).buffer)[0];
const doubleOf = ([low, high]) => new Float64Array(Int32Array.of(low, high).buffer)[0];
const singleOf = ([word]) => new Float32Array(Int32Array.of(word).buffer)[0];
const int64Of = ([low, high]) => (BigInt(high) << 32n) | BigInt(low >>> 0);
const pair = (value) => [Number(BigInt.asIntN(32, value)), Number(BigInt.asIntN(32, value >> 32n))];

/** The function of a table with this name, called with raw registers: it returns r0 and r1. */
function rom(bench, name) {
  const [table, functions] = FLOATS.some((each) => each[1] === name) ? ['SF', FLOATS] : ['SD', DOUBLES];
  const address = bench.soft(table, functions.find((each) => each[1] === name)[0]);
  return (...registers) => {
    bench.call(address, ...registers);
    return [bench.bus.registers[0], bench.bus.registers[1]];
  };
}

/** A function on doubles or floats ('d' or 'f' before its name). */
function arithmetic(bench, kind, name) {
  const call = rom(bench, kind + name);
  if (kind === 'd') return (...args) => doubleOf(call(...args.flatMap(words)));
  return (...args) => singleOf(call(...args.map(bits)));
}

const rounded = { d: (value) => value, f: Math.fround };

/** The result according to IEEE 754, but with denormals flushed to zero. */
const flushed = (kind, value) => (Math.abs(value) < SMALLEST[kind] ? value * 0 : value);

const OPERATIONS = { add: (a, b) => a + b, sub: (a, b) => a - b, mul: (a, b) => a * b, div: (a, b) => a / b };

test('the tables are found as the datasheet says, and an unknown code is not', () => {
  const bench = new RomBench();
  assert.equal(bench.bus.read32(0x10), 0x0301754d);
  assert.equal(bench.functionAt('??'), 0);
  for (const code of ['P3', 'R3', 'L3', 'T3', 'MS', 'S4', 'MC', 'C4', 'UB', 'IF', 'EX', 'RE', 'RP', 'FC', 'CX']) {
    assert.equal(bench.functionAt(code) & 1, 1, code);
  }
  for (const code of ['CR', 'GR', 'FS', 'FE', 'SF', 'SD']) assert.notEqual(bench.dataAt(code), 0, code);
  assert.match(bench.text(bench.dataAt('CR')), /^A stand-in/);
});

test('the chip is an RP2040-B2, and says so', () => {
  const bench = new RomBench();
  assert.equal(bench.bus.read32(0x40000000), 0x20002927);
  assert.equal(bench.bus.read8(0x13), 3);
});

for (const kind of ['d', 'f']) {
  test(`${kind}add, sub, mul and div are IEEE 754's, rounded to nearest, without denormals`, () => {
    const bench = new RomBench();
    const random = seededRandom(3);
    const number = () => rounded[kind]((random() - 0.5) * 2 ** Math.floor(random() * 60 - 30));
    const numbers = [...NUMBERS, SMALLEST[kind], -SMALLEST[kind]].map(rounded[kind]);
    const pairs = [...numbers.flatMap((a) => numbers.map((b) => [a, b])), ...Array.from({ length: RANDOM_PAIRS }, () => [number(), number()])];
    for (const [name, operation] of Object.entries(OPERATIONS)) {
      const call = arithmetic(bench, kind, name);
      for (const [a, b] of pairs) {
        const wanted = flushed(kind, rounded[kind](operation(a, b)));
        if (Number.isNaN(wanted)) continue;
        assert.ok(Object.is(call(a, b), wanted), `${a} ${name} ${b}: ${call(a, b)}, not ${wanted}`);
      }
    }
  });

  test(`${kind}: what has no number is a fault, and denormals are zeros of their sign`, () => {
    const bench = new RomBench();
    const [add, sub, mul, div, sqrt] = ['add', 'sub', 'mul', 'div', 'sqrt'].map((name) => arithmetic(bench, kind, name));
    const tiny = DENORMAL[kind];
    const meaningless = [() => add(Infinity, -Infinity), () => sub(-Infinity, -Infinity), () => mul(0, Infinity), () => mul(-0, Infinity),
      () => div(0, 0), () => div(Infinity, -Infinity), () => add(NaN, 1), () => sqrt(NaN)];
    for (const operation of meaningless) assert.throws(operation, Fault);
    assert.deepEqual([mul(tiny, 2 ** 100), mul(-tiny, 2 ** 100)], [0, -0]);
    assert.deepEqual([div(1, tiny), div(1, -tiny)], [Infinity, -Infinity]);
    assert.deepEqual([div(SMALLEST[kind], 2), div(-SMALLEST[kind], 2)], [0, -0]);
    assert.deepEqual([sqrt(2), sqrt(-0), sqrt(-1), sqrt(Infinity)], [rounded[kind](Math.SQRT2), -0, -Infinity, Infinity]);
    const raw = rom(bench, `${kind}cmp`);
    const compared = (a, b) => (kind === 'd' ? raw(...words(a), ...words(b)) : raw(bits(a), bits(b)))[0];
    assert.deepEqual([compared(1, 2), compared(2, 1), compared(0, -0), compared(tiny, -tiny), compared(-2, -1)], [-1, 1, 0, 0, -1]);
  });
}

test('a division of doubles uses the divider, and whoever was dividing must have saved its state', () => {
  const bench = new RomBench();
  const { sio } = bench.chip;
  sio.writeUint32(0x60, 1000);
  sio.writeUint32(0x64, 7);
  assert.equal(arithmetic(bench, 'd', 'div')(1, 4), 0.25);
  assert.notEqual(sio.readUint32(0x74), 1000 % 7);
});

test('whole and fixed-point numbers are rounded towards minus infinity, and clamped', () => {
  const bench = new RomBench();
  const from = (name, value, places) => rom(bench, name)(...(name.startsWith('d') ? words(value) : [bits(value)]), places);
  for (const kind of ['double', 'float']) {
    const to = (name, value, places) => from(`${kind}_to_${name}`, value, places)[0];
    const to64 = (name, value, places) => int64Of(from(`${kind}_to_${name}`, value, places));
    assert.deepEqual([1.5, -1.5, 2 ** 31, -1e20, -0, -1e-20].map((each) => to('int', each)), [1, -2, 0x7fffffff, -0x80000000, 0, -1]);
    assert.deepEqual([2 ** 32 - 2 ** 9, 2 ** 32, -1, Infinity].map((each) => to('uint', each) >>> 0), [2 ** 32 - 2 ** 9, 0xffffffff, 0, 0xffffffff]);
    assert.deepEqual([to('fix', 0.5, 16), to('fix', -0.3, 0), to('ufix', 0.75, 2)], [0x8000, -1, 3]);
    assert.deepEqual([-1.5, 2 ** 40, 2 ** 63, -(2 ** 63), -Infinity].map((each) => to64('int64', each)), [-2n, 2n ** 40n, 2n ** 63n - 1n, -(2n ** 63n), -(2n ** 63n)]);
    assert.deepEqual([2 ** 63, 2 ** 64, -5].map((each) => BigInt.asUintN(64, to64('uint64', each))), [2n ** 63n, 2n ** 64n - 1n, 0n]);
    assert.deepEqual([to64('fix64', -0.5, 40), to64('ufix64', 0.5, 40)], [-(2n ** 39n), 2n ** 39n]);
  }
});

test('integers become the nearest float, rounded once', () => {
  const bench = new RomBench();
  const random = seededRandom(5);
  const word = () => BigInt(Math.floor(random() * 2 ** 32));
  const ends = [0n, 1n, -1n, 2n ** 53n + 1n, 2n ** 24n + 1n, 2n ** 60n + 2n ** 36n + 1n, -(2n ** 60n + 2n ** 36n + 1n), 2n ** 63n - 1n, -(2n ** 63n)];
  const numbers = [...ends, ...Array.from({ length: 300 }, () => BigInt.asIntN(64, (word() << 32n) | word()))];
  /** The float nearest to an integer, computed from its 26 highest bits and one bit for the rest. */
  const nearest = (value) => {
    const size = value < 0n ? -value : value;
    const shift = BigInt(Math.max(0, size.toString(2).length - 26));
    const top = (size >> shift) * 2n + (size % (1n << shift) === 0n ? 0n : 1n);
    return Math.fround(Number(top) * 2 ** (Number(shift) - 1)) * (value < 0n ? -1 : 1);
  };
  for (const value of numbers) {
    const unsigned = BigInt.asUintN(64, value);
    assert.equal(doubleOf(rom(bench, 'int64_to_double')(...pair(value))), Number(value));
    assert.equal(doubleOf(rom(bench, 'uint64_to_double')(...pair(value))), Number(unsigned));
    assert.equal(singleOf(rom(bench, 'int64_to_float')(...pair(value))) + 0, nearest(value) + 0);
    assert.equal(singleOf(rom(bench, 'uint64_to_float')(...pair(value))), nearest(unsigned));
    assert.equal(doubleOf(rom(bench, 'fix64_to_double')(...pair(value), 20)), Number(value) / 2 ** 20);
    assert.equal(singleOf(rom(bench, 'int_to_float')(Number(BigInt.asIntN(32, value)))), Math.fround(Number(BigInt.asIntN(32, value))));
    assert.equal(doubleOf(rom(bench, 'uint_to_double')(Number(BigInt.asIntN(32, value)))), Number(BigInt.asUintN(32, value)));
  }
  assert.equal(doubleOf(rom(bench, 'float_to_double')(bits(0.1))), Math.fround(0.1));
  assert.equal(singleOf(rom(bench, 'double_to_float')(...words(0.1))), Math.fround(0.1));
  assert.equal(singleOf(rom(bench, 'double_to_float')(...words(1e300))), Infinity);
});

test('angles beyond the range of the ROM are a fault', () => {
  const bench = new RomBench();
  assert.equal(arithmetic(bench, 'd', 'sin')(1), Math.sin(1));
  assert.throws(() => arithmetic(bench, 'f', 'cos')(128), /fcos of 128: it takes angles between -128 and 128/);
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

test('an interrupt comes in the midst of a division, which goes on after it', () => {
  const bench = new RomBench();
  const entries = [];
  const { exceptionEntry } = bench.core;
  bench.core.exceptionEntry = (number) => {
    entries.push(bench.core.cycles);
    exceptionEntry(number);
  };
  const divide = arithmetic(bench, 'd', 'div');
  for (let cycle = 1; cycle < 180; cycle += 7) {
    entries.length = 0;
    const due = bench.core.cycles + cycle;
    // movs r0 to r3, #0; bx lr
    bench.interruptIn(cycle, [0x2000, 0x2100, 0x2200, 0x2300, 0x4770]);
    assert.equal(divide(1, 3), 1 / 3);
    assert.ok(entries[0] - due <= 5, `${entries[0] - due} cycles late`);
    assert.ok(bench.took > 183);
  }
});

test('bits are counted and turned round', () => {
  const bench = new RomBench();
  const call = (code, value) => bench.call(bench.functionAt(code), value) >>> 0;
  assert.deepEqual(['P3', 'R3', 'L3', 'T3'].map((code) => call(code, 0x00f00001)), [5, 0x80000f00, 8, 0]);
  assert.deepEqual(['P3', 'R3', 'L3', 'T3'].map((code) => call(code, 0)), [0, 0, 32, 32]);
  assert.deepEqual(['P3', 'R3', 'L3', 'T3'].map((code) => call(code, -1)), [32, 0xffffffff, 0, 0]);
});

test('memory is copied and filled, in the time of words or of bytes', () => {
  const bench = new RomBench();
  const [from, to] = [RAM + 0x1000, RAM + 0x2000];
  bench.bus.ram8.set(Array.from({ length: 256 }, (_, index) => index), 0x1000);
  assert.equal(bench.call(bench.functionAt('C4'), to, from, 256), to);
  assert.equal(bench.took, 25 + 13 * 16);
  assert.deepEqual([...bench.bus.ram8.subarray(0x2000, 0x2101)], [...Array.from({ length: 256 }, (_, index) => index), 0]);
  assert.equal(bench.call(bench.functionAt('MC'), to + 1, from, 100), to + 1);
  assert.equal(bench.took, 9 + 7 * 100);
  assert.equal(bench.call(bench.functionAt('MS'), to, 0x1ab, 3), to);
  assert.deepEqual([...bench.bus.ram8.subarray(0x2000, 0x2005)], [0xab, 0xab, 0xab, 2, 3]);
});

test('the ROM reads as memory, is not written, and has no code but its functions', () => {
  const bench = new RomBench();
  assert.equal(bench.bus.read8(0x13), 3);
  assert.throws(() => bench.bus.write32(0, 1), /a write to 0x0, which is read-only/);
  assert.throws(() => bench.call(0x3000), /no function of the emulated bootrom/);
});

test('the function that reboots into BOOTSEL tells the board, and never returns', () => {
  const bench = new RomBench();
  const address = bench.functionAt('UB');
  bench.clock.createAlarm(() => (bench.core.waiting = true)).scheduleAt(bench.core.cycles + 1000);
  bench.call(address, 1 << 25, 1);
  assert.deepEqual(bench.bootsels, [[1 << 25, 1]]);
  assert.notEqual(bench.core.PC & ~3, 0x20000100);
});
