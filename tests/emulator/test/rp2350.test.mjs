import assert from 'node:assert/strict';
import test from 'node:test';

process.env.EMULATED_CHIP = 'rp2350';
const { CYCLES_PER_MICRO, MachineClock } = await import('../src/clock.mjs');
const { buildRp2350 } = await import('../src/rp2350/chip.mjs');
const { Fault } = await import('../src/fault.mjs');
const pio = await import('../support/pio-assembly.mjs');
const { isForRp2350 } = await import('../src/which-chip.mjs');

const [CODE, STACK, HANDLERS, TABLE, DATA] = [0x20000100, 0x20008000, 0x20001000, 0x20002000, 0x20004000];
const [SP, LR, PC] = [13, 14, 15];
const [NOP, BX_LR, B_SELF, WFE, CPSID, CPSIE] = [0xbf00, 0x4770, 0xe7fe, 0xbf20, 0xb672, 0xb662];
const [STIR, ISER0, IPR0, CPACR] = [0xe000ef00, 0xe000e100, 0xe000e400, 0xe000ed88];
const SET = 0x2000;

function machine(code = [B_SELF], options = {}) {
  const clock = new MachineClock();
  const heard = { resets: 0, bootsel: null, warnings: [] };
  const board = { onWatchdog: () => (heard.resets += 1), onUartByte() {}, onWarning: (text) => heard.warnings.push(text), onBootsel: (...hints) => (heard.bootsel = hints) };
  const built = { ...buildRp2350(clock, board, options), clock, heard };
  put(built, CODE, code);
  built.core.VTOR = TABLE;
  built.core.SP = STACK;
  built.core.PC = CODE;
  return built;
}

function put({ bus }, address, halfwords) {
  halfwords.forEach((halfword, index) => bus.write16((address + 2 * index) | 0, halfword));
}

function go({ core, bus, clock, runCore }, cycles = 200) {
  const until = core.cycles + cycles;
  while (core.cycles < until) {
    clock.fireDue();
    if (core.waiting) core.cycles = Math.min(until, clock.next);
    else assert.equal(runCore(core, bus, clock, until), null);
  }
}

const movw = (register, value) => [0xf240 | ((value >> 1) & 0x400) | (value >> 12), ((value << 4) & 0x7000) | (register << 8) | (value & 0xff)];
const movt = (register, value) => [movw(register, value)[0] | 0x80, movw(register, value)[1]];
const set = (register, value) => [...movw(register, value & 0xffff), ...movt(register, value >>> 16)];

/** A handler that adds its mark to the list at DATA, whose end is in r7; then it does more. */
function handler(chip, interrupt, more = []) {
  const at = HANDLERS + 0x80 * interrupt;
  // movs r0, #interrupt; strb r0, [r7]; adds r7, #1
  put(chip, at, [0x2000 | interrupt, 0x7038, 0x3701, ...more, BX_LR]);
  chip.bus.write32((TABLE + 4 * (16 + interrupt)) | 0, at | 1);
}

const marks = ({ bus, core }) => Array.from({ length: core.registers[7] - DATA }, (_, index) => bus.read8(DATA + index));

function withInterrupts(code, priorities) {
  const chip = machine(code);
  chip.core.registers[7] = DATA;
  for (const [interrupt, priority] of Object.entries(priorities)) {
    chip.bus.write8((IPR0 + Number(interrupt)) | 0, priority);
    chip.bus.write32((ISER0 + 4 * (interrupt >> 5)) | 0, 1 << (interrupt & 31));
  }
  return chip;
}

test('a block of IT carries out what its conditions let through, and its shifts set no flags', () => {
  // cmp r0, r0; ITETE eq; adds r1, #1; adds r2, #1; adds r3, #1; movw r4, #7 (32 bits)
  const chip = machine([0x4280, 0xbf0b, 0x3101, 0x3201, 0x3301, ...movw(4, 7), B_SELF]);
  go(chip);
  assert.deepEqual(Array.from(chip.core.registers.subarray(0, 5)), [0, 1, 0, 1, 0]);
  assert.equal(chip.core.Z, true);
  assert.equal(chip.core.it, 0);
  assert.equal(chip.core.PC, CODE + 14);
});

test('an interrupt between IT and its instructions comes back into the block', () => {
  // cmp r0, r0; ITE ne; adds r1, #1; adds r1, #2. The handler's own instructions heed no condition.
  const chip = withInterrupts([0x4280, 0xbf14, 0x3101, 0x3102, B_SELF], { 3: 0x80 });
  handler(chip, 3);
  chip.clock.createAlarm(() => chip.core.setInterrupt(3, true)).scheduleAt(chip.core.cycles + 2);
  go(chip, 8);
  chip.core.setInterrupt(3, false);
  go(chip);
  assert.equal(chip.core.registers[1], 2);
  assert.deepEqual(marks(chip), [3]);
});

test('a handler of a higher priority interrupts another, one of the same waits', () => {
  // STIR pends them from code: str r5, [r6]
  const chip = withInterrupts([...set(5, 47), ...set(6, STIR), 0x6035, B_SELF], { 47: 0x80, 48: 0x40, 49: 0x80 });
  // The first handler pends both others.
  handler(chip, 47, [...movw(5, 49), 0x6035, ...movw(5, 48), 0x6035, NOP, 0x212f, 0x7039, 0x3701]);
  handler(chip, 48);
  handler(chip, 49);
  go(chip);
  assert.deepEqual(marks(chip), [47, 48, 47, 49]);
  assert.equal(chip.core.IPSR, 0);
  assert.equal(chip.core.SP, STACK);
  assert.equal(chip.core.PC, CODE + 18);
});

test('masked interrupts wake WFI but not WFE, and come when they are unmasked', () => {
  for (const [sleep, wakes] of [[0xbf30, true], [WFE, false]]) {
    const chip = withInterrupts([CPSID, sleep, CPSIE, B_SELF], { 2: 0 });
    handler(chip, 2);
    go(chip, 20);
    assert.equal(chip.core.waiting, true);
    chip.core.setInterrupt(2, true);
    assert.equal(chip.core.waiting, !wakes);
    go(chip, 8);
    chip.core.setInterrupt(2, false);
    go(chip, 40);
    assert.equal(marks(chip).includes(2), wakes);
  }
});

test('an interrupt that is held back stays pending', () => {
  // Named as on the RP2040: the third of the software interrupts.
  const [named, interrupt] = [28, 49];
  const chip = withInterrupts([B_SELF], { [interrupt]: 0 });
  handler(chip, interrupt);
  chip.holdInterrupt(named, true);
  chip.core.exceptions.pend(16 + interrupt);
  go(chip);
  assert.deepEqual(marks(chip), []);
  chip.holdInterrupt(named, false);
  go(chip);
  assert.deepEqual(marks(chip), [interrupt]);
});

test('an exclusive store fails behind a handler', () => {
  // r0 = DATA + 0x100; ldrex r1, [r0]; strex r2, r1, [r0]; strex r3, r1, [r0]
  const chip = machine([...set(0, DATA + 0x100), 0xe850, 0x1f00, 0xe840, 0x1200, 0xe840, 0x1300, B_SELF]);
  go(chip);
  assert.deepEqual([chip.core.registers[2], chip.core.registers[3]], [0, 1]);
});

test('doubles need their coprocessor to be enabled', () => {
  // mcrr p4, #1, r0, r1, c0
  const chip = machine([0xec41, 0x0410, B_SELF]);
  assert.ok(chip.runCore(chip.core, chip.bus, chip.clock, 10) instanceof Fault);
  const enabled = machine([0xec41, 0x0410, B_SELF]);
  enabled.bus.write32(CPACR | 0, 3 << 8);
  go(enabled);
});

test('words and half-words may stand at any address of memory', () => {
  const { bus } = machine();
  bus.write32(DATA + 1, 0x12345678);
  bus.write16(DATA + 7, 0xabcd);
  assert.equal(bus.read32(DATA + 1), 0x12345678);
  assert.equal(bus.read8(DATA + 4), 0x12);
  assert.equal(bus.read16(DATA + 7), 0xabcd);
  assert.throws(() => bus.read32(0x400b0025), /unaligned/);
  assert.throws(() => bus.write16(0x400b0011, 0), /unaligned/);
});

test('a pad is isolated until the firmware connects it, and its overrides stand where the RP2350 has them', () => {
  const { bus, chip } = machine();
  const pin = chip.gpio[5];
  // GPIO 5: SIO's, an output, high.
  bus.write32(0x40028000 + 8 * 5 + 4, 5);
  bus.write32(0xd0000038 | 0, 1 << 5);
  bus.write32(0xd0000018 | 0, 1 << 5);
  assert.equal(pin.outputEnable, false);
  bus.write32(0x40038000 + 4 + 4 * 5, 0x56);
  assert.deepEqual([pin.outputEnable, pin.outputValue], [true, true]);
  // OUTOVER: low.
  bus.write32(0x40028000 + SET + 8 * 5 + 4, 2 << 12);
  assert.equal(pin.outputValue, false);
  assert.equal(bus.read32(0x40028000 + 8 * 5 + 4), 5 | (2 << 12));
  // OEOVER: off.
  bus.write32(0x40028000 + 8 * 5 + 4, 5 | (2 << 14));
  assert.equal(pin.outputEnable, false);
});

test('the interrupt of a pin has its registers behind those of 48 pins', () => {
  const { bus, chip, core } = machine();
  bus.write32(0x40038000 + 4 + 4 * 9, 0x56);
  chip.gpio[9].setInputValue(false);
  bus.write32(0x40028230 + 4, -1);
  bus.write32(0x40028248 + 4, 8 << 4);
  chip.gpio[9].setInputValue(true);
  assert.equal(core.exceptions.pending[16 + 21], 1);
  assert.equal(bus.read32(0x40028278 + 4), 8 << 4);
  bus.write32(0x40028230 + 4, 8 << 4);
  assert.equal(core.exceptions.pending[16 + 21], 0);
});

test('an alarm of TIMER0 interrupts by the registers of the RP2350', () => {
  const chip = machine();
  const { bus, core, clock } = chip;
  bus.write32(0x400b0040, 1);
  bus.write32(0x400b0010, 20);
  go(chip, 20 * CYCLES_PER_MICRO + 10);
  assert.equal(core.exceptions.pending[16], 1);
  assert.equal(bus.read32(0x400b003c), 1);
  bus.write32(0x400b003c, 1);
  assert.equal(core.exceptions.pending[16], 0);
  assert.equal(clock.cycles >= 20 * 150, true);
});

test('the watchdog counts down once a microsecond', () => {
  const chip = machine();
  chip.bus.write32(0x400d8004, 1000);
  chip.bus.write32(0x400d8000, 1 << 30);
  go(chip, 999 * 150);
  assert.equal(chip.heard.resets, 0);
  go(chip, 2 * 150);
  assert.equal(chip.heard.resets, 1);
});

test('sixteen channels of the DMA move words by the control word of the RP2350, one after the other', () => {
  const chip = machine();
  const { bus, core } = chip;
  for (let index = 0; index < 4; index++) bus.write32(DATA + 4 * index, 100 + index);
  const control = (next, more = 0) => 1 | (2 << 2) | (1 << 4) | (1 << 6) | (next << 13) | (63 << 17) | more;
  const channel = (index) => 0x50000000 + 0x40 * index;
  // Channel 15 goes on where 14 ends.
  bus.write32(channel(15), DATA + 8);
  bus.write32(channel(15) + 4, DATA + 0x108);
  bus.write32(channel(15) + 8, 2);
  bus.write32(channel(15) + 0x10, control(15));
  bus.write32(channel(14), DATA);
  bus.write32(channel(14) + 4, DATA + 0x100);
  bus.write32(channel(14) + 8, 2);
  bus.write32(0x50000404, 1 << 15);
  bus.write32(channel(14) + 0xc, control(15, 1 << 23));
  go(chip, 60);
  assert.deepEqual([0, 4, 8, 12].map((offset) => bus.read32(DATA + 0x100 + offset)), [100, 101, 102, 103]);
  assert.equal(core.exceptions.pending[16 + 10], 1);
  assert.equal(bus.read32(0x50000400), 1 << 15);
  assert.equal(bus.read32(0x50000468), 16);
});

test("PIO's status, interrupts and requests are where the RP2350 has them", () => {
  const { bus, chip, core } = machine();
  const execctrl = 0x502000c8 + 4;
  bus.write32(execctrl, (0x1f << 12) | (1 << 5) | 3);
  assert.deepEqual([chip.pio[0].machines[0].statusOfRx, chip.pio[0].machines[0].statusLevel], [true, 3]);
  assert.equal(bus.read32(execctrl), (0x1f << 12) | (1 << 5) | 3);
  bus.write32(0x50200170, 1 << 8);
  bus.write32(0x50200034, 1);
  assert.equal(core.exceptions.pending[16 + 15], 1);
  assert.equal(bus.read32(0x50200178) & (1 << 8), 1 << 8);
});

const [PIO0_AT, PIO2_AT] = [0x50200000, 0x50400000];
/** A flag's number in the block that follows: after PIO2 that is PIO0. */
const NEXT = 24;

/** Machine 0 of a block makes a square wave on a pin, once the flag 6 of PIO0 is clear and its program begins. @returns its edges' cycles */
function squareWave({ bus, chip, clock }, base, pin, first) {
  const edges = [];
  const functionSelect = base === PIO0_AT ? 6 : 8;
  bus.write32(0x40038000 + 4 + 4 * pin, 0x56);
  bus.write32(0x40028000 + 8 * pin + 4, functionSelect);
  [first, pio.set(pio.TO.pins, 1, 2), pio.set(pio.TO.pins, 0)].forEach((word, index) => bus.write32(base + 0x48 + 4 * index, word));
  bus.write32(base + 0xc8 + 4, (2 << 12) | (1 << 7));
  bus.write32(base + 0xc8 + 0x14, (1 << 26) | (pin << 5));
  bus.write32(base + 0xc8 + 0x10, pio.set(pio.TO.directions, 1));
  chip.gpio[pin].addListener(() => edges.push(clock.cycles));
  bus.write32(base, 1);
  return edges;
}

test('PIO2 sees a flag of PIO0 on the cycle on which PIO0 does, and drives a pin', () => {
  const chip = machine();
  chip.bus.write32(PIO0_AT + 0x34, 1 << 6);
  const edges = [squareWave(chip, PIO0_AT, 2, pio.waitIrq(0, 6)), squareWave(chip, PIO2_AT, 27, pio.waitIrq(0, NEXT | 6))];
  go(chip, 50);
  assert.deepEqual(edges, [[], []]);
  chip.bus.write32(PIO0_AT + 0x30, 1 << 6);
  const opened = chip.clock.cycles;
  go(chip, 40);
  assert.equal(edges[0][0], opened + 2);
  assert.equal(edges[0].length > 10, true);
  assert.deepEqual(edges[1], edges[0]);
});

test("a flag of PIO0 that PIO2 sets is seen a cycle later by PIO0's machines, and by the core", () => {
  const chip = machine();
  const { bus } = chip;
  bus.write32(PIO0_AT + 0x34, 1 << 6);
  const edges = squareWave(chip, PIO0_AT, 2, pio.waitIrq(1, 7));
  // By then PIO0 waits, and nothing of it is due.
  go(chip, 20);
  squareWave(chip, PIO2_AT, 27, pio.irqSet(NEXT | 7));
  const started = chip.clock.cycles;
  go(chip, 5);
  // PIO2 sets it on the first cycle after it is enabled, PIO0 takes it on the second and raises the pin on the third.
  assert.deepEqual(edges.slice(0, 1), [started + 3]);
  bus.write32(PIO0_AT, 0);
  go(chip, 20);
  bus.write32(PIO2_AT + 0xc8 + 0x10, pio.irqSet(NEXT | 7));
  go(chip, 2);
  assert.equal(bus.read32(PIO0_AT + 0x30), (1 << 6) | (1 << 7));
  assert.equal(bus.read32(PIO2_AT + 0x30), 0);
});

test('a flag that a machine of PIO0 clears is seen by both blocks on the cycle after', () => {
  const chip = machine();
  const { bus } = chip;
  bus.write32(PIO0_AT + 0x34, 1 << 6);
  const edges = [squareWave(chip, PIO0_AT, 2, pio.waitIrq(0, 6)), squareWave(chip, PIO2_AT, 27, pio.waitIrq(0, NEXT | 6))];
  bus.write32(PIO2_AT, 0);
  go(chip, 20);
  // Machine 1 of PIO0 clears it on the cycle on which PIO2 looks for the first time, and so does not see it yet.
  bus.write32(PIO0_AT + 0x48 + 4 * 8, pio.irqClear(6));
  bus.write32(PIO0_AT + 0xe0 + 4, (8 << 12) | (8 << 7));
  bus.write32(PIO0_AT + 0xe0 + 0x10, pio.jmp(pio.CONDITION.always, 8));
  bus.write32(PIO0_AT, 3 | (1 << 16) | (1 << 24));
  go(chip, 20);
  assert.equal(edges[0].length > 2, true);
  assert.deepEqual(edges[1], edges[0]);
});

test('a write of CTRL stops and starts machines of the neighbours on the same cycle', () => {
  const chip = machine();
  const { bus } = chip;
  const edges = [squareWave(chip, PIO0_AT, 2, pio.waitIrq(0, 6)), squareWave(chip, PIO2_AT, 27, pio.waitIrq(0, NEXT | 6))];
  go(chip, 40);
  // Machine 0 of the block before, which is PIO2, with its own: disabled.
  bus.write32(PIO0_AT, (1 << 16) | (1 << 25));
  const counts = edges.map(({ length }) => length);
  go(chip, 40);
  assert.deepEqual(edges.map(({ length }) => length), counts);
  assert.deepEqual([bus.read32(PIO0_AT), bus.read32(PIO2_AT)], [0, 0]);
  bus.write32(PIO0_AT, 1 | (1 << 16) | (1 << 24));
  go(chip, 40);
  assert.equal(edges[1].length > counts[1], true);
  assert.deepEqual([bus.read32(PIO0_AT), bus.read32(PIO2_AT)], [1, 1]);
});

test('the flags of other neighbours are not emulated, and are refused', () => {
  const chip = machine();
  squareWave(chip, PIO0_AT, 2, pio.irqSet(NEXT | 7));
  assert.throws(() => go(chip, 10), /only the last PIO block may name flags of a neighbour/);
});

test("PIO2's flags interrupt by its own line", () => {
  const { bus, core } = machine();
  bus.write32(PIO2_AT + 0x17c, 1 << 8);
  bus.write32(PIO2_AT + 0x34, 1);
  assert.equal(core.exceptions.pending[16 + 20], 1);
});

/** Calls a function of the ROM from code in RAM, with these arguments. */
function call(chip, code, ...args) {
  const { bus, core } = chip;
  const [first, second] = [...code].map((letter) => letter.charCodeAt(0));
  args.forEach((argument, index) => (core.registers[index] = argument));
  const run = (address) => {
    core.registers[LR] = CODE | 1;
    core.PC = address & ~1;
    go(chip, 40_000_000);
  };
  const lookup = bus.read16(0x16);
  const kept = Array.from(core.registers.subarray(0, 4));
  [core.registers[0], core.registers[1]] = [first | (second << 8), 4];
  core.registers[LR] = CODE | 1;
  core.PC = lookup & ~1;
  go(chip, 200);
  const address = core.registers[0];
  assert.notEqual(address, 0, code);
  kept.forEach((value, index) => (core.registers[index] = value));
  run(address);
}

test('flash is erased and programmed by the ROM, and shown again by what the ROM has left in the boot RAM', () => {
  const chip = machine();
  const { bus, flash } = chip;
  flash.bytes.fill(0x5a, 0x3f0000, 0x3f2000);
  bus.write32(DATA, 0x01020304);
  call(chip, 'IF');
  call(chip, 'EX');
  assert.throws(() => bus.read32(0x103f0000), /while it is being programmed/);
  call(chip, 'RE', 0x3f0000, 4096, 0x80000000 | 0, 0);
  call(chip, 'RP', 0x3f0000, DATA, 256);
  call(chip, 'FC');
  // Code in RAM copies the function there, as the HAL does.
  for (let offset = 0; offset < 256; offset += 4) bus.write32(DATA + 0x400 + offset, bus.read32(0x400e0000 + offset));
  chip.core.registers[LR] = CODE | 1;
  chip.core.PC = DATA + 0x400;
  go(chip, 20);
  assert.equal(bus.read32(0x103f0000), 0x01020304);
  assert.equal(bus.read32(0x103f1000), 0x5a5a5a5a);
});

test('a write empties a line of the cache by its place, and flash may be read past the cache', () => {
  const chip = machine();
  const { bus, cache, core, flash } = chip;
  const cost = (address) => {
    const since = core.cycles;
    bus.read32(address);
    return core.cycles - since;
  };
  flash.bytes.set([1, 2, 3, 4], 0x4008);
  // Two lines of the same set, one in each way.
  assert.deepEqual([cost(0x10000008), cost(0x10004008), cost(0x10000008), cost(0x10004008)], [cache.missCycles, cache.missCycles, 0, 0]);
  assert.equal(bus.read32(0x14004008), 0x04030201);
  assert.deepEqual([cost(0x14004008), cost(0x14004008)], [cache.missCycles, cache.missCycles]);
  bus.write8(0x18000008, 0);
  assert.deepEqual([cost(0x10000008), cost(0x10004008)], [0, cache.missCycles], 'the first way, which was filled last');
  bus.write8(0x18002008, 0);
  assert.deepEqual([cost(0x10004008), cost(0x10000008)], [0, cache.missCycles], 'the second way');
  bus.write8(0x18000010, 0);
  assert.deepEqual([cost(0x10000008), cost(0x10004008)], [0, 0], 'another set');
  assert.throws(() => bus.write8(0x1800000a, 0), /orders to the cache/);
  assert.throws(() => bus.read32(0x14400000), /there is no flash/);
  call(chip, 'IF');
  call(chip, 'EX');
  assert.throws(() => bus.read32(0x14004008), /while it is being programmed/);
});

test("the cache's counters count, and no register empties it", () => {
  const { bus, heard } = machine();
  const [FLUSH, CTR_HIT, CTR_ACC] = [0x400c8004, 0x400c800c, 0x400c8010];
  for (const counter of [CTR_HIT, CTR_ACC]) bus.write32(counter, 0);
  for (const address of [0x10000000, 0x10000000, 0x10000004]) bus.read32(address);
  assert.deepEqual([CTR_HIT, CTR_ACC].map((counter) => bus.read32(counter)), [1, 3]);
  bus.write32(FLUSH, 1);
  bus.read32(0x10000000);
  assert.equal(bus.read32(CTR_HIT), 2);
  assert.ok(heard.warnings.some((warning) => warning.startsWith('XIP_CTRL')), `${heard.warnings}`);
});

test("the chip's number stands in its one-time programmable memory, two rows a word and one a word", () => {
  const { bus } = machine();
  const words = (address, count) => Array.from({ length: count }, (_, index) => bus.read32(address + 4 * index) >>> 0);
  assert.deepEqual(words(0x40130000, 3), [0x832a1125, 0xe6605838, 0]);
  assert.deepEqual(words(0x40134000, 5), [0x1125, 0x832a, 0x5838, 0xe660, 0]);
});

test('a wrap of the PWM interrupts by the registers of the RP2350', () => {
  const chip = withInterrupts([B_SELF], { 8: 0 });
  const [CSR, TOP, INTR, IRQ0_INTE] = [0x400a808c, 0x400a809c, 0x400a80f4, 0x400a80f8];
  handler(chip, 8);
  chip.bus.write32(TOP, 99);
  chip.bus.write32((IRQ0_INTE + SET) | 0, 1 << 7);
  chip.bus.write32(CSR, 1);
  go(chip, 90);
  assert.deepEqual(marks(chip), []);
  go(chip, 60);
  assert.equal(marks(chip)[0], 8);
  assert.equal(chip.bus.read32(INTR), 1 << 7);
  chip.bus.write32(INTR, 1 << 7);
  assert.equal(chip.bus.read32(INTR), 0);
});

test('a slower core takes so many times the cycles, but waits for flash as long', () => {
  const cyclesOf = (coreFactor, code) => {
    const chip = machine(code, { coreFactor });
    const { core } = chip;
    const since = core.cycles;
    while (core.PC !== CODE + 2 * (code.length - 1)) assert.equal(chip.runCore(core, chip.bus, chip.clock, core.cycles + 1), null);
    return core.cycles - since;
  };
  const plain = [...Array(20).fill(NOP), B_SELF];
  assert.deepEqual([1, 1.6, 2.5].map((factor) => cyclesOf(factor, plain)), [20, 32, 50]);
  // ldr r0, [r1] from flash, which is not in the cache
  const loads = [...set(1, 0x10000000), 0x6808, B_SELF];
  const [once, twice] = [1, 2].map((factor) => cyclesOf(factor, loads));
  const { missCycles } = machine().cache;
  assert.equal(twice - missCycles, 2 * (once - missCycles));
});

test('reboot leads to BOOTSEL, and a function that the ROM lacks is 0', () => {
  const chip = machine();
  call(chip, 'RB', 0x0102, 10, 0, 0);
  assert.deepEqual(chip.heard.bootsel, [0, 0]);
  const { core, bus } = chip;
  [core.registers[0], core.registers[LR]] = [0x5a5a, CODE | 1];
  core.PC = bus.read16(0x16) & ~1;
  go(chip, 200);
  assert.equal(core.registers[0], 0);
});

test('an image starts by its mark, and one without it is refused', () => {
  const chip = machine();
  const view = new DataView(chip.flash.bytes.buffer);
  assert.throws(() => chip.boot(), /no image definition/);
  view.setUint32(0, STACK, true);
  view.setUint32(4, 0x10000201, true);
  view.setUint32(0x114, 0xffffded3, true);
  chip.boot();
  assert.deepEqual([chip.core.registers[SP], chip.core.registers[PC], chip.core.VTOR], [STACK, 0x10000200, 0x10000000]);
  const segment = { address: 0x10000000, bytes: chip.flash.bytes.subarray(0, 0x200) };
  assert.equal(isForRp2350([segment]), true);
  assert.equal(isForRp2350([{ ...segment, bytes: chip.flash.bytes.subarray(0, 0x100) }]), false);
});
