import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test from 'node:test';
import { Board } from '../src/board.mjs';
import { enterHardFault } from '../src/fault.mjs';
import { FLASH_BYTES } from '../src/flash.mjs';
import { UNIQUE_ID } from '../src/flash-command.mjs';
import { readFlashFile, writeFlashFile } from '../src/flash-file.mjs';
import { RAM, RomBench } from '../support/rom-bench.mjs';

const FLASH = 0x10000000;
const SSI = 0x18000000;
const DATA = RAM + 0x1000;
const NO_BLOCKS = 0x80000000 | 0;
const OPTIONS = { console: 'uart', startMm: [35, 40, 15], bounceMicros: 0, seed: 1, switches: {}, missFactor: null };

class FlashBench extends RomBench {
  rom(code, ...args) {
    return this.call(this.functionAt(code), ...args);
  }

  /** Prepares flash for commands. */
  open() {
    this.rom('IF');
    this.rom('EX');
  }

  close() {
    this.rom('FC');
    this.rom('CX');
  }

  program(offset, bytes) {
    this.bus.ram8.set(bytes, DATA - RAM);
    this.rom('RP', offset, DATA, bytes.length);
  }
}

const page = (byte) => new Uint8Array(256).fill(byte);

test('a page is programmed by clearing bits, and a sector erased, in the time the chip takes', () => {
  const bench = new FlashBench();
  bench.open();
  bench.program(0x1000, page(0xf0));
  assert.ok(Math.abs(bench.took - 125e6 * 0.0005) < 1e3, `${bench.took} cycles`);
  bench.program(0x1000, page(0x3c));
  bench.program(0x2000, [...page(1), ...page(2)]);
  bench.close();
  assert.equal(bench.bus.read32(FLASH + 0x1000), 0x30303030);
  assert.deepEqual([bench.bus.read8(FLASH + 0x20ff), bench.bus.read8(FLASH + 0x2100)], [1, 2]);
  bench.open();
  bench.rom('RE', 0x1000, 0x1000, NO_BLOCKS, 0);
  assert.ok(Math.abs(bench.took - 125e6 * 0.045) < 1e3, `${bench.took} cycles`);
  bench.close();
  assert.equal(bench.bus.read32(FLASH + 0x1000), -1);
  assert.equal(bench.bus.read8(FLASH + 0x2000), 1);
});

test('blocks are erased where they fit, sectors elsewhere, and nothing if there is nothing', () => {
  const bench = new FlashBench();
  bench.flash.bytes.fill(0, 0, 0x20000);
  bench.open();
  bench.rom('RE', 0xf000, 0x11000, 0x10000, 0xd8);
  assert.ok(Math.abs(bench.took - 125e6 * (0.15 + 0.045)) < 1e3, `${bench.took} cycles`);
  assert.equal(bench.flash.bytes.indexOf(0xff), 0xf000);
  assert.equal(bench.flash.bytes[0x1ffff], 0xff);
  bench.rom('RE', 0x3000, 0, NO_BLOCKS, 0);
  assert.ok(bench.took < 50);
  assert.throws(() => bench.rom('RE', 0, 0x10000, 0x10000, 0x99), /no erase command 0x99: it has 0x20, 0x52, 0xd8/);
  assert.throws(() => bench.rom('RE', 0, 0x10000, 0x10000, 0x52), /blocks of 65536 bytes by a command that erases 32768/);
});

test('what the ROM cannot do right is a fault that says so', () => {
  const bench = new FlashBench();
  assert.throws(() => bench.rom('RE', 0, 0x1000, NO_BLOCKS, 0), /while it is memory: call connect_internal_flash and flash_exit_xip/);
  bench.open();
  assert.throws(() => bench.rom('RE', 0x1800, 0x1000, NO_BLOCKS, 0), /offset 0x1800, which is no multiple of 4096/);
  assert.throws(() => bench.rom('RE', 0, 0x1234, NO_BLOCKS, 0), /flash_range_erase of 4660 bytes, which is no multiple of 4096/);
  assert.throws(() => bench.rom('RP', 0x80, DATA, 256), /offset 0x80, which is no multiple of 256/);
  assert.throws(() => bench.rom('RP', 0, DATA, 100), /flash_range_program of 100 bytes/);
  assert.throws(() => bench.rom('RE', FLASH, 0x1000, NO_BLOCKS, 0), /outside its 2097152 bytes \(offsets count from 0/);
});

test('flash is read as memory only between commands, and never written', () => {
  const bench = new FlashBench();
  const read = () => bench.bus.read32(FLASH);
  const hidden = /flash is read at 0x10000000 while it is being programmed/;
  assert.equal(read(), -1);
  assert.throws(() => bench.bus.write32(FLASH, 0), /a write to 0x10000000, which is read-only/);
  bench.open();
  assert.throws(read, hidden);
  assert.throws(() => bench.bus.fetch(FLASH), hidden);
  assert.throws(() => bench.bus.read8(0x13000000), /flash is read at 0x13000000/);
  assert.throws(() => bench.rom('RP', 0x1000, FLASH + 0x2000, 256), /flash is read at 0x10002000/);
  bench.program(0x1000, page(7));
  bench.rom('CX');
  // The ROM has left the chip selected by hand.
  assert.throws(read, hidden);
  bench.rom('FC');
  assert.equal(read(), -1);
});

test('a second stage that sets the interface up again shows flash', () => {
  const bench = new FlashBench();
  bench.open();
  bench.rom('FC');
  const set = (register, value) => bench.bus.write32(SSI + register, value);
  const [ctrlr0, ssienr, status, data] = [0x00, 0x08, 0x28, 0x60];
  set(ssienr, 0);
  set(ctrlr0, 0x70000);
  set(ssienr, 1);
  set(data, 0x35);
  assert.equal(bench.bus.read32(SSI + status) & 5, 4);
  assert.equal(bench.bus.read32(SSI + data), 2);
  assert.throws(() => bench.bus.read32(FLASH), /being programmed/);
  set(ssienr, 0);
  set(ctrlr0, 0x5f0300);
  assert.throws(() => bench.bus.read32(FLASH), /being programmed/);
  set(ssienr, 1);
  assert.equal(bench.bus.read32(FLASH), -1);
});

/** Sends a command as a function in RAM does that reads flash's identifiers, and reads some bytes. */
function answer(bench, command, count) {
  const [ctrlr0, ctrlr1, ssienr, status, data] = [0x00, 0x04, 0x08, 0x28, 0x60].map((register) => SSI + register);
  bench.open();
  bench.bus.write32(ssienr, 0);
  bench.bus.write32(ctrlr0, bench.bus.read32(ctrlr0) | 0x300);
  bench.bus.write32(ctrlr1, count - 1);
  bench.bus.write32(ssienr, 1);
  for (const byte of command) bench.bus.write8(data, byte);
  assert.throws(() => bench.bus.read32(FLASH), /flash is read at 0x10000000/);
  const bytes = Array.from({ length: count }, () => {
    assert.equal((bench.bus.read32(status) >> 3) & 1, 1);
    return bench.bus.read8(data);
  });
  bench.bus.write32(ssienr, 0);
  bench.bus.write32(ctrlr1, 0);
  bench.rom('CX');
  return bytes;
}

test('flash tells its unique identifier after four dummies, and nothing to other commands', () => {
  const bench = new FlashBench();
  const silence = [0, 0, 0, 0];
  assert.equal(UNIQUE_ID.length, 8);
  assert.deepEqual(answer(bench, [0x4b], 14), [...silence, ...UNIQUE_ID, 0, 0]);
  assert.deepEqual(answer(bench, [0x9f], 4), silence);
  assert.deepEqual(answer(bench, [0x4b, 0, 0, 0, 0], 8), UNIQUE_ID);
  assert.equal(bench.bus.read32(FLASH), -1);
});

test('an interrupt while flash is erased is served from RAM, and locks the core up with its vector in flash', () => {
  const bench = new FlashBench();
  bench.open();
  // movs r0, #1; lsls r0, #29; str r0, [r0]; bx lr
  bench.interruptIn(1e6, [0x2001, 0x0740, 0x6000, 0x4770]);
  bench.rom('RE', 0, 0x1000, NO_BLOCKS, 0);
  assert.equal(bench.bus.ram32[0], RAM);
  assert.ok(bench.took > 125e6 * 0.045, `${bench.took} cycles`);
  bench.interruptIn(1e6, [0x4770], FLASH + 0x100);
  let fault;
  assert.throws(() => bench.rom('RE', 0, 0x1000, NO_BLOCKS, 0), (error) => (fault = error) && /flash is read at 0x100001a8 while/.test(error.message));
  assert.throws(() => enterHardFault(bench.core, fault), /the core locked up: flash is read at 0x100001a8/);
});

test('DMA that reads flash in the midst of programming gets a bus error', () => {
  const bench = new FlashBench();
  bench.open();
  const [channel, always] = [0x50000000, 0x3f << 15];
  [FLASH, RAM + 0x3000, 1, always | (2 << 2) | 1].forEach((value, register) => bench.bus.write32(channel + 4 * register, value));
  bench.core.cycles += 20;
  bench.bus.catchUp();
  assert.equal(bench.bus.read32(channel + 0x0c) >>> 29, 7);
});

test('what lies outside the firmware outlives a reset, a power cut and the run', () => {
  const directory = mkdtempSync(join(tmpdir(), 'flash-'));
  const path = join(directory, 'kept.bin');
  const firmware = [
    { address: FLASH + 0x100, bytes: new Uint8Array(Uint32Array.of(RAM + 0x1000, FLASH + 0x201).buffer) },
    { address: FLASH + 0x200, bytes: new Uint8Array(Uint16Array.of(0xe7fe).buffer) },
  ];
  const board = new Board(firmware, OPTIONS, readFlashFile(path));
  board.flash.bytes[0x5000] = 0x42;
  board.chip.sram[0x100] = 1;
  board.powerCycle();
  board.run(board.clock.cycles + 1000);
  assert.equal(board.core.PC, FLASH + 0x200);
  assert.deepEqual([board.chip.sram[0x100], board.chip.flash[0x5000], board.powerCycles.length], [0, 0x42, 1]);
  writeFlashFile(path, board.flash.bytes, firmware);
  const kept = readFlashFile(path);
  assert.deepEqual([kept.length, kept[0x200], kept[0x5000]], [FLASH_BYTES, 0xff, 0x42]);
  const grown = [...firmware, { address: FLASH + 0x5800, bytes: Uint8Array.of(1) }];
  const next = new Board(grown, OPTIONS, kept);
  assert.deepEqual([next.chip.flash[0x201], next.chip.flash[0x5000], next.chip.flash[0x5800]], [0xe7, 0xff, 1]);
  rmSync(directory, { recursive: true });
});

test('a board that went to BOOTSEL runs no more, and its pins are free', () => {
  const address = new RomBench().functionAt('UB');
  // ldr r0, =address; blx r0
  const code = [0x4800, 0x4780, address, 0];
  const board = new Board(
    [
      { address: FLASH + 0x100, bytes: new Uint8Array(Uint32Array.of(RAM + 0x1000, FLASH + 0x201).buffer) },
      { address: FLASH + 0x200, bytes: new Uint8Array(Uint16Array.from(code).buffer) },
    ],
    OPTIONS,
  );
  while (board.bootsel === null && board.clock.cycles < 1000) board.run(1000);
  assert.ok(board.bootsel.t_ns > 0 && board.bootsel.t_ns < 200);
  board.run(125e6);
  assert.equal(board.clock.cycles, 125e6);
  assert.equal(board.faults.length, 0);
  assert.ok(board.clock.awakeCycles < 100);
});

test('a board leaves BOOTSEL by a watchdog restart, with what the ROM was told in its scratch registers', () => {
  const address = new RomBench().functionAt('UB');
  // ldr r0, LED; movs r1, #1; ldr r2, address; blx r2
  const code = [0x4801, 0x2101, 0x4a01, 0x4790, 0, 0x0200, address, 0];
  const board = new Board(
    [
      { address: FLASH + 0x100, bytes: new Uint8Array(Uint32Array.of(RAM + 0x1000, FLASH + 0x201).buffer) },
      { address: FLASH + 0x200, bytes: new Uint8Array(Uint16Array.from(code).buffer) },
    ],
    OPTIONS,
  );
  board.watchdog.scratch.set([7, 7, 7, 7]);
  while (board.bootsel === null && board.clock.cycles < 1000) board.run(1000);
  board.leaveBootsel();
  assert.deepEqual([board.bootsel, board.core.PC, board.resets.length], [null, FLASH + 0x200, 0]);
  assert.deepEqual([...board.watchdog.scratch.subarray(0, 4), board.watchdog.reason], [1 << 25, 1, 7, 7, 1]);
});
