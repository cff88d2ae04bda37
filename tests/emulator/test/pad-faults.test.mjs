import assert from 'node:assert/strict';
import test from 'node:test';
import { HELP, parseOptions } from '../src/options.mjs';
import { PadFaults, padFaultOptions } from '../src/pad-faults.mjs';
import { CONDITION, FROM, jmp, mov, push, set, TO } from '../support/pio-assembly.mjs';
import { PIO0, PIO1, PioBench, REG } from '../support/pio-bench.mjs';

const PIN = 4;
const [GPIO_CTRL, SIO_FUNCTION] = [0x40014004, 5];
const [OUT_SET, OUT_CLEAR, OUTPUTS_SET] = [0xd0000014, 0xd0000018, 0xd0000024];
const [PERIOD, PULSE] = [20, 5];

/** A square wave of PIO0 on a pad with these faults, which a machine of PIO1 stamps, in cycles by its count of X. */
class WaveBench extends PioBench {
  constructor(faults) {
    super(PIO0);
    new PadFaults(this.clock, faults).attach(this.chip);
    this.chip.gpio[PIN].padValue |= 0x40;
    this.edges = this.watch(PIN);
    // set pins, 1 [4]; set pins, 0 [14]
    this.load([set(TO.pins, 1, PULSE - 1), set(TO.pins, 0, PERIOD - PULSE - 1)]);
    this.configure(0, { execctrl: 1 << 12, pinctrl: (1 << 26) | (PIN << 5) });
    this.force(0, set(TO.directions, 1));
    this.edges.length = 0;
    this.base = PIO1;
    this.load([jmp(CONDITION.pin, 2), jmp(CONDITION.xCounts, 0), mov(TO.isr, FROM.x), push({ block: 0 }), jmp(CONDITION.pin, 6), jmp(CONDITION.xCounts, 0), jmp(CONDITION.xCounts, 4)]);
    this.configure(0, { execctrl: (PIN << 24) | 0x1f000 });
    this.force(0, set(TO.x, 0), mov(TO.x, FROM.x, 1));
  }

  /** @returns {{rises: number[], falls: number[], stamps: number}} the pad's edges since the wave began, and how many were stamped */
  wave(periods) {
    this.writeAt(PIO1 + REG.ctrl, 1);
    this.writeAt(PIO0 + REG.ctrl, 1);
    const start = this.core.cycles + 1;
    let stamps = 0;
    while (this.core.cycles < start + periods * PERIOD - 1) {
      this.core.cycles += 1;
      this.clock.fireDue();
      while ((this.read(REG.fstat) & 0x100) === 0) stamps += this.read(REG.rxf) === 0 ? 0 : 1;
    }
    const at = (wanted) => this.edges.filter(([, level]) => level === wanted).map(([cycle]) => cycle - start);
    return { rises: at(1), falls: at(0), stamps };
  }
}

const fault = (edge, cycles) => ({ pad: PIN, edge, cycles });

test('a pulse comes later by its cycles, at the pad and to PIO', () => {
  const { rises, falls, stamps } = new WaveBench([fault(3, 7)]).wave(5);
  assert.deepEqual(rises, [0, 20, 47, 60, 80]);
  assert.deepEqual(falls, [5, 25, 52, 65, 85]);
  assert.equal(stamps, 5);
});

test('a pulse is lost, and others with it as they are named', () => {
  const { rises, falls, stamps } = new WaveBench([fault(2, null), fault(4, null), fault(1, 1)]).wave(5);
  assert.deepEqual(rises, [1, 40, 80]);
  assert.deepEqual(falls, [6, 45, 85]);
  assert.equal(stamps, 3);
});

test('a pulse that is late by more than a period comes after the next ones', () => {
  const { rises, falls } = new WaveBench([fault(1, 30)]).wave(4);
  assert.deepEqual(rises, [20, 30, 40, 60]);
  assert.deepEqual(falls, [25, 35, 45, 65]);
});

test('inputs see a late edge two cycles after it came to the pad', () => {
  const bench = new WaveBench([fault(1, 7)]);
  bench.writeAt(PIO0 + REG.ctrl, 1);
  const start = bench.core.cycles + 1;
  const seen = Array.from({ length: 18 }, () => {
    bench.core.cycles += 1;
    bench.clock.fireDue();
    return [bench.core.cycles - start, (bench.chip.pio[1].inputs.at(bench.core.cycles) >>> PIN) & 1];
  });
  assert.deepEqual(seen.filter(([, level]) => level === 1).map(([cycle]) => cycle), [9, 10, 11, 12, 13]);
});

test('a pad that SIO drives may be faulty too, and counts on after a reset', () => {
  const bench = new PioBench();
  const faults = new PadFaults(bench.clock, [fault(2, null), fault(4, 10)]);
  const rises = (chip) => {
    faults.attach(chip.chip);
    const edges = chip.watch(PIN);
    chip.writeAt(GPIO_CTRL + 8 * PIN, SIO_FUNCTION);
    chip.writeAt(OUTPUTS_SET, 1 << PIN);
    for (let pulse = 0; pulse < 2; pulse++) {
      chip.writeAt(OUT_SET, 1 << PIN);
      chip.writeAt(OUT_CLEAR, 1 << PIN);
    }
    return edges.filter(([, level]) => level === 1).length;
  };
  assert.equal(rises(bench), 1);
  assert.equal(rises(new PioBench()), 1);
  // The fourth is on its way; a chip that is reset has it no more.
  const third = new PioBench();
  assert.equal(rises(third), 2);
  bench.core.cycles += 100;
  bench.clock.fireDue();
  assert.equal(third.chip.gpio[PIN].outputValue, false);
});

test('their options name a pad, an edge and cycles', () => {
  assert.deepEqual(padFaultOptions(['2:100:5', '28:1:3'], ['4:7']), [
    { pad: 2, edge: 100, cycles: 5 },
    { pad: 28, edge: 1, cycles: 3 },
    { pad: 4, edge: 7, cycles: null },
  ]);
  for (const text of ['2:100', '30:1:5', '2:0:5', '2:1:0', '2:1:-3', '2:1:5:6', 'x:1:5', '2:1:1e3']) assert.throws(() => padFaultOptions([text], []), new RegExp(`--shift-edge ${text}: give a pad from 0 to 29`));
  for (const text of ['2', '2:0', '2:1:5', '-1:2']) assert.throws(() => padFaultOptions([], [text]), new RegExp(`--lose-edge ${text}: give a pad from 0 to 29`));
  assert.throws(() => padFaultOptions(['2:1:5'], ['2:1']), /name an edge twice/);
  assert.deepEqual(parseOptions(['--elf', 'a', '--live', '--lose-edge', '2:9']).padFaults, [{ pad: 2, edge: 9, cycles: null }]);
  assert.deepEqual(parseOptions(['--elf', 'a', '--live']).padFaults, []);
  for (const option of ['--shift-edge', '--lose-edge']) assert.ok(HELP.includes(option));
});
