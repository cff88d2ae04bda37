import { seededRandom } from '../src/limit-switch.mjs';

/**
 * What the functions on doubles are given in tests, and what they have to return: IEEE 754's results, rounded to nearest,
 * ties to even, but that a denormal is a zero of its sign, as an argument and as a result.
 *
 * A function takes and gives: d a double, f a float, i and u a 32-bit integer, l and w (signed, unsigned) one of 64 bits, b
 * 0 or 1. All are numbers but those of 64 bits, which are BigInt.
 */
export const FUNCTIONS = {
  dadd: { takes: 'dd', gives: 'd' },
  dsub: { takes: 'dd', gives: 'd' },
  drsub: { takes: 'dd', gives: 'd' },
  dmul: { takes: 'dd', gives: 'd' },
  ddiv: { takes: 'dd', gives: 'd' },
  dcmpeq: { takes: 'dd', gives: 'b' },
  dcmplt: { takes: 'dd', gives: 'b' },
  dcmple: { takes: 'dd', gives: 'b' },
  dcmpgt: { takes: 'dd', gives: 'b' },
  dcmpge: { takes: 'dd', gives: 'b' },
  dcmpun: { takes: 'dd', gives: 'b' },
  i2d: { takes: 'i', gives: 'd' },
  ui2d: { takes: 'u', gives: 'd' },
  l2d: { takes: 'l', gives: 'd' },
  ul2d: { takes: 'w', gives: 'd' },
  f2d: { takes: 'f', gives: 'd' },
  d2f: { takes: 'd', gives: 'f' },
  d2iz: { takes: 'd', gives: 'i' },
  d2uiz: { takes: 'd', gives: 'u' },
  d2lz: { takes: 'd', gives: 'l' },
  d2ulz: { takes: 'd', gives: 'w' },
};

/** The kinds of random arguments that {@link random} gives. */
export const KINDS = ['any', 'near', 'apart', 'short', 'middle'];

const SMALLEST = { d: 2 ** -1022, f: 2 ** -126 };
/** Brings what is smaller than the smallest among the normal numbers. */
const SCALE = { d: 2 ** 600, f: 2 ** 64 };

const double = new Float64Array(1);
const words = new Int32Array(double.buffer);
const single = new Float32Array(1);
const singleWord = new Int32Array(single.buffer);

export function doubleOf(low, high) {
  words[0] = low;
  words[1] = high;
  return double[0];
}

function singleOf(bits) {
  singleWord[0] = bits;
  return single[0];
}

/** A value as the registers hold it, from the first. */
export function registersOf(kind, value) {
  switch (kind) {
    case 'd':
      double[0] = value;
      return [words[0], words[1]];
    case 'f':
      single[0] = value;
      return [singleWord[0]];
    case 'l':
    case 'w':
      return [Number(BigInt.asIntN(32, value)), Number(BigInt.asIntN(32, value >> 32n))];
    default:
      return [value | 0];
  }
}

/** The value in these registers. */
export function valueIn(kind, low, high) {
  switch (kind) {
    case 'd': return doubleOf(low, high);
    case 'f': return singleOf(low);
    case 'l': return (BigInt(high) << 32n) | BigInt(low >>> 0);
    case 'w': return (BigInt(high >>> 0) << 32n) | BigInt(low >>> 0);
    case 'i': return low | 0;
    default: return low >>> 0;
  }
}

function flushed(kind, value) {
  return Math.abs(value) < SMALLEST[kind] ? value * 0 : value;
}

/** A result that was rounded once; `scaled` is the same, times SCALE, and so was not rounded as a denormal is. */
function rounded(kind, value, scaled) {
  const isLess = Math.abs(value) === SMALLEST[kind] && Math.abs(scaled()) < SMALLEST[kind] * SCALE[kind];
  return isLess ? value * 0 : flushed(kind, value);
}

function product(a, b) {
  const [less, more] = Math.abs(a) < Math.abs(b) ? [a, b] : [b, a];
  return rounded('d', a * b, () => less * SCALE.d * more);
}

function truncated(value, least, greatest) {
  if (Number.isNaN(value)) return undefined;
  return Math.min(Math.max(Math.trunc(value), least), greatest) + 0;
}

function truncatedWide(value, least, greatest) {
  if (Number.isNaN(value)) return 0n;
  if (value <= Number(least)) return least;
  return value >= Number(greatest) ? greatest : BigInt(Math.trunc(value));
}

const OPERATIONS = {
  dadd: (a, b) => flushed('d', a + b),
  dsub: (a, b) => flushed('d', a - b),
  drsub: (a, b) => flushed('d', b - a),
  dmul: product,
  ddiv: (a, b) => rounded('d', a / b, () => (a * SCALE.d) / b),
  dcmpeq: (a, b) => (a === b ? 1 : 0),
  dcmplt: (a, b) => (a < b ? 1 : 0),
  dcmple: (a, b) => (a <= b ? 1 : 0),
  dcmpgt: (a, b) => (a > b ? 1 : 0),
  dcmpge: (a, b) => (a >= b ? 1 : 0),
  dcmpun: (a, b) => (Number.isNaN(a) || Number.isNaN(b) ? 1 : 0),
  i2d: (a) => a,
  ui2d: (a) => a,
  l2d: Number,
  ul2d: Number,
  f2d: (a) => a,
  d2f: (a) => rounded('f', Math.fround(a), () => Math.fround(a * SCALE.f)),
  d2iz: (a) => truncated(a, -(2 ** 31), 2 ** 31 - 1),
  d2uiz: (a) => truncated(a, 0, 2 ** 32 - 1),
  d2lz: (a) => truncatedWide(a, -(2n ** 63n), 2n ** 63n - 1n),
  d2ulz: (a) => truncatedWide(a, 0n, 2n ** 64n - 1n),
};

/** What this function returns for these values, or undefined if that is not specified. */
export function expected(name, a, b) {
  const { takes } = FUNCTIONS[name];
  if (takes === 'dd') return OPERATIONS[name](flushed('d', a), flushed('d', b));
  return OPERATIONS[name](takes === 'd' || takes === 'f' ? flushed(takes, a) : a);
}

/** The doubles at which something changes, of both signs, each of which is to meet each. */
export function edges() {
  const below = (value) => {
    const [low, high] = registersOf('d', value);
    return doubleOf(low - 1, low === 0 ? high - 1 : high);
  };
  const above = (value) => value + (value - below(value)) * (Number.isInteger(Math.log2(value)) ? 2 : 1);
  const powers = [-1021, -600, -511, -149, -126, -54, -53, -52, -2, -1, 0, 1, 2, 10, 31, 32, 52, 53, 54, 63, 64, 127, 128, 511, 1000, 1023];
  const around = powers.map((power) => 2 ** power).flatMap((value) => [below(value), value, above(value)]);
  const halves = [0.5, 1.5, 2.5, 3.5, 2 ** 30 + 0.5, 2 ** 31 - 0.5, 2 ** 32 - 0.5, 2 ** 51 + 0.5, 2 ** 52 + 1, 2 ** 53 + 2];
  const ties = [1 + 2 ** -23, 1 + 3 * 2 ** -24, 1 + 5 * 2 ** -24, 1 + 2 ** -26, 1 + 2 ** -27, 3 * 2 ** -53, 3 * 2 ** -54, 1 / 3, 1e-10, 1e10];
  const least = [-150, -151, -152].map((power) => SMALLEST.f - 2 ** power);
  const ends = [0, ...least, SMALLEST.d, above(SMALLEST.d), 2 ** -1074, below(SMALLEST.d), 2 ** -150, Number.MAX_VALUE, below(Number.MAX_VALUE), Infinity];
  return [...ends, ...around, ...halves, ...ties].flatMap((value) => [value, -value]).concat(NaN);
}

/** The integers at which something changes. */
export function integerEdges(kind) {
  const bits = kind === 'l' || kind === 'w' ? 64 : 32;
  const isSigned = kind === 'i' || kind === 'l';
  const wrap = isSigned ? BigInt.asIntN : BigInt.asUintN;
  const all = new Set();
  for (let power = 0n; power <= BigInt(bits); power += 1n) {
    for (const near of [-1025n, -1024n, -513n, -512n, -3n, -2n, -1n, 0n, 1n, 2n, 3n, 512n, 513n, 1024n, 1025n, 1536n]) {
      all.add(wrap(bits, 2n ** power + near)).add(wrap(bits, -(2n ** power) + near));
    }
  }
  return [...all].map((value) => (bits === 64 ? value : Number(value)));
}

/** What an odd number is to be multiplied by, so that the last 64 bits are 1. */
function inverse(odd) {
  let all = odd;
  for (let bits = 3; bits < 64; bits *= 2) all = BigInt.asUintN(64, all * (2n - odd * all));
  return all;
}

/** Random arguments, of one of {@link KINDS}. */
export function random(seed) {
  const next = seededRandom(seed);
  const word = () => Math.floor(next() * 2 ** 32) | 0;
  const below = (count) => Math.floor(next() * count);
  const withExponent = (exponent) => {
    const biased = Math.min(Math.max(exponent, 0), 2047);
    return doubleOf(word(), (word() & 0x800fffff) | (biased << 20));
  };
  /** A mantissa of a few bits, so that sums and products are ties. */
  const short = (exponent) => {
    const bits = 1 + below(52);
    const cut = bits < 20 ? [0, -1 << (20 - bits)] : [bits === 20 ? 0 : -1 << (52 - bits), -1];
    const high = (word() & 0x800fffff & (cut[1] | 0x80000000)) | (exponent << 20);
    return doubleOf(word() & cut[0], high);
  };
  /** A dividend and a divisor whose quotient is next to the middle of two doubles. */
  const middle = () => {
    for (;;) {
      const divisor = 2n ** 52n + (BigInt(word() >>> 0) << 20n) + (BigInt(word() >>> 12) | 1n);
      const by = BigInt(2 * below(8) + 1) * (below(2) === 0 ? 1n : -1n);
      const bits = BigInt(53 + below(2));
      const quotient = BigInt.asUintN(Number(bits), by * inverse(divisor)) | (bits === 53n ? 2n ** 53n : 0n);
      const dividend = (quotient * divisor - by) >> bits;
      if (dividend >= 2n ** 52n && dividend < 2n ** 53n && quotient >= 2n ** 53n) {
        return [Number(dividend), Number(divisor) * 2 ** (below(200) - 100)];
      }
    }
  };
  const second = {
    any: () => doubleOf(word(), word()),
    near: (exponent) => withExponent(exponent + below(7) - 3),
    apart: (exponent) => withExponent(exponent + below(121) - 60),
    short: (exponent) => short(Math.min(Math.max(exponent + below(111) - 55, 0), 2047)),
  };
  const exponentOf = (value) => (registersOf('d', value)[1] >>> 20) & 0x7ff;
  return {
    pair(kind) {
      if (kind === 'middle') return middle();
      const first = kind === 'short' ? short(below(2047)) : doubleOf(word(), word());
      return [first, second[kind](exponentOf(first))];
    },
    /** Around those that are integers of up to 64 bits, and `any`. */
    double: (kind) => (kind === 'any' ? second.any() : kind === 'short' ? short(1015 + below(80)) : withExponent(1020 + below(kind === 'near' ? 16 : 70))),
    /** Around those that are floats. */
    small: (kind) => (kind === 'any' ? second.any() : kind === 'short' ? short(860 + below(300)) : withExponent(kind === 'near' ? 893 + below(8) : 1020 + below(8))),
    single: () => singleOf(word()),
    /** Of any length. */
    integer(kind) {
      const bits = kind === 'l' || kind === 'w' ? 64n : 32n;
      const all = (BigInt(word() >>> 0) << 32n) | BigInt(word() >>> 0);
      const length = BigInt(1 + below(Number(bits)));
      const some = (kind === 'l' || kind === 'i' ? BigInt.asIntN : BigInt.asUintN)(Number(length), all);
      return bits === 64n ? some : Number(some);
    },
  };
}
