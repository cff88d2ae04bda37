import assert from 'node:assert/strict';
import test from 'node:test';
import { MachineClock } from '../src/clock.mjs';
import { FlashCounts, XipCache } from '../src/xip-cache.mjs';
import { DMA } from '../support/pio-bench.mjs';
import { RAM, RomBench } from '../support/rom-bench.mjs';

const FLASH = 0x10000000;
const [NO_ALLOCATE, NO_LOOK_UP, NEITHER] = [0x11000000, 0x12000000, 0x13000000];
const [CTRL, FLUSH, STAT, CTR_HIT, CTR_ACC] = [0x14000000, 0x14000004, 0x14000008, 0x1400000c, 0x14000010];
const [CTRLR0, SSIENR, BAUDR, SPI_CTRLR0] = [0x18000000, 0x18000008, 0x18000014, 0x180000f4];
const [NOP, BX_LR] = [0xbf00, 0x4770];
/** The distance between two lines of the same set. */
const WAY_BYTES = 8192;
/** 8 clocks of address and mode bits, 4 of waiting, 8 of data, 2 cycles each; and the overhead. */
const MISS = (8 + 4 + 8) * 2 + 8;

/** A cache whose readers wait as long as the cache demands. */
class CacheBench {
  constructor(missFactor = 1) {
    this.clock = new MachineClock();
    this.cache = new XipCache(this.clock, new FlashCounts(), missFactor);
    this.cache.setWordCycles(MISS - 8);
  }

  read(...addresses) {
    return addresses.map((address) => {
      const wait = this.cache.read(address);
      this.clock.core.cycles += wait;
      return wait;
    });
  }
}

test('a word costs the miss once, and its neighbour in the line a miss of its own', () => {
  const bench = new CacheBench();
  assert.equal(MISS, 48);
  assert.deepEqual(bench.read(FLASH, FLASH, FLASH + 3, FLASH + 4, FLASH, FLASH + 4), [MISS, 0, 0, MISS, 0, 0]);
  const { accesses, hits, misses, stallCycles } = bench.cache.counts;
  assert.deepEqual([accesses, hits, misses, stallCycles], [6, 4, 2, 2 * MISS]);
});

test('a set holds two lines, and the one used longer ago goes', () => {
  const bench = new CacheBench();
  const [one, two, three] = [FLASH + 0x40, FLASH + 0x40 + WAY_BYTES, FLASH + 0x40 + 5 * WAY_BYTES];
  assert.deepEqual(bench.read(one, two, one, two), [MISS, MISS, 0, 0]);
  assert.deepEqual(bench.read(one, three, one, three, two), [0, MISS, 0, 0, MISS]);
  // It replaces `one`. The replaced line loses both its words.
  assert.deepEqual(bench.read(three + 4, one + 4, one, three), [MISS, MISS, MISS, 0]);
});

test('all of 16 KiB fits, and no more', () => {
  const bench = new CacheBench();
  const words = Array.from({ length: 4096 }, (_, index) => FLASH + 4 * index);
  bench.read(...words);
  assert.ok(bench.read(...words).every((wait) => wait === 0));
  bench.read(FLASH + 16384);
  assert.deepEqual(bench.read(FLASH, FLASH + WAY_BYTES, FLASH + 8), [MISS, MISS, 0]);
});

test('the aliases look up or not, and keep what they bring or not', () => {
  const bench = new CacheBench();
  assert.deepEqual(bench.read(NO_ALLOCATE, NO_ALLOCATE, FLASH, NO_ALLOCATE), [MISS, MISS, MISS, 0]);
  assert.deepEqual(bench.read(NO_LOOK_UP + 8, NO_LOOK_UP + 8, FLASH + 8), [MISS, MISS, 0]);
  assert.deepEqual(bench.read(NEITHER + 16, NEITHER + 16, FLASH + 16, NEITHER + 16), [MISS, MISS, MISS, MISS]);
});

test('what a miss costs can be multiplied, and be nothing', () => {
  assert.deepEqual(new CacheBench(2.5).read(FLASH, FLASH), [2.5 * MISS, 0]);
  const free = new CacheBench(0);
  assert.deepEqual([...free.read(FLASH), free.cache.counts.misses], [0, 1]);
  const ideal = new CacheBench(null);
  ideal.cache.flush();
  assert.deepEqual([...ideal.read(FLASH), ideal.cache.counts.accesses], [0, 0]);
});

test('a flush forgets all, and all wait until it is over', () => {
  const bench = new RomBench();
  bench.bus.read32(FLASH);
  bench.bus.write32(FLUSH, 1);
  assert.equal(bench.bus.read32(STAT), 2);
  const started = bench.core.cycles;
  bench.bus.read32(FLASH);
  assert.equal(bench.core.cycles - started, 1024 + MISS);
  assert.equal(bench.bus.read32(STAT), 3);
  bench.bus.write32(FLUSH, 1);
  bench.core.cycles += 1000;
  assert.equal(bench.bus.read32(FLUSH), 0);
  assert.equal(bench.core.cycles - started, 2048 + MISS);
  assert.equal(bench.bus.read32(STAT), 3);
});

test('disabled or without power it has nothing, and enabled again what it had', () => {
  const bench = new RomBench();
  const cost = (address) => {
    const before = bench.core.cycles;
    bench.bus.read32(address);
    return bench.core.cycles - before;
  };
  assert.deepEqual([bench.bus.read32(CTRL), cost(FLASH), cost(FLASH)], [3, MISS, 0]);
  bench.bus.write32(CTRL, 2);
  assert.deepEqual([bench.bus.read32(CTRL), cost(FLASH), cost(FLASH), cost(FLASH + 8)], [2, MISS, MISS, MISS]);
  bench.bus.write32(CTRL, 1 | 8);
  assert.deepEqual([bench.bus.read32(CTRL), cost(FLASH)], [8, MISS]);
  bench.bus.write32(CTRL, 3);
  assert.deepEqual([cost(FLASH), cost(FLASH + 8)], [0, MISS]);
});

test('its counters count, are cleared by any write, and go no further than they can', () => {
  const bench = new RomBench();
  for (const address of [FLASH, FLASH, NEITHER, FLASH + 4, FLASH]) bench.bus.read32(address);
  assert.deepEqual([bench.bus.read32(CTR_ACC), bench.bus.read32(CTR_HIT)], [5, 2]);
  bench.bus.write32(CTR_HIT, 7);
  bench.bus.read32(FLASH);
  assert.deepEqual([bench.bus.read32(CTR_ACC), bench.bus.read32(CTR_HIT)], [6, 1]);
  bench.bus.write32(CTR_ACC, 0);
  for (const alias of [NO_ALLOCATE, NO_LOOK_UP, NEITHER]) bench.bus.read32(alias);
  assert.deepEqual([bench.bus.read32(CTR_ACC), bench.bus.read32(CTR_HIT)], [3, 2]);
  bench.cache.counts.values[0] += 2 ** 33;
  assert.deepEqual([bench.bus.read32(CTR_ACC), bench.bus.read32(CTR_HIT)], [-1, -1]);
});

test('a program in RAM measures a hit, a new line and a read past the cache, by the factor of a miss', () => {
  for (const factor of [1, 2]) {
    const bench = new RomBench();
    bench.cache.missFactor = factor;
    bench.flash.update();
    // ldr r3, [r0]; adds r0, r1; subs r2, #1; bne to the first; bx lr
    const loop = [0x6803, 0x1840, 0x3a01, 0xd1fb, BX_LR];
    bench.load(RAM + 0x3000, loop);
    const perRead = (from, stride) => {
      bench.bus.write32(FLUSH, 1);
      bench.bus.read32(FLUSH);
      bench.call(RAM + 0x3000, from, stride, 64);
      return bench.took / 64;
    };
    const [nothing, hits, lines, uncached] = [perRead(RAM, 4), perRead(FLASH, 0), perRead(FLASH, 8), perRead(NEITHER, 0)].map((each, _, [ram]) => each - ram);
    assert.deepEqual([nothing, hits, lines, uncached], [0, (factor * MISS) / 64, factor * MISS, factor * MISS]);
    // Both words of a line cost as much as two lines do.
    assert.equal(perRead(FLASH, 4) - perRead(RAM, 4), factor * MISS);
  }
});

test('a miss takes what the interface to flash takes as it is set up', () => {
  const bench = new RomBench();
  const setUp = (control, transfer, divider) => {
    [[SSIENR, 0], [CTRLR0, control], [SPI_CTRLR0, transfer], [BAUDR, divider], [SSIENR, 1]].forEach(([register, value]) => bench.bus.write32(register, value));
    return bench.cache.missCycles;
  };
  assert.equal(bench.cache.missCycles, MISS);
  // Command 03 over one line: 8 + 24 + 32 clocks; EB with its command: 8 + 8 + 4 + 8; 3B, of whose address one line carries all.
  assert.equal(setUp(0x1f0300, 0x03000218, 4), 64 * 4 + 8);
  assert.equal(setUp(0x5f0300, 0xeb002221, 2), 28 * 2 + 8);
  assert.equal(setUp(0x3f0300, 0x3b004218, 2), (8 + 24 + 8 + 16) * 2 + 8);
  assert.equal(setUp(0x5f0300, 0xa0002022, 6), 20 * 6 + 8);
  bench.bus.write32(BAUDR, 0);
  assert.throws(() => bench.bus.read32(FLASH), /flash is read at 0x10000000/);
  bench.call(bench.functionAt('FC'));
  bench.call(bench.functionAt('CX'));
  assert.equal(bench.cache.missCycles, 64 * 6 + 8);
});

/** A chip with a program in flash, followed by a return. */
class ProgramBench extends RomBench {
  constructor(program, at = FLASH + 0x400) {
    super();
    this.at = at;
    this.put(at, program);
    this.misses = 0;
  }

  put(address, halfwords) {
    this.bus.flash16.set(halfwords, (address - FLASH) / 2);
  }

  /** @returns {number[]} accesses, misses and cycles of a run */
  runs(...args) {
    const { counts } = this.cache;
    const [accesses, misses] = [counts.accesses, counts.misses];
    this.call(this.at, ...args);
    return [counts.accesses - accesses, counts.misses - misses, this.took];
  }
}

test('code is fetched by words, and once more where a branch leads', () => {
  const straight = new ProgramBench([NOP, NOP, NOP, NOP, NOP, BX_LR]);
  const [accesses, misses, cold] = straight.runs();
  const [, , warm] = straight.runs();
  assert.deepEqual([accesses, misses, cold - warm], [3, 3, 3 * MISS]);
  assert.deepEqual(straight.runs().slice(0, 2), [3, 0]);
  // From the second half of a word; and a loop of three rounds within a word (subs r0, #1; bne) after another word.
  assert.deepEqual(new ProgramBench([NOP, BX_LR], FLASH + 0x402).runs().slice(0, 2), [2, 2]);
  assert.deepEqual(new ProgramBench([NOP, NOP, 0x3801, 0xd1fd, BX_LR]).runs(3).slice(0, 2), [1 + 3 + 1, 3]);
});

test('a wide instruction across two words is one of each', () => {
  // push {lr}; bl to the last; nop; pop {pc}; bx lr: both halves' words, the last, and back into the second's.
  const bench = new ProgramBench([0xb500, 0xf000, 0xf802, NOP, 0xbd00, BX_LR]);
  assert.deepEqual(bench.runs().slice(0, 2), [5, 3]);
});

test('a load that misses takes 50 cycles, as was measured on hardware', () => {
  // ldr r0, [r0]; bx lr
  const bench = new RomBench();
  const code = RAM + 0x3000;
  bench.load(code, [0x6800, BX_LR]);
  bench.call(code, FLASH + 0x800);
  const cold = bench.took;
  bench.call(code, FLASH + 0x800);
  assert.deepEqual([cold - bench.took + 2, bench.core.registers[0]], [50, 0xffffffff]);
});

test('code and data of every alias are read from the same flash', () => {
  const bench = new ProgramBench([0x6800, BX_LR]);
  bench.put(FLASH + 0x800, [0x5678, 0x1234]);
  for (const alias of [FLASH, NO_ALLOCATE, NO_LOOK_UP, NEITHER]) {
    assert.equal(bench.call(bench.at + alias - FLASH, alias + 0x800), 0x12345678);
    assert.throws(() => bench.bus.write32(alias, 0), /which is read-only/);
  }
  assert.deepEqual([bench.bus.read16(NEITHER + 0x802), bench.bus.read8(NO_ALLOCATE + 0x801)], [0x1234, 0x56]);
});

test('the ROM reads flash through the cache, and so does an exception its vector', () => {
  const bench = new ProgramBench([0x2001]);
  const { counts } = bench.cache;
  bench.call(bench.functionAt('MC'), RAM + 0x3000, FLASH + 0x1000, 64);
  assert.equal(counts.misses, 16);
  // subs r0, #1; bne to it
  bench.load(RAM + 0x3000, [0x3801, 0xd1fd, BX_LR]);
  bench.interruptIn(100, [BX_LR], FLASH + 0x2000);
  bench.bus.flash32[(0x2000 >> 2) + 16 + 26] = (RAM + 0x300) | 1;
  bench.call(RAM + 0x3000, 100);
  assert.equal(counts.misses, 17);
});

const [READ, WRITE, COUNT, TRIGGER] = [DMA, DMA + 4, DMA + 8, DMA + 12];
/** A transfer of words: both addresses increment, unpaced, chained to itself. */
const COPY = (63 << 15) | (1 << 5) | (1 << 4) | (2 << 2) | 1;

function copyByDma(bench, words) {
  [[READ, FLASH + 0x1000], [WRITE, RAM + 0x3000], [COUNT, words], [TRIGGER, COPY]].forEach(([register, value]) => bench.bus.write32(register, value));
}

test('DMA from flash waits for each word, once', () => {
  const bench = new ProgramBench([NOP]);
  bench.bus.flash32.set([1, 2, 3, 4], 0x1000 / 4);
  copyByDma(bench, 4);
  const busy = () => (bench.bus.read32(TRIGGER) >>> 24) & 1;
  const started = bench.core.cycles;
  while (busy()) bench.core.cycles += 1;
  assert.deepEqual([...bench.bus.ram32.slice(0xc00, 0xc04)], [1, 2, 3, 4]);
  // Four cycles to the first read, then a wait and a cycle for each word.
  assert.equal(bench.core.cycles - started, 4 + 4 * MISS + 3);
  const { accesses, misses } = bench.cache.counts;
  assert.deepEqual([accesses, misses], [4, 4]);
});

test('the core waits for flash while it is read for the DMA', () => {
  const bench = new ProgramBench([NOP]);
  bench.bus.read32(FLASH);
  copyByDma(bench, 1);
  bench.core.cycles += 10;
  bench.bus.catchUp();
  const before = bench.core.cycles;
  bench.bus.read32(FLASH);
  assert.equal(bench.core.cycles - before, MISS - 6);
  bench.bus.read32(FLASH);
  assert.equal(bench.core.cycles - before, MISS - 6);
});
