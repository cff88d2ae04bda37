import assert from 'node:assert/strict';
import test from 'node:test';
import { run } from '../src/core.mjs';
import { RAM, RomBench } from '../support/rom-bench.mjs';

const [WFI, WFE, SEV, CPSID, NOP] = [0xbf30, 0xbf20, 0xbf40, 0xb672, 0xbf00];
const [ICSR, SCR, ISPR, ISER, IPR6] = [0xe000ed04, 0xe000ed10, 0xe000e200, 0xe000e100, 0xe000e418].map((address) => address | 0);
const [PEND_PENDSV, PEND_SYSTICK] = [1 << 28, 1 << 26];
const SEND_EVENT_ON_PENDING = 1 << 4;
const IRQ = 26;
const CODE = RAM + 0x3000;

/** A core at the beginning of a program in RAM. */
class SleepBench extends RomBench {
  constructor(program) {
    super();
    this.load(CODE, [...program, NOP, NOP, NOP, NOP]);
    this.core.VTOR = RAM + 0x200;
    this.bus.ram32.fill(CODE + 0x80, 0x200 / 4, 0x300 / 4);
    this.bus.registers[13] = RAM + 0x4000;
    this.bus.registers[15] = CODE;
  }

  enable() {
    this.bus.write32(ISER, 1 << IRQ);
  }

  pend(irq = IRQ) {
    this.core.setInterrupt(irq, true);
  }

  /** Runs until the core sleeps, or for some cycles. @returns {boolean} whether it sleeps */
  sleeps() {
    run(this.core, this.bus, this.clock, this.core.cycles + 4);
    return this.core.waiting;
  }
}

test('WFI goes on at once if an enabled interrupt is pending, masked or not', () => {
  const masked = new SleepBench([WFI]);
  masked.core.PM = true;
  masked.enable();
  masked.pend();
  assert.equal(masked.sleeps(), false);
  assert.equal(masked.core.IPSR, 0);
  const disabled = new SleepBench([WFI]);
  disabled.pend();
  assert.equal(disabled.sleeps(), true);
  const none = new SleepBench([WFI]);
  none.enable();
  assert.equal(none.sleeps(), true);
});

test('WFI goes on for PendSV and SysTick too', () => {
  for (const pending of [PEND_PENDSV, PEND_SYSTICK]) {
    const bench = new SleepBench([WFI]);
    bench.core.PM = true;
    bench.bus.write32(ICSR, pending);
    assert.equal(bench.sleeps(), false);
    assert.equal(bench.core.IPSR, 0);
  }
});

test('in a handler only a more urgent interrupt ends WFI', () => {
  const bench = new SleepBench([WFI]);
  bench.core.IPSR = 16 + IRQ - 1;
  bench.enable();
  bench.pend();
  assert.equal(bench.sleeps(), true);
  const urgent = new SleepBench([WFI]);
  urgent.core.PM = true;
  urgent.bus.write32(IPR6, 0x00004080);
  urgent.core.IPSR = 16 + IRQ - 2;
  urgent.enable();
  urgent.pend();
  assert.equal(urgent.sleeps(), false);
});

test('a sleeping core is woken by what it sleeps for', () => {
  const asleep = (program) => {
    const bench = new SleepBench(program);
    bench.enable();
    assert.equal(bench.sleeps(), true);
    return bench;
  };
  const wakes = (bench, irq) => {
    bench.pend(irq);
    return !bench.core.waiting;
  };
  assert.equal(wakes(asleep([WFI])), true);
  assert.equal(wakes(asleep([CPSID, WFI])), true);
  assert.equal(wakes(asleep([WFI]), 1), false);
  assert.equal(wakes(asleep([WFE])), true);
  assert.equal(wakes(asleep([WFE]), 1), false);
  // A masked interrupt would not be entered, so WFE continues to sleep.
  assert.equal(wakes(asleep([CPSID, WFE])), false);
});

test('with SEVONPEND any interrupt that becomes pending is an event', () => {
  const bench = new SleepBench([CPSID, WFE, WFE]);
  bench.bus.write32(SCR, SEND_EVENT_ON_PENDING);
  assert.equal(bench.bus.read32(SCR), SEND_EVENT_ON_PENDING);
  assert.equal(bench.sleeps(), true);
  bench.pend(3);
  assert.equal(bench.core.waiting, false);
  assert.equal(bench.core.eventRegistered, false);
  bench.pend(4);
  assert.equal(bench.sleeps(), false);
  const byRegister = new SleepBench([WFE]);
  byRegister.bus.write32(SCR, SEND_EVENT_ON_PENDING);
  byRegister.bus.write32(ISPR, 1 << 5);
  assert.equal(byRegister.sleeps(), false);
});

test('an event that came before WFE is used up by it', () => {
  const bench = new SleepBench([SEV, WFE, WFE]);
  assert.equal(bench.sleeps(), true);
  assert.equal(bench.bus.registers[15], CODE + 6);
});

test('an interrupt that was pending already wakes the core when it is enabled', () => {
  const bench = new SleepBench([WFE]);
  bench.pend();
  assert.ok(bench.sleeps());
  bench.enable();
  bench.core.sleep.enabled();
  assert.ok(!bench.core.waiting);
});
