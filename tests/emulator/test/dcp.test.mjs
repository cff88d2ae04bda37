import assert from 'node:assert/strict';
import test from 'node:test';
import { fileURLToPath } from 'node:url';
import { Dcp } from '../src/rp2350/dcp.mjs';
import { Assembly } from '../support/assembly.mjs';
import { FUNCTIONS, KINDS, edges, expected, integerEdges, random, registersOf, valueIn } from '../support/double-vectors.mjs';

/** How many random arguments of each kind a function is given. */
const COUNT = Number(process.env.DCP_RANDOM ?? 20_000);
/** The functions that are tried, all of them unless some are named. */
const NAMES = process.env.DCP_FUNCTIONS?.split(',') ?? Object.keys(FUNCTIONS);
const SEED = 2350;
const SOURCE = fileURLToPath(new URL('../../../boards/rp2350-floats/src/lib.rs', import.meta.url));

/** Functions of the assembly, by the names in FUNCTIONS. */
class Bench {
  dcp = new Dcp();
  assembly = new Assembly(SOURCE, this.dcp);

  call(name, a, b) {
    const { takes, gives } = FUNCTIONS[name];
    const { r } = this.assembly;
    const words = registersOf(takes[0], a);
    r[0] = words[0];
    if (words.length > 1) r[1] = words[1];
    if (takes.length > 1) [r[2], r[3]] = registersOf(takes[1], b);
    this.assembly.call(`__aeabi_${name}`);
    return valueIn(gives, r[0], r[1]);
  }

  check(name, a, b) {
    const want = expected(name, a, b);
    const result = this.call(name, a, b);
    if (want === undefined || Object.is(result, want)) return;
    assert.fail(`${name}(${a}, ${b}) is ${result}, not ${want}`);
  }
}

/** Random arguments of a function. */
function drawn(source, name, kind) {
  const { takes } = FUNCTIONS[name];
  if (takes === 'dd') return source.pair(kind);
  if (takes === 'f') return [source.single()];
  if (takes !== 'd') return [source.integer(takes)];
  return [name === 'd2f' ? source.small(kind) : source.double(kind)];
}

test('a source has every function that the compiler calls for doubles', () => {
  const { assembly } = new Bench();
  assert.deepEqual(Object.keys(FUNCTIONS).filter((name) => !assembly.has(`__aeabi_${name}`)), []);
});

for (const name of NAMES) {
  const { takes } = FUNCTIONS[name];

  test(`${name} returns what the host does at all edges`, () => {
    const bench = new Bench();
    const all = takes.startsWith('d') || takes === 'f' ? edges() : integerEdges(takes);
    for (const a of takes === 'f' ? all.map(Math.fround) : all) {
      if (takes === 'dd') for (const b of all) bench.check(name, a, b);
      else bench.check(name, a);
    }
    assert.equal(bench.dcp.engaged, false);
  });

  test(`${name} returns what the host does for random arguments`, () => {
    const bench = new Bench();
    const kinds = takes.startsWith('d') ? KINDS : ['any'];
    for (const kind of kinds) {
      const source = random(SEED);
      for (let count = 0; count < COUNT; count++) bench.check(name, ...drawn(source, name, kind));
    }
  });

  test(`${name} is not disturbed by an interrupt handler that uses doubles, and does not disturb one`, () => {
    const source = random(SEED);
    const bench = new Bench();
    const { assembly } = bench;
    const others = ['dadd', 'drsub', 'dmul', 'ddiv', 'dcmplt', 'l2d', 'd2f', 'd2iz'];
    for (const other of others) {
      const args = drawn(source, name, 'near');
      const want = expected(name, ...args);
      for (let at = 0, isDone = false; !isDone; at++) {
        let count = 0;
        isDone = true;
        assembly.r.set([4, 5, 6, 7, 8, 9, 10, 11], 4);
        assembly.before = () => {
          if (count++ !== at) return;
          isDone = false;
          assembly.interrupt(() => nest(bench, other, source));
        };
        assert.equal(bench.call(name, ...args), want, `${name}, interrupted by ${other} at instruction ${at}`);
        assembly.before = undefined;
        assert.deepEqual([...assembly.r.slice(4, 12)], [4, 5, 6, 7, 8, 9, 10, 11]);
        assert.equal(bench.dcp.engaged, false);
      }
    }
  });
}

/** A handler that calls a function, and is itself interrupted by one that does, at a random instruction. */
function nest(bench, name, source) {
  const { assembly } = bench;
  const wasEngaged = bench.dcp.engaged;
  const at = Math.floor(Math.abs(source.integer('i')) % 30);
  let count = 0;
  assembly.before = () => {
    if (count++ === at) assembly.interrupt(() => bench.check('ddiv', ...source.pair('near')));
  };
  bench.check(name, ...drawn(source, name, 'near'));
  assembly.before = undefined;
  assert.equal(bench.dcp.engaged, wasEngaged);
}

test('each function takes as many instructions as its docs say, and no more on the way that is most common', () => {
  const wanted = {
    dadd: 9, dsub: 9, drsub: 9, dmul: 18, ddiv: 38,
    dcmpeq: 8, dcmplt: 9, dcmple: 8, dcmpgt: 9, dcmpge: 8, dcmpun: 8,
    i2d: 8, ui2d: 8, l2d: 22, ul2d: 22, f2d: 6, d2f: 6, d2iz: 8, d2uiz: 8, d2lz: 21, d2ulz: 21,
  };
  const bench = new Bench();
  const arguments_ = { d: 2.5, f: 2.5, i: 5, u: 5, l: 5n, w: 5n };
  const counts = Object.entries(FUNCTIONS).map(([name, { takes }]) => {
    bench.assembly.count = 0;
    bench.call(name, ...[...takes].map((kind) => arguments_[kind]));
    return [name, bench.assembly.count];
  });
  assert.deepEqual(Object.fromEntries(counts), wanted);
});

test('an instruction that the coprocessor does not know, or that does not belong, is an error', () => {
  const dcp = new Dcp();
  assert.throws(() => dcp.cdp(2, 0, 0, 1, 0), { message: 'the emulated coprocessor does not know cdp #2, c0, c0, c1, #0' });
  assert.throws(() => dcp.mcrr(9, 2, 0, 0), /mcrr #9, c2/);
  assert.throws(() => dcp.mrrc(4, 1, true), /mrrc2 #4, c1/);
  assert.throws(() => dcp.mrc(0, 0, 0, 0, false), /mrc #0, c0, c0, #0/);
  dcp.mcrr(1, 0, 0, 0);
  assert.throws(() => dcp.mrrc(1, 0, false), /have not made/);
});
