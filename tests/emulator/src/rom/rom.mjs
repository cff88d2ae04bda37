import { Fault } from '../fault.mjs';
import { BITS } from './bits.mjs';
import { DOUBLES } from './doubles.mjs';
import { FLASH, FLASH_LOOPS } from './flash.mjs';
import { FLOATS } from './floats.mjs';
import { RomImage } from './image.mjs';
import { MEMORY } from './memory.mjs';

const NO_FUNCTION = 0xff;
/** A stub takes one cycle for its trap, three for each round of its delay except two for the last, and two to return. */
const [STUB_CYCLES, TURN_CYCLES] = [2, 3];
/** An estimate: the RP2350's search in its table. */
const LOOKUP_CYCLES = 60;

/** The traps of functions that program flash. The firmware is not responsible for their time. */
const flashTraps = new Set();
/** The effect of each trap, and the cycles of its whole function. Functions whose cycles vary return them. */
const actions = [];
const cycles = [];
const image = build();

/**
 * Carries out a function of the ROM at its first instruction, a trap, and sets the number of rounds of its delay. So
 * the function takes its cycles from entry to return, and interrupts can come between real instructions.
 */
export function callRom(number, core, bus, r) {
  const act = actions[number];
  if (act === undefined) throw new Fault('there is no function of the emulated bootrom here');
  const varying = act(r, bus);
  const whole = cycles[number] || varying || 0;
  const left = whole - STUB_CYCLES;
  const turns = Math.max(1, Math.floor(left / TURN_CYCLES));
  r[3] = turns;
  core.cycles += Math.max(0, left - turns * TURN_CYCLES);
  if (flashTraps.has(number)) bus.watch.exclude(whole);
}

/** Writes the ROM to its place in the chip. */
export function loadRom(chip) {
  new Uint16Array(chip.bootrom.buffer).set(image.halfwords);
}

function build() {
  const rom = new RomImage(NO_FUNCTION);
  rom.setFunctions([
    ...[...BITS, ...MEMORY].map(([code, , count, act]) => [code, addFunction(rom, count, act)]),
    ...addFlash(rom),
    ['UB', rom.addEnd(addTrap(0, (r, bus) => bus.chip.onBootsel(r[0], r[1])))],
  ]);
  const start = rom.end;
  const floats = addSoftTable(rom, FLOATS);
  const doubles = addSoftTable(rom, DOUBLES);
  const end = rom.end;
  const copyright = rom.addText('A stand-in for the bootrom of the RP2040, by the Isostep project');
  const revision = rom.add([0, 0]);
  rom.setData(Object.entries({ CR: copyright, GR: revision, FS: start, SF: floats, SD: doubles, FE: end }));
  return rom;
}

/** Adds the functions of flash, which all chips have. @returns {[string, number][]} their codes and addresses */
export function addFlash(rom) {
  return [
    ...FLASH.map(([code, , count, act]) => [code, rom.addStub(addFlashTrap(count, act))]),
    ...FLASH_LOOPS.map(({ code, check, step, count }) => [code, rom.addLoop(addFlashTrap(0, check), addFlashTrap(0, step), count)]),
  ];
}

/** Adds the function that looks the code in r0 up. @returns {number} its address */
export function addLookup(rom, addressOf) {
  return rom.addStub(addTrap(LOOKUP_CYCLES, (r) => void (r[0] = addressOf(r[0] & 0xffff))));
}

/** Adds the trap of a function that never returns. @returns {number} its number */
export function addEndTrap(act) {
  return addTrap(0, act);
}

/** @returns {number} the trap's number */
function addTrap(count, act) {
  cycles.push(count);
  return actions.push(act) - 1;
}

function addFlashTrap(count, act) {
  const number = addTrap(count, act);
  flashTraps.add(number);
  return number;
}

function addFunction(rom, count, act) {
  return rom.addStub(addTrap(count, act));
}

function addSoftTable(rom, functions) {
  return rom.addPointers(new Map(functions.map(([offset, , count, act]) => [offset, addFunction(rom, count, act)])));
}
