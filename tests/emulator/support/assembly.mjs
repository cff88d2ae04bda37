import { readFileSync } from 'node:fs';

/**
 * The instructions of a `global_asm!`, read from its source and executed one by one: those of a Cortex-M33 that our functions
 * on doubles are made of, and no others. Code is at places of its own, an instruction at each, and the stack is all memory.
 */
const [SP, LR, PC] = [13, 14, 15];
const RETURN = -1;
const STACK_WORDS = 256;
const CONDITIONS = {
  eq: (m) => m.z, ne: (m) => !m.z, mi: (m) => m.n, pl: (m) => !m.n, hi: (m) => m.c && !m.z,
  lt: (m) => m.n !== m.v, le: (m) => m.z || m.n !== m.v,
};

/** The lines of the assembly in a Rust source. */
function assemblyIn(path) {
  const text = readFileSync(path, 'utf8');
  const start = text.indexOf('global_asm!(', text.indexOf('use core::arch') + 'use core::arch::{asm, global_asm'.length);
  const lines = text.slice(start).split('\n').map((line) => /^\s*"((?:[^"\\]|\\.)*)",/.exec(line)?.[1]);
  return lines.filter((line) => line !== undefined).map((line) => line.replace(/\\(.)/g, '$1').replaceAll('{{', '{').replaceAll('}}', '}'));
}

/** Macros replaced by what they stand for. */
function expanded(lines) {
  const macros = new Map();
  const out = [];
  let defining;
  const expand = (line) => {
    const [, name, rest] = /^(\S+)\s*(.*)$/.exec(line);
    const macro = macros.get(name);
    if (!macro) return out.push(line);
    const values = rest === '' ? [] : rest.split(',').map((value) => value.trim());
    for (const each of macro.lines) {
      expand(each.replace(/\\(\w+)/g, (_, parameter) => values[macro.parameters.indexOf(parameter)]));
    }
  };
  for (const line of lines) {
    const head = /^\.macro (\w+)\s*(.*)$/.exec(line);
    if (head) {
      defining = { parameters: head[2].split(',').map((each) => each.trim()), lines: [] };
      macros.set(head[1], defining);
    } else if (line === '.endm') defining = undefined;
    else if (line.startsWith('.purgem')) continue;
    else if (defining) defining.lines.push(line);
    else expand(line);
  }
  return out;
}

function register(name) {
  return { sp: SP, lr: LR, pc: PC, apsr_nzcv: PC }[name] ?? Number(/^r(\d+)$/.exec(name)[1]);
}

function number(text) {
  return Number(text.replace(/^#(-?)/, '$1').replace(/^-0x/, '-0x'));
}

/** What a last operand is, of a register with or without a shift, or a number. */
function value(text) {
  if (text.startsWith('#')) {
    const constant = number(text) | 0;
    return () => constant;
  }
  const [name, shift] = text.split(/,\s*/);
  const from = register(name);
  if (!shift) return (m) => m.r[from];
  const [kind, places] = shift.split(' ');
  const by = number(places);
  if (kind === 'lsl') return (m) => m.r[from] << by;
  if (kind === 'lsr') return (m) => m.r[from] >>> by;
  if (kind === 'asr') return (m) => m.r[from] >> by;
  throw new Error(text);
}

/** a + b + carry, with flags if they are asked for. */
function sum(m, a, b, carry, sets) {
  const unsigned = (a >>> 0) + (b >>> 0) + carry;
  const result = unsigned | 0;
  if (sets) {
    setNZ(m, result);
    m.c = unsigned >= 2 ** 32;
    m.v = ((a ^ result) & (b ^ result)) < 0;
  }
  return result;
}

function setNZ(m, result) {
  m.n = result < 0;
  m.z = result === 0;
}

function shifted(kind, of, by) {
  if (by > 31) return 0;
  return kind === 'lsl' ? of << by : (of >>> by) | 0;
}

/** The 64-bit product of unsigned words, plus a sum, as its words. */
function wide(a, b, low, high) {
  const [a0, a1, b0, b1] = [a & 0xffff, a >>> 16, b & 0xffff, b >>> 16];
  const p0 = a0 * b0 + (low >>> 0);
  const p1 = a1 * b0 + Math.floor(p0 / 65536);
  const p2 = a0 * b1 + (p1 % 65536);
  const top = a1 * b1 + Math.floor(p1 / 65536) + Math.floor(p2 / 65536) + (high >>> 0);
  return [(p2 << 16) | (p0 % 65536), top | 0];
}

/** The upper word of a signed product, plus a word above it, rounded. */
function rounded(a, b, above) {
  const [low, high] = wide(a, b, 0, 0);
  const signed = (high - (a < 0 ? b : 0) - (b < 0 ? a : 0)) | 0;
  return (signed + above + (low < 0 ? 1 : 0)) | 0;
}

const dataOperations = {
  add: (a, b) => [a, b, 0],
  adc: (a, b, m) => [a, b, m.c ? 1 : 0],
  sub: (a, b) => [a, ~b, 1],
  sbc: (a, b, m) => [a, ~b, m.c ? 1 : 0],
  rsb: (a, b) => [~a, b, 1],
};
const logicalOperations = { orr: (a, b) => a | b, bic: (a, b) => a & ~b, eor: (a, b) => a ^ b };

/** The operands of an instruction; what follows a register as its shift belongs to it. */
function operandsOf(text) {
  return text.split(/,(?!\s*(?:lsl|lsr|asr) )\s*/).filter((each) => each !== '');
}

function compiled(line, places, at) {
  const [, name, rest] = /^(\S+)\s*(.*)$/.exec(line);
  const operands = operandsOf(rest);
  const target = (label) => {
    const local = /^(\d+)([bf])$/.exec(label);
    if (!local) return places.get(label);
    const all = places.get(local[1]);
    return local[2] === 'b' ? all.findLast((place) => place <= at) : all.find((place) => place > at);
  };
  const listed = () => rest.replace(/[{}]/g, '').split(',').map((each) => register(each.trim()));
  switch (name) {
    case 'push': {
      const list = listed().reverse();
      return (m) => list.forEach((each) => { m.memory[--m.r[SP]] = m.r[each]; });
    }
    case 'pop': {
      const list = listed();
      return (m) => list.forEach((each) => { m.r[each] = m.memory[m.r[SP]++]; });
    }
    case 'b':
    case 'bl': {
      const to = target(operands[0]);
      if (name === 'b') return (m) => { m.r[PC] = to; };
      return (m) => { m.r[LR] = m.r[PC]; m.r[PC] = to; };
    }
    case 'bx': return (m) => { m.r[PC] = m.r[LR]; };
    case 'blx': return (m) => { const to = m.r[LR]; m.r[LR] = m.r[PC]; m.r[PC] = to; };
    case 'cbnz': {
      const [from, to] = [register(operands[0]), target(operands[1])];
      return (m) => { if (m.r[from] !== 0) m.r[PC] = to; };
    }
    case 'it': return () => {};
    case 'cmp': {
      const [from, other] = [register(operands[0]), value(operands[1])];
      return (m) => { sum(m, m.r[from], ~other(m), 1, true); };
    }
    case 'ubfx': {
      const [to, from] = operands.map((each, index) => (index < 2 ? register(each) : number(each)));
      const [lowest, width] = [number(operands[2]), number(operands[3])];
      return (m) => { m.r[to] = (m.r[from] >>> lowest) & (2 ** width - 1); };
    }
    case 'umull':
    case 'umlal': {
      const [low, high, a, b] = operands.map(register);
      const adds = name === 'umlal';
      return (m) => { [m.r[low], m.r[high]] = wide(m.r[a], m.r[b], adds ? m.r[low] : 0, adds ? m.r[high] : 0); };
    }
    case 'mla': {
      const [to, a, b, above] = operands.map(register);
      return (m) => { m.r[to] = Math.imul(m.r[a], m.r[b]) + m.r[above]; };
    }
    case 'smmulr':
    case 'smmlar': {
      const [to, a, b, above] = operands.map(register);
      return (m) => { m.r[to] = rounded(m.r[a], m.r[b], above === undefined ? 0 : m.r[above]); };
    }
    case 'cdp': {
      const [opc1, opc2] = [number(operands[1]), number(operands[5])];
      const [crd, crn, crm] = operands.slice(2, 5).map((each) => Number(each.slice(1)));
      return (m) => m.dcp.cdp(opc1, crd, crn, crm, opc2);
    }
    case 'mcrr': {
      const [opc1, low, high, crm] = [number(operands[1]), register(operands[2]), register(operands[3]), Number(operands[4].slice(1))];
      return (m) => m.dcp.mcrr(opc1, crm, m.r[low], m.r[high]);
    }
    case 'mrrc':
    case 'mrrc2': {
      const [opc1, low, high, crm] = [number(operands[1]), register(operands[2]), register(operands[3]), Number(operands[4].slice(1))];
      const keeps = name === 'mrrc2';
      return (m) => { [m.r[low], m.r[high]] = m.dcp.mrrc(opc1, crm, keeps); };
    }
    case 'mrc':
    case 'mrc2': {
      const [opc1, to, opc2] = [number(operands[1]), register(operands[2]), number(operands[5])];
      const [crn, crm] = [Number(operands[3].slice(1)), Number(operands[4].slice(1))];
      const keeps = name === 'mrc2';
      return (m) => {
        const word = m.dcp.mrc(opc1, crn, crm, opc2, keeps);
        if (to !== PC) m.r[to] = word;
        else [m.n, m.z, m.c, m.v] = [31, 30, 29, 28].map((bit) => ((word >>> bit) & 1) === 1);
      };
    }
  }
  const conditional = /^(b|bx|add)(eq|ne|mi|pl|hi|lt|le)$/.exec(name);
  if (conditional) {
    const condition = CONDITIONS[conditional[2]];
    const then = compiled(`${conditional[1]} ${rest}`, places, at);
    return (m) => { if (condition(m)) then(m); };
  }
  const plain = name === 'addw' || name === 'movw' ? name.slice(0, 3) : name.replace(/s$/, '');
  const sets = name.endsWith('s') && name !== plain;
  const to = register(operands[0]);
  if (plain === 'mov' || plain === 'mvn') {
    const from = value(operands[1]);
    const flip = plain === 'mvn' ? -1 : 0;
    return (m) => { m.r[to] = from(m) ^ flip; if (sets) setNZ(m, m.r[to]); };
  }
  const [first, second] = operands.length === 2 ? [to, value(operands[1])] : [register(operands[1]), value(operands[2])];
  if (plain === 'lsl' || plain === 'lsr') return (m) => { m.r[to] = shifted(plain, m.r[first], second(m) & 0xff); };
  const logical = logicalOperations[plain];
  if (logical) return (m) => { m.r[to] = logical(m.r[first], second(m)); if (sets) setNZ(m, m.r[to]); };
  const data = dataOperations[plain];
  if (!data) throw new Error(`no such instruction here: ${line}`);
  return (m) => { m.r[to] = sum(m, ...data(m.r[first], second(m), m), sets); };
}

/** A core with a coprocessor that executes a source's assembly. */
export class Assembly {
  r = new Int32Array(16);
  memory = new Int32Array(STACK_WORDS);
  n = false;
  z = false;
  c = false;
  v = false;
  /** How many instructions were executed. */
  count = 0;
  /** Is called before each instruction, if there is anyone. */
  before = undefined;
  #code = [];
  #places = new Map();

  constructor(path, dcp) {
    this.dcp = dcp;
    this.r[SP] = STACK_WORDS;
    const lines = [];
    for (const line of expanded(assemblyIn(path))) {
      const label = /^(\S+):$/.exec(line)?.[1];
      if (label === undefined && !line.startsWith('.')) lines.push(line);
      if (label === undefined) continue;
      if (/^\d+$/.test(label)) this.#places.set(label, [...(this.#places.get(label) ?? []), lines.length]);
      else this.#places.set(label, lines.length);
    }
    this.#code = lines.map((line, at) => compiled(line, this.#places, at));
  }

  has(name) {
    return this.#places.has(name);
  }

  /** Calls a function with what is in the registers, which it leaves as the function returns. */
  call(name) {
    const { r } = this;
    const [stack, link] = [r[SP], r[LR]];
    r[LR] = RETURN;
    r[PC] = this.#places.get(name);
    while (r[PC] !== RETURN) {
      this.before?.();
      this.count += 1;
      this.#code[r[PC]++](this);
    }
    if (r[SP] !== stack) throw new Error(`${name} leaves the stack by ${stack - r[SP]} words lower`);
    r[LR] = link;
  }

  /** An interrupt whose handler is this: what the core keeps of registers and flags is as it was afterwards. */
  interrupt(handler) {
    const { r, n, z, c, v, before } = this;
    const kept = [0, 1, 2, 3, 12, LR, PC].map((each) => [each, r[each]]);
    this.before = undefined;
    handler();
    this.before = before;
    for (const [each, word] of kept) r[each] = word;
    Object.assign(this, { n, z, c, v });
  }
}
