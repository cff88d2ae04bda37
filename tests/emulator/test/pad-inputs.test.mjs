import assert from 'node:assert/strict';
import test from 'node:test';
import { FROM, jmp, CONDITION, mov, push, set, shiftIn, TO, waitGpio } from '../support/pio-assembly.mjs';
import { PIO1, PioBench, REG, SM } from '../support/pio-bench.mjs';
import { PIN as PWM_PIN, PwmBench } from '../support/pwm-bench.mjs';

const PIN = 5;
const [SIO_FUNCTION, PIO0_FUNCTION] = [5, 6];
const [GPIO_CTRL, PADS, INTERRUPTS, INTERRUPT_ENABLE] = [0x40014004, 0x4001c004, 0x400140f0, 0x40014100];
const [GPIO_IN, OUT_SET, OUT_CLEAR, OUTPUTS_SET, OUTPUTS_CLEAR] = [0xd0000004, 0xd0000014, 0xd0000018, 0xd0000024, 0xd0000028];
const [INPUT_ENABLE, IRQ_IO] = [0x40, 13];

function driven(base) {
  const bench = new PioBench(base);
  bench.writeAt(PADS + 4 * PIN, INPUT_ENABLE);
  bench.writeAt(GPIO_CTRL + 8 * PIN, SIO_FUNCTION);
  bench.writeAt(OUTPUTS_SET, 1 << PIN);
  return bench;
}

const level = (bench) => (bench.readAt(GPIO_IN) >>> PIN) & 1;

test('SIO reads back what it drives, two cycles later', () => {
  const bench = driven();
  bench.writeAt(OUT_SET, 1 << PIN);
  const seen = Array.from({ length: 4 }, () => {
    const now = level(bench);
    bench.run(1);
    return now;
  });
  assert.deepEqual(seen, [0, 0, 1, 1]);
  bench.writeAt(OUT_CLEAR, 1 << PIN);
  bench.run(2);
  assert.equal(level(bench), 0);
});

test('an output hides the level from outside, and gives it back', () => {
  const bench = driven();
  bench.chip.gpio[PIN].setInputValue(true);
  bench.run(2);
  assert.equal(level(bench), 0);
  bench.writeAt(OUTPUTS_CLEAR, 1 << PIN);
  bench.run(2);
  assert.equal(level(bench), 1);
  bench.writeAt(OUTPUTS_SET, 1 << PIN);
  bench.run(2);
  assert.equal(level(bench), 0);
});

test('without its input enabled a pad shows nothing', () => {
  const bench = driven();
  bench.writeAt(PADS + 4 * PIN, 0);
  bench.writeAt(OUT_SET, 1 << PIN);
  bench.run(2);
  assert.equal(level(bench), 0);
  bench.writeAt(PADS + 4 * PIN, INPUT_ENABLE);
  bench.run(2);
  assert.equal(level(bench), 1);
});

/** A machine that raises flag 0 when it sees the pin high. @returns {number} cycles from the write to the flag */
function cyclesToFlag(bench, bypassed) {
  bench.write(REG.bypass, bypassed ? 1 << PIN : 0);
  bench.load([waitGpio(1, PIN), 0xc000, jmp(CONDITION.always, 2)]);
  bench.configure(0, {});
  bench.write(REG.ctrl, 1);
  bench.run(10);
  const written = bench.core.cycles;
  bench.writeAt(OUT_SET, 1 << PIN);
  while (bench.read(REG.irq) === 0) bench.run(1);
  return bench.core.cycles - written;
}

test('PIO sees a pin that SIO drives, through its synchroniser or past it', () => {
  // The wait ends on the cycle on which the level is seen; the flag is raised on the next.
  assert.equal(cyclesToFlag(driven(), false), 2 + 1);
  assert.equal(cyclesToFlag(driven(), true), 1 + 1);
  assert.equal(cyclesToFlag(driven(PIO1), false), 2 + 1);
});

test('PIO sees a pin that it drives itself', () => {
  const bench = new PioBench();
  bench.writeAt(PADS + 4 * PIN, INPUT_ENABLE);
  bench.watch(PIN);
  // set pins, 1; three reads of the pin into ISR; push
  bench.load([set(TO.pins, 1), shiftIn(FROM.pins, 1), shiftIn(FROM.pins, 1), shiftIn(FROM.pins, 1), push(), jmp(CONDITION.always, 5)]);
  bench.configure(0, { shiftctrl: 0x80000, pinctrl: (1 << 26) | (PIN << 15) | (PIN << 5) });
  bench.force(0, set(TO.directions, 1));
  bench.write(REG.ctrl, 1);
  bench.run(20);
  assert.equal(bench.read(REG.rxf), 0b011);
  bench.force(0, set(TO.pins, 0));
  bench.run(2);
  bench.force(0, mov(TO.isr, FROM.pins), push());
  assert.equal(bench.read(REG.rxf) & 1, 0);
  assert.equal(bench.read(bench.sm(0, SM.addr)), 5);
});

test('an input override shows SIO, PIO and interrupts the inverse, or always one level', () => {
  const [INVERT, LOW, HIGH] = [1 << 16, 2 << 16, 3 << 16];
  const bench = driven(PIO1);
  const seenWith = (override) => {
    bench.writeAt(GPIO_CTRL + 8 * PIN, SIO_FUNCTION | override);
    bench.run(2);
    const atPio = (bench.chip.pio[1].inputs.at(bench.core.cycles) >>> PIN) & 1;
    assert.equal(level(bench), atPio);
    return atPio;
  };
  for (const [high, expected] of [[0, [0, 1, 0, 1]], [1, [1, 0, 0, 1]]]) {
    bench.writeAt(high ? OUT_SET : OUT_CLEAR, 1 << PIN);
    assert.deepEqual([0, INVERT, LOW, HIGH].map(seenWith), expected);
  }
});

test('a falling edge of an inverted input is a rising one for PIO and for interrupts', () => {
  const bench = driven(PIO1);
  bench.writeAt(OUT_SET, 1 << PIN);
  bench.writeAt(GPIO_CTRL + 8 * PIN, SIO_FUNCTION | (1 << 16));
  bench.load([waitGpio(1, PIN), 0xc000, jmp(CONDITION.always, 2)]);
  bench.configure(0, {});
  bench.run(5);
  // The override itself was an edge.
  bench.writeAt(INTERRUPTS, 0xf << (4 * PIN));
  bench.writeAt(INTERRUPT_ENABLE, 8 << (4 * PIN));
  bench.write(REG.ctrl, 1);
  bench.run(10);
  assert.equal(bench.pending(IRQ_IO), false);
  const fallen = bench.core.cycles;
  bench.writeAt(OUT_CLEAR, 1 << PIN);
  assert.equal(bench.pending(IRQ_IO), true);
  bench.runTo(fallen + 2);
  assert.equal(bench.read(REG.irq), 0);
  bench.runTo(fallen + 3);
  assert.equal(bench.read(REG.irq), 1);
  bench.writeAt(INTERRUPTS, 8 << (4 * PIN));
  bench.writeAt(OUT_SET, 1 << PIN);
  assert.equal(bench.pending(IRQ_IO), false);
});

test('the edges of an output raise the interrupts of its pin', () => {
  const bench = new PioBench();
  bench.writeAt(PADS + 4 * PIN, INPUT_ENABLE);
  bench.watch(PIN);
  bench.configure(0, { pinctrl: (1 << 26) | (PIN << 5) });
  bench.force(0, set(TO.directions, 1), set(TO.pins, 0));
  // Rising edges of GP5.
  bench.writeAt(INTERRUPT_ENABLE, 8 << (4 * PIN));
  assert.equal(bench.pending(IRQ_IO), false);
  bench.force(0, set(TO.pins, 1));
  assert.equal(bench.pending(IRQ_IO), true);
  assert.equal(bench.chip.gpio[PIN].ctrl, PIO0_FUNCTION);
});

test('SIO reads the level of a pad that PWM drives', () => {
  const bench = new PwmBench();
  bench.start({ cc: 30, top: 99 });
  const high = Array.from({ length: 200 }, () => {
    // A level is seen two cycles later.
    bench.readAt(GPIO_IN);
    bench.runTo(bench.core.cycles + 2);
    return (bench.readAt(GPIO_IN) >>> PWM_PIN) & 1;
  });
  assert.equal(high.reduce((sum, level) => sum + level), 60);
});
