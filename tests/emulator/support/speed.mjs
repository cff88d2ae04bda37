import { run } from '../src/core.mjs';
import { Gantry } from '../src/gantry.mjs';
import { CONDITION, FROM, jmp, mov, push, set, TO } from './pio-assembly.mjs';
import { DMA, PIO0, PIO1, PioBench, RAM, REG } from './pio-bench.mjs';
import { axes, openBarrier, OVERHEAD_CYCLES } from './step-program.mjs';

/**
 * Measures the speed of the emulator with a core that never sleeps: alone, with three axes at 1,000,000 steps/s whose
 * words come by DMA, and with three machines that poll a pad in loops of two cycles, at rest and on the axes' steps. It
 * shows the cost of a change; the figures depend on the computer:
 * node tests/emulator/support/speed.mjs
 */
const CYCLES = 125e6;
const PULSE_LOOPS = 14;
/** Slightly different speeds, so that the axes do not step on the same cycles. */
const PERIOD_CYCLES = [125, 124, 126];
const BLOCK_WORDS = 64;
const CHANNEL_BYTES = 0x40;
const [AL1_CTRL, MULTI_CHAN_TRIGGER] = [0x10, 0x430];
const OPTIONS = { startMm: [1e6, 1e6, 1e6], bounceMicros: 0, seed: 1, switches: {}, driver: 'tmc2209' };
/** ldr, adds, adcs, str, adds, lsrs, sbcs, cmp, bne, b: sums in RAM, forever. */
const LOOP = [0x6801, 0x1889, 0x4159, 0x6001, 0x3301, 0x0892, 0x41a5, 0x428b, 0xd1f6, 0xe7f5];
const LOOP_ADDRESS = RAM + 0x8000;

function feed(bench, axis) {
  const word = PERIOD_CYCLES[axis] - OVERHEAD_CYCLES - PULSE_LOOPS;
  const block = RAM + 0x1000 * (axis + 1);
  bench.bus.ram32.fill(word | 0, (block - RAM) / 4, (block - RAM) / 4 + BLOCK_WORDS);
  for (const turn of [0, 1]) {
    const channel = DMA + (2 * axis + turn) * CHANNEL_BYTES;
    // Quiet, from a ring of one block, paced by the FIFO, chained to the other channel.
    const control = (1 << 21) | (axis << 15) | ((2 * axis + 1 - turn) << 11) | (8 << 6) | (1 << 4) | (2 << 2) | 1;
    [block, PIO0 + REG.txf + 4 * axis, BLOCK_WORDS].forEach((value, register) => bench.writeAt(channel + 4 * register, value));
    bench.writeAt(channel + AL1_CTRL, control);
  }
  bench.writeAt(DMA + MULTI_CHAN_TRIGGER, 1 << (2 * axis));
}

/** Counts X down by one every two cycles, and pushes it at each rising edge of its pad. */
const POLLER = [
  jmp(CONDITION.pin, 2),
  jmp(CONDITION.xCounts, 0),
  mov(TO.isr, FROM.x),
  push({ block: 0 }),
  jmp(CONDITION.pin, 6),
  jmp(CONDITION.xCounts, 0),
  jmp(CONDITION.xCounts, 4),
];
const STEP_PINS = [2, 4, 6];
const INPUT_ENABLE = 0x40;

/** Makes machines of PIO1 poll the STEP pads. */
function poll(bench, count) {
  bench.base = PIO1;
  bench.load(POLLER);
  for (let index = 0; index < count; index++) {
    bench.chip.gpio[STEP_PINS[index]].padValue |= INPUT_ENABLE;
    bench.configure(index, { execctrl: ((STEP_PINS[index] << 24) | 0x1f000) >>> 0 });
    bench.force(index, set(TO.x, 0), mov(TO.x, FROM.x, 1));
  }
  bench.write(REG.ctrl, (1 << count) - 1);
  bench.base = PIO0;
}

/** Millions of cycles per second of processor time. */
function measure(count, pollers) {
  const bench = new PioBench();
  const gantry = new Gantry(bench.clock, OPTIONS);
  gantry.attach(bench.chip);
  if (count > 0) axes(bench, count, PULSE_LOOPS, { noted: false });
  for (let axis = 0; axis < count; axis++) feed(bench, axis);
  poll(bench, pollers);
  bench.run(1000);
  openBarrier(bench);
  bench.bus.ram16.set(LOOP, (LOOP_ADDRESS - RAM) / 2);
  Object.assign(bench.core.registers, { 0: RAM + 0x100, 13: RAM + 0x4000, 15: LOOP_ADDRESS });
  const before = process.cpuUsage().user;
  const end = bench.core.cycles + CYCLES;
  while (bench.core.cycles < end) {
    bench.clock.fireDue();
    run(bench.core, bench.bus, bench.clock, end);
  }
  const edges = Object.values(gantry.statistics.axes).reduce((sum, axis) => sum + axis.edges, 0);
  return `${count} axes, ${pollers} pollers: ${(CYCLES / (process.cpuUsage().user - before)).toFixed(0)} million cycles a second, ${edges} steps`;
}

for (const [axes, pollers] of [[0, 0], [3, 0], [0, 3], [3, 3], [0, 0], [3, 0], [0, 3], [3, 3]]) console.log(measure(axes, pollers));
