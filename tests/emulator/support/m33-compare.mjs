/**
 * Runs the cases of m33-cases.py on our Cortex-M33, and prints where it differs from Unicorn's: `node m33-compare.mjs < CASES`.
 *
 * It fails if it differs anywhere, or if it refuses an instruction of the firmware. Others that it refuses are counted: the emulator
 * has those that firmware uses.
 */
import { readFileSync } from 'node:fs';
import { Fault } from '../src/fault.mjs';
import { CortexM33 } from '../src/m33/core.mjs';

const [CODE, CODE_BYTES, RAM, REACH] = [0x10000000, 0x1000000, 0x20000000, 0x40000];
const [LR, PC] = [14, 15];
const SHOWN = 20;

const content = (address) => Number((BigInt(address) * 2654435761n >> 13n) & 0xffn);
const MEMORY = Uint8Array.from({ length: REACH }, (_, offset) => content(RAM + offset));

/** A case reads the code of another, which is not in its line. */
class Neighbour extends Error {}

/** Memory and code of a case, as Unicorn has them. */
class CaseBus {
  constructor({ at, code }, registers) {
    this.at = at;
    this.code = Buffer.from(Uint16Array.from(code).buffer);
    this.registers = registers;
    this.written = new Map();
  }

  fetch(address) {
    return this.code.readUInt16LE(address - this.at);
  }

  read8(address) {
    const at = address >>> 0;
    if (at >= this.at && at < this.at + this.code.length) return this.code[at - this.at];
    // The places of other cases.
    if (at >= CODE && at < CODE + CODE_BYTES) throw new Neighbour();
    if (at < RAM || at >= RAM + REACH) throw new Fault('outside memory');
    return this.written.get(at) ?? MEMORY[at - RAM];
  }

  read16(address) {
    return this.read8(address) | (this.read8(address + 1) << 8);
  }

  read32(address) {
    return this.read16(address) | (this.read16(address + 2) << 16);
  }

  write8(address, value) {
    this.written.set(address >>> 0, value & 0xff);
  }

  write16(address, value) {
    this.write8(address, value);
    this.write8(address + 1, value >> 8);
  }

  write32(address, value) {
    this.write16(address, value);
    this.write16(address + 2, value >> 16);
  }
}

function outcome(test) {
  const core = new CortexM33(null, null);
  const bus = new CaseBus(test, core.registers);
  Object.assign(core, { bus });
  test.registers.forEach((value, index) => (core.registers[index] = value));
  core.registers[PC] = test.at;
  core.xpsr = test.flags | 0;
  for (let step = 0; step < test.steps; step++) core.step(bus, core.registers, core.registers[PC]);
  const after = Array.from(core.registers.subarray(0, LR + 1), (value) => value >>> 0);
  const writes = [...bus.written].sort(([one], [other]) => one - other);
  return JSON.stringify([after.concat(core.registers[PC] >>> 0), (core.xpsr & 0xf8000000) >>> 0, writes]);
}

const wide = ([first, second]) => (first >= 0xe800 ? [first, second] : [first]).map((half) => half.toString(16)).join(' ');
const named = ({ code, steps }) => wide(code.slice(steps - 1));

const [differing, refused] = [new Map(), new Map()];
const count = (map, key) => map.set(key, (map.get(key) ?? 0) + 1);
let cases = 0;
for (const line of readFileSync(0, 'utf8').split('\n').filter(Boolean)) {
  const test = JSON.parse(line);
  cases += 1;
  try {
    const [ours, theirs] = [outcome(test), JSON.stringify([test.after, test.afterFlags >>> 0, test.writes])];
    if (ours === theirs) continue;
    if (differing.size < SHOWN) console.log(`${named(test)}: ${JSON.stringify(test)}\n  ours   ${ours}\n  theirs ${theirs}`);
    count(differing, named(test));
  } catch (error) {
    if (error instanceof Neighbour) continue;
    if (!(error instanceof Fault)) throw error;
    count(test.isFirmware ? differing : refused, `${named(test)} (${error.message})`);
    if (test.isFirmware) console.log(`${named(test)}: ${error.message}`);
  }
}
console.log(`${cases} instructions, ${differing.size} kinds that differ, ${[...refused.values()].reduce((sum, each) => sum + each, 0)} of random bits that are refused`);
if (process.argv.includes('--refused')) for (const [name, times] of refused) console.log(`${times} ${name}`);
process.exitCode = cases > 0 && differing.size === 0 ? 0 : 1;
