import { CONDITION, FROM, irqSet, jmp, mov, OPERATION, pull, REL, set, shiftOut, TO, waitIrq } from './pio-assembly.mjs';
import { REG, SM } from './pio-bench.mjs';

const HIGH = 16;
const START_FLAG = 6;
export const INHIBIT_FLAG = 7;
/** The addresses at which a machine stays after it has run dry before its end, and at its end. */
export const [STARVED_AT, HALTED_AT] = [11, 13];
/** What STATUS compares the level of the RX FIFO with: the end is announced, or not. */
const [END_KNOWN, END_UNKNOWN] = [0x10, 0x11];
const EXECCTRL = (25 << 12) | (2 << 7);
/**
 * Side-set 1 is STEP; OUT's pin is the next one, DIR. ISR holds the pulse length, Y counts steps down. A word contains,
 * from the top bit: step or rest; the level of DIR (in a rest: none, or halt); and cycles to wait.
 */
export const STEP_PROGRAM = [
  mov(TO.x, FROM.null, OPERATION.invert),
  waitIrq(0, START_FLAG),
  pull({ block: 0 }),
  shiftOut(TO.x, 1),
  jmp(CONDITION.xZero, 18),
  shiftOut(TO.x, 1),
  jmp(CONDITION.xZero, 14),
  mov(TO.x, FROM.status),
  jmp(CONDITION.xZero, 12),
  irqSet(INHIBIT_FLAG),
  irqSet(REL),
  jmp(CONDITION.always, STARVED_AT),
  irqSet(REL),
  jmp(CONDITION.always, HALTED_AT),
  shiftOut(TO.x, 30),
  jmp(CONDITION.xCounts, 15),
  mov(TO.x, FROM.null, OPERATION.invert),
  jmp(CONDITION.always, 2),
  shiftOut(TO.pins, 1),
  shiftOut(TO.x, 30),
  jmp(CONDITION.xCounts, 20),
  waitIrq(0, INHIBIT_FLAG),
  jmp(CONDITION.yCounts, 23, HIGH),
  mov(TO.x, FROM.isr, 0, HIGH),
  jmp(CONDITION.xCounts, 24, HIGH),
  mov(TO.x, FROM.null, OPERATION.invert, HIGH),
];
/** Cycles of a step in addition to its wait and its pulse: nine instructions and the last round of each loop. */
export const OVERHEAD_CYCLES = 11;
export const REST = 0x80000000;
export const DIR_HIGH = 0x40000000;
/** Cycles from the fall of STEP to the change of DIR. */
export const TURN_CYCLES = 3;
const FJOIN_TX = 0x40000000;
const STEP_PINS = [2, 4, 6];

/**
 * Makes the first `count` machines axes with this pulse length, behind the closed start barrier. @returns their edges, if
 * noted
 */
export function axes(bench, count, pulseCycles, { noted = true } = {}) {
  bench.load(STEP_PROGRAM);
  bench.write(REG.irqForce, 1 << START_FLAG);
  const edges = Array.from({ length: count }, (_, index) => axis(bench, index, pulseCycles, noted));
  bench.write(REG.ctrl, (1 << count) - 1);
  return edges;
}

function axis(bench, index, pulseCycles, noted) {
  const pin = STEP_PINS[index];
  const pinctrl = ((1 << 29) | (2 << 26) | (1 << 20) | (pin << 10) | (pin << 5) | (pin + 1)) >>> 0;
  bench.configure(index, { execctrl: EXECCTRL | END_UNKNOWN, shiftctrl: (0x40000 | FJOIN_TX) >>> 0, pinctrl });
  const edges = bench.watch(pin, noted);
  bench.force(index, set(TO.directions, 3), set(TO.x, pulseCycles), mov(TO.isr, FROM.x), set(TO.y, 0), mov(TO.y, FROM.y, 1), jmp(CONDITION.always, 0));
  return edges;
}

/** From now on the empty FIFO of this machine is the end. */
export function announceEnd(bench, index) {
  bench.write(bench.sm(index, SM.execctrl), EXECCTRL | END_KNOWN);
}

export const rises = (edges) => edges.filter(([, level]) => level === 1).map(([cycle]) => cycle);

export function openBarrier(bench) {
  bench.write(REG.irq, 1 << START_FLAG);
}
