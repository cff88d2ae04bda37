import assert from 'node:assert/strict';
import test from 'node:test';
import { Board } from '../src/board.mjs';
import { readable, summary } from '../src/report.mjs';
import { RAM, RomBench } from '../support/rom-bench.mjs';

const FLASH = 0x10000000;
const CODE = FLASH + 0x400;
const [NOP, CPSID, CPSIE, BX_LR] = [0xbf00, 0xb672, 0xb662, 0x4770];
const NONE = { count: 0, misses: 0, pcs: [] };
/** A delay of three cycles per round. */
const DELAY = [0x3801, 0xd1fd, BX_LR];
const IN_RAM = RAM + 0x3000;

/** A chip with a program in flash that has finished its start. */
class WatchBench extends RomBench {
  constructor(...program) {
    super();
    this.watch = this.bus.watch;
    this.put(CODE, program);
    this.watch.firmwareSpoke();
    this.watch.senderSpoke();
  }

  put(address, halfwords) {
    this.bus.flash16.set(halfwords, (address - FLASH) / 2);
  }
}

test('it counts from what the sender sends to a firmware that has spoken', () => {
  const bench = new RomBench();
  const { watch } = bench.bus;
  watch.senderSpoke();
  assert.equal(watch.counting, false);
  watch.firmwareSpoke();
  assert.equal(watch.counting, false);
  watch.senderSpoke();
  assert.equal(watch.counting, true);
  watch.attach(bench.core);
  watch.senderSpoke();
  assert.equal(watch.counting, false);
});

test('instructions from flash with interrupts masked, each with its place', () => {
  const bench = new WatchBench(NOP, CPSID, NOP, NOP, NOP, CPSIE, NOP, BX_LR);
  bench.call(CODE);
  bench.call(CODE);
  const { flash_in_critical_sections: found, flash_in_handlers: handlers, longest_masked_cycles: longest, longest_masked_pc: pc } = bench.watch.summary();
  assert.deepEqual(found, { count: 8, misses: 2, pcs: ['0x10000404', '0x10000406', '0x10000408', '0x1000040a'] });
  assert.deepEqual(handlers, NONE);
  assert.deepEqual([longest, pc], [4 + 2 * bench.cache.missCycles, '0x10000402']);
});

test('a wide instruction is one, and the cache is asked for words as ever', () => {
  // msr primask, r0; dmb; movs r0, #0; msr primask, r0; bx lr
  const bench = new WatchBench(0xf380, 0x8810, 0xf3bf, 0x8f5f, 0x2000, 0xf380, 0x8810, BX_LR);
  const { accesses } = bench.cache.counts;
  bench.call(CODE, 1);
  assert.equal(bench.cache.counts.accesses - accesses, 4);
  const { flash_in_critical_sections: found, longest_masked_pc: pc } = bench.watch.summary();
  assert.deepEqual([found.count, found.misses, pc], [3, 2, '0x10000400']);
  assert.deepEqual(found.pcs, ['0x10000404', '0x10000408', '0x1000040a']);
});

test('handlers: their code, what they read and their vectors', () => {
  const bench = new WatchBench();
  bench.load(IN_RAM, DELAY);
  // ldr r0, [pc, #0]; bx lr
  bench.put(CODE, [0x4800, BX_LR, 0x5678, 0x1234]);
  bench.interruptIn(100, [NOP], FLASH + 0x2000);
  bench.bus.flash32[(0x2000 >> 2) + 16 + 26] = CODE | 1;
  bench.call(IN_RAM, 100);
  bench.core.enabledInterrupts = 0;
  const { flash_in_handlers: code, flash_in_handlers_data: data, flash_in_critical_sections: sections } = bench.watch.summary();
  assert.equal(code.count % 2, 0);
  assert.deepEqual(code.pcs, ['0x10000400', '0x10000402']);
  assert.deepEqual(data.pcs, ['0x10000400', '0x100020a8']);
  assert.deepEqual([code.misses, data.misses], [1, 2]);
  assert.deepEqual(sections, NONE);
});

test('code in RAM and in ROM is none of it, but data in flash is', () => {
  const bench = new WatchBench();
  // cpsid i; ldr r0, [r0]; cpsie i; bx lr
  bench.load(IN_RAM, [CPSID, 0x6800, CPSIE, BX_LR]);
  bench.call(IN_RAM, RAM);
  bench.call(IN_RAM, FLASH + 0x800);
  const { flash_in_critical_sections: code, flash_in_critical_sections_data: data } = bench.watch.summary();
  assert.deepEqual([code, data], [NONE, { count: 1, misses: 1, pcs: ['0x20003002'] }]);
});

test('the time masked leaves out the ROM that programs flash', () => {
  const bench = new WatchBench();
  // push {r4, lr}; mov r4, r3; cpsid i; blx r4; cpsie i; pop {r4, pc}
  bench.load(IN_RAM, [0xb510, 0x461c, CPSID, 0x47a0, CPSIE, 0xbd10]);
  const open = ['IF', 'EX'].map((code) => bench.functionAt(code));
  const erase = bench.functionAt('RE');
  for (const address of open) bench.call(address);
  bench.bus.registers[12] = 0;
  // r3 is the function, and the block's command, which fits nowhere.
  bench.call(IN_RAM, 0x1000, 0x1000, 0x80000000 | 0, erase);
  assert.ok(bench.took > 125e6 * 0.045);
  const { longest_masked_cycles: longest, longest_masked_pc: pc } = bench.watch.summary();
  assert.ok(longest < 50, `${longest} cycles`);
  assert.equal(pc, '0x20003004');
});

test('what comes from flash around the ROM that programs it does not count', () => {
  const { watch, core } = new WatchBench();
  const masked = (within) => {
    core.PM = true;
    watch.update();
    watch.fetched(CODE, true);
    within();
    core.PM = false;
    watch.update();
  };
  masked(() => watch.exclude(1000));
  assert.deepEqual(watch.summary().flash_in_critical_sections, NONE);
  masked(() => {});
  assert.equal(watch.summary().flash_in_critical_sections.count, 1);
});

test('the most frequent sixteen places are shown', () => {
  const bench = new WatchBench(CPSID, ...Array(20).fill(NOP), 0x3801, 0xd1fd, CPSIE, BX_LR);
  bench.call(CODE, 3);
  const { count, pcs } = bench.watch.summary().flash_in_critical_sections;
  assert.equal(count, 20 + 3 + 3 + 1);
  assert.equal(pcs.length, 16);
  assert.deepEqual(pcs.slice(0, 3), ['0x1000042a', '0x1000042c', '0x10000402']);
});

/** A board whose firmware consists of a few instructions. */
function boardOf(halfwords, options) {
  const bytes = (array) => new Uint8Array(array.buffer);
  const firmware = [
    { address: FLASH + 0x100, bytes: bytes(Uint32Array.of(RAM + 0x1000, CODE | 1)) },
    { address: CODE, bytes: bytes(Uint16Array.from(halfwords)) },
  ];
  return new Board(firmware, { console: 'uart', startMm: [35, 40, 15], bounceMicros: 0, seed: 1, switches: {}, ...options });
}

test('a board counts anew after a reset, when it has been spoken to', () => {
  const board = boardOf([0xe7fe]);
  board.cable.listener.onData([0x47]);
  board.send([]);
  assert.equal(board.watch.counting, false);
  board.send([0x3f]);
  assert.equal(board.watch.counting, true);
  board.powerCycle();
  board.send([0x3f]);
  assert.equal(board.watch.counting, false);
});

test('the summary has it all', () => {
  const console = { lastStatus: null, alarm: null, sent: [] };
  // cpsid i; b to itself
  const board = boardOf([CPSID, 0xe7fe]);
  board.cable.listener.onData([0x47]);
  board.send([0x3f]);
  board.run(148);
  const result = summary(board, console, null);
  // One fetch of the first word, then 49 rounds of two cycles with one fetch each.
  assert.deepEqual(result.flash_cache, { accesses: 50, hits: 49, misses: 1, stall_cycles: 48, miss_cycles: 48 });
  assert.deepEqual(result.flash_in_critical_sections, { count: 50, misses: 0, pcs: ['0x10000402'] });
  assert.deepEqual([result.flash_in_handlers, result.flash_in_handlers_data, result.flash_in_critical_sections_data], [NONE, NONE, NONE]);
  assert.deepEqual([result.longest_masked_cycles, result.longest_masked_pc], [100, '0x10000400']);
  assert.match(readable(result), /Flash {8}50 words read, 2\.0 % not in the cache at 48 cycles each; the core waited 3\d\.\d % of its time awake/);
  assert.match(readable(result), /Masked {7}50 instructions from flash \(most at 0x10000402\), 0 reads of it\n {13}for 100 cycles at most, from pc 0x10000400/);
  const ideal = boardOf([0xe7fe], { missFactor: null });
  ideal.run(100);
  assert.match(readable(summary(ideal, console, null)), /Flash {8}reads like RAM/);
});

test('a handler reads an even program counter, whatever bit 0 of its vector is', () => {
  const bench = new WatchBench();
  bench.load(IN_RAM, DELAY);
  // mov r0, pc; movs r1, #1; lsls r1, #29; str r0, [r1]; bx lr
  bench.interruptIn(100, [0x4678, 0x2101, 0x0749, 0x6008, BX_LR]);
  bench.call(IN_RAM, 100);
  assert.equal(bench.bus.ram32[0], RAM + 0x300 + 4);
});

test('a core that sleeps with interrupts masked holds nothing up', () => {
  const { core, watch } = new WatchBench();
  // A sleep before does not count either.
  core.cycles += 500;
  watch.clock.asleepCycles += 500;
  core.PM = true;
  watch.update();
  core.cycles += 1_000;
  watch.clock.asleepCycles += 990;
  core.PM = false;
  watch.update();
  assert.equal(watch.summary().longest_masked_cycles, 10);
});
