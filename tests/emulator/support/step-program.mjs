import { CONDITION, FROM, irqWait, jmp, mov, pull, REL, set, shiftOut, TO, waitIrq } from './pio-assembly.mjs';
import { REG } from './pio-bench.mjs';

const HIGH = 16;
const [START_FLAG, BRAKE_FLAG] = [6, 7];
/** Side-set 1 is STEP; ISR holds the pulse, Y counts steps down. A word: cycles to wait, and in the top bit, step or rest. */
export const STEP_PROGRAM = [
  waitIrq(0, START_FLAG),
  mov(TO.x, FROM.status),
  jmp(CONDITION.xZero, 4),
  irqWait(REL),
  pull(),
  shiftOut(TO.x, 31),
  jmp(CONDITION.xCounts, 6),
  mov(TO.x, FROM.osr),
  jmp(CONDITION.xZero, 1),
  waitIrq(0, BRAKE_FLAG),
  jmp(CONDITION.yCounts, 11, HIGH),
  mov(TO.x, FROM.isr, 0, HIGH),
  jmp(CONDITION.xCounts, 12, HIGH),
];
/** Cycles a step takes beyond its wait and its pulse: nine instructions and the last round of each loop. */
export const OVERHEAD_CYCLES = 11;
export const STEP = 0x80000000;
const FJOIN_TX = 0x40000000;
const STEP_PINS = [2, 4, 6];

/** Makes the first machines axes, with the given pulse length, behind the closed start gate. @returns their edges, if noted */
export function axes(bench, count, pulseCycles, { noted = true } = {}) {
  bench.load(STEP_PROGRAM);
  bench.write(REG.irqForce, 1 << START_FLAG);
  const edges = Array.from({ length: count }, (_, index) => axis(bench, index, pulseCycles, noted));
  bench.write(REG.ctrl, (1 << count) - 1);
  return edges;
}

function axis(bench, index, pulseCycles, noted) {
  const pin = STEP_PINS[index];
  const pinctrl = ((1 << 29) | (1 << 26) | (pin << 10) | (pin << 5)) >>> 0;
  bench.configure(index, { execctrl: (12 << 12) | (1 << 7) | 1, shiftctrl: (0xc0000 | FJOIN_TX) >>> 0, pinctrl });
  const edges = bench.watch(pin, noted);
  bench.force(index, set(TO.directions, 1), set(TO.x, pulseCycles), mov(TO.isr, FROM.x), set(TO.y, 0), mov(TO.y, FROM.y, 1), jmp(CONDITION.always, 0));
  return edges;
}

export const rises = (edges) => edges.filter(([, level]) => level === 1).map(([cycle]) => cycle);

export function openGate(bench) {
  bench.write(REG.irq, 1 << START_FLAG);
}
