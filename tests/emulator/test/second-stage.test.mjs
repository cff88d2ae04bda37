import assert from 'node:assert/strict';
import test from 'node:test';
import { Board } from '../src/board.mjs';
import { checksum } from '../src/second-stage.mjs';

const OPTIONS = { console: 'uart', startMm: [35, 40, 15], bounceMicros: 0, seed: 1, switches: {} };
const [FLASH, STACK, ENTRY] = [0x10000000, 0x20001000, 0x10000201];
const RAN_AT = 0x20041f00;
const STAGE_BYTES = 256;

const word = (value) => [value & 0xffff, value >>> 16];

/**
 * Sets the interface up for four lines at a quarter of the clock. Continues with the vector table unless LR contains an
 * address.
 */
const STAGE = [
  0x4b08, // ldr r3, =SSI
  0x2000, // movs r0, #0
  0x6098, // str r0, [r3, #8]: off
  0x2004, // movs r0, #4
  0x6158, // str r0, [r3, #0x14]
  0x4807, // ldr r0, =four lines, words, as an EEPROM
  0x6018, // str r0, [r3]
  0x4807, // ldr r0, =continuous read
  0x4a07, // ldr r2, =SPI_CTRLR0
  0x6010, // str r0, [r2]
  0x2001, // movs r0, #1
  0x6098, // str r0, [r3, #8]: on
  0x4806, // ldr r0, =vector table
  0x6801, // ldr r1, [r0]
  0x468d, // mov sp, r1
  0x6841, // ldr r1, [r0, #4]
  0x4708, // bx r1
  0xbf00,
  ...word(0x18000000),
  ...word(0x005f0300),
  ...word(0xa0002022),
  ...word(0x180000f4),
  ...word(0x10000100),
];

function stage(change = () => {}) {
  const bytes = new Uint8Array(STAGE_BYTES);
  bytes.set(new Uint8Array(Uint16Array.from(STAGE).buffer));
  new DataView(bytes.buffer).setUint32(STAGE_BYTES - 4, checksum(bytes.subarray(0, STAGE_BYTES - 4)), true);
  change(bytes);
  return bytes;
}

const firmware = (bytes) => [
  { address: FLASH, bytes },
  { address: FLASH + 0x100, bytes: new Uint8Array(Uint32Array.of(STACK, ENTRY).buffer) },
  { address: FLASH + 0x200, bytes: new Uint8Array(Uint16Array.of(0xe7fe).buffer) },
];

test('the checksum is that of the datasheet: a CRC-32 whose bits are not reflected', () => {
  assert.equal(checksum(new TextEncoder().encode('123456789')), 0x0376e6e7);
});

test('the second stage runs in RAM, sets up the interface to flash and starts the program', () => {
  const board = new Board(firmware(stage()), OPTIONS);
  const { core, flash, cache } = board;
  assert.deepEqual([core.PC, core.LR, core.SP, flash.readable], [RAN_AT, 0, RAN_AT, false]);
  board.run(1000);
  assert.deepEqual([core.PC, core.SP, flash.readable, board.faults.length], [ENTRY - 1, STACK, true, 0]);
  assert.deepEqual([...board.chip.sram.subarray(0x41f00, 0x42000)], [...stage()]);
  assert.equal(cache.missCycles, 20 * 4 + 8);
});

test('it runs again after a power cycle, from what flash holds then', () => {
  const board = new Board(firmware(stage()), OPTIONS);
  board.run(1000);
  board.powerCycle();
  assert.equal(board.core.PC, RAN_AT);
  board.flash.bytes[3] ^= 1;
  assert.throws(() => board.powerCycle(), /checksum/);
});

test('a wrong checksum stops the board as it stops the chip', () => {
  const broken = stage((bytes) => (bytes[0] ^= 1));
  assert.throws(() => new Board(firmware(broken), OPTIONS), /^Error: the second-stage bootloader in the first 256 bytes of flash has the checksum 0x[0-9a-f]{8}, but says 0x[0-9a-f]{8}: the ROM would not start it$/);
});

test('a program without a second stage finds flash as the one of the W25Q080 leaves it', () => {
  const board = new Board(firmware(stage()).slice(1), OPTIONS);
  assert.deepEqual([board.core.PC, board.core.SP, board.flash.readable, board.cache.missCycles], [ENTRY - 1, STACK, true, 48]);
});
