/** Ways to make a core leave its program. Each writes below the stack, where nothing important is. */

const [R0, SP, LR, PC] = [0, 13, 14, 15];
const RAM_START = 0x20000000;
const FLASH_START = 0x10000000;
/** Where there is no memory. */
const NOWHERE = 0xf0000000;
const BRANCH_TO_ITSELF = 0xe7fe;
/** Room for what is written, a multiple of 8 because of the alignment of the stack. */
const ROOM_BYTES = 64;

/** A wild jump: the next fetch is from an address without memory. */
export function jumpAstray(core) {
  core.waiting = false;
  core.PC = NOWHERE;
}

/**
 * Loops with all interrupts masked.
 *
 * @returns {() => void} makes the core go on where it was; if it slept, it is awake
 */
export function hang(core, sram) {
  const at = belowStack(core);
  const { PM } = core;
  const pc = core.registers[PC];
  new DataView(sram.buffer, sram.byteOffset).setUint16(at - RAM_START, BRANCH_TO_ITSELF, true);
  core.waiting = false;
  core.PM = true;
  core.registers[PC] = at;
  return () => {
    core.PM = PM;
    core.interruptsUpdated = true;
    core.registers[PC] = pc;
  };
}

/**
 * Calls a Rust function that panics and takes only the location to report, like the one behind `Option::unwrap` on
 * `None`. The file's name is a byte of flash; line and column are 1.
 */
export function callPanic(core, sram, address) {
  const location = belowStack(core);
  const view = new DataView(sram.buffer, sram.byteOffset);
  [FLASH_START, 1, 1, 1].forEach((word, index) => view.setUint32(location - RAM_START + 4 * index, word, true));
  core.waiting = false;
  core.registers[SP] = location;
  core.registers[R0] = location;
  core.registers[LR] = NOWHERE | 1;
  core.registers[PC] = address & ~1;
}

function belowStack(core) {
  return ((core.registers[SP] >>> 0) - ROOM_BYTES) & ~7;
}
