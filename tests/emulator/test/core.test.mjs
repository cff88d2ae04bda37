import assert from 'node:assert/strict';
import test from 'node:test';
import { addWithCarry } from '../src/alu.mjs';
import { buildChip } from '../src/chip.mjs';
import { MachineClock } from '../src/clock.mjs';
import { run } from '../src/core.mjs';
import { seededRandom } from '../src/limit-switch.mjs';

const CODE = 0x20000100;
const CODE_INDEX = 0x80;
const INSTRUCTIONS = 200_000;
const FLAGS = ['N', 'Z', 'C', 'V'];

function machine() {
  const clock = new MachineClock();
  const nothing = () => {};
  return { ...buildChip(clock, { onWatchdog: nothing, onUartByte: nothing, onWarning: nothing }), clock };
}

function set({ core, bus }, op, registers, flags) {
  core.registers.set(registers);
  FLAGS.forEach((flag, index) => (core[flag] = flags[index]));
  bus.ram16[CODE_INDEX] = op;
}

const state = ({ core }) => [...core.registers, ...FLAGS.map((flag) => core[flag])].join(' ');

/**
 * Instructions that both sides should carry out alike: they use no memory, and none of the flags that rp2040js computes
 * wrongly.
 */
function comparable(op) {
  const shiftOrCarry = op >> 10 === 0b010000 && [2, 3, 4, 5, 6, 7].includes((op >> 6) & 15);
  const registersOnly = op < 0x4700 || op >> 12 === 0b1010 || op >> 8 === 0b10110010 || (op >> 12 === 0b1101 && op < 0xde00) || op >> 11 === 0b11100;
  const highCompareOfPc = op >> 8 === 0x45 && (((op >> 3) & 15) === 15 || (((op >> 4) & 8) | (op & 7)) === 15);
  return registersOnly && !shiftOrCarry && !highCompareOfPc;
}

test('the run loop agrees with rp2040js, instruction by instruction', () => {
  const [ours, theirs] = [machine(), machine()];
  const random = seededRandom(7);
  const corners = [0, 1, 31, 32, 0x7fffffff, 0x80000000, 0xffffffff];
  const word = () => (random() < 0.4 ? corners[Math.floor(random() * corners.length)] : Math.floor(random() * 2 ** 32));
  for (let count = 0; count < INSTRUCTIONS; count++) {
    const op = Math.floor(random() * 0xe800);
    if (!comparable(op)) continue;
    const registers = [...Array.from({ length: 13 }, word), 0x20001000, 0x20000201, CODE];
    const flags = FLAGS.map(() => random() < 0.5);
    for (const each of [ours, theirs]) set(each, op, registers, flags);
    run(ours.core, ours.bus, ours.clock, ours.core.cycles + 1);
    theirs.core.executeInstruction();
    assert.equal(state(ours), state(theirs), `instruction 0x${op.toString(16)}`);
    assert.equal(ours.core.cycles, theirs.core.cycles, `cycles of 0x${op.toString(16)}`);
  }
});

test('sums set the flags the architecture says, carry included', () => {
  const flags = (...operands) => {
    const core = {};
    return [addWithCarry(core, ...operands.map((each) => each | 0)) >>> 0, ...FLAGS.map((flag) => (core[flag] ? 1 : 0))];
  };
  assert.deepEqual(flags(0x7fffffff, 0, 1), [0x80000000, 1, 0, 0, 1]);
  assert.deepEqual(flags(0xffffffff, 0, 1), [0, 0, 1, 1, 0]);
  // 0 - 0x7fffffff - 1 is -2^31, which fits.
  assert.deepEqual(flags(0, ~0x7fffffff, 0), [0x80000000, 1, 0, 0, 0]);
});

test('shifts by a register: none, 32, and more', () => {
  const subject = machine();
  const shifted = (op, value, by) => {
    set(subject, op, [value, by, ...Array(11).fill(0), 0x20001000, 0, CODE], [false, false, true, false]);
    run(subject.core, subject.bus, subject.clock, subject.core.cycles + 1);
    return [subject.core.registers[0], subject.core.C];
  };
  const [LSLS, LSRS, ASRS, RORS] = [0x4088, 0x40c8, 0x4108, 0x41c8];
  assert.deepEqual(shifted(LSLS, 3, 0), [3, true]);
  assert.deepEqual(shifted(LSLS, 3, 32), [0, true]);
  assert.deepEqual(shifted(LSLS, 3, 33), [0, false]);
  assert.deepEqual(shifted(LSRS, 0x80000000, 32), [0, true]);
  assert.deepEqual(shifted(ASRS, 0x80000000, 255), [0xffffffff, true]);
  assert.deepEqual(shifted(RORS, 1, 33), [0x80000000, true]);
});
