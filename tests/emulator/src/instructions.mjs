import { readCycles, writeCycles } from './bus.mjs';
import { addWithCarry } from './alu.mjs';
import { ROM_BYTES } from './rom/image.mjs';
import { callRom } from './rom/rom.mjs';
import { extended, reversed } from './thumb.mjs';

const [SP, LR, PC] = [13, 14, 15];
/** An estimate: the eight words of the frame and a refill of the pipeline. */
const EXCEPTION_RETURN_CYCLES = 10;
const [CPSID, CPSIE, WFE, WFI, SEV, NOP, YIELD] = [0xb672, 0xb662, 0xbf20, 0xbf30, 0xbf40, 0xbf00, 0xbf10];

/** ADD, CMP and MOV on all sixteen registers; BX and BLX. */
export function highRegisters(core, r, op) {
  const source = (op >> 3) & 15;
  const target = ((op >> 4) & 8) | (op & 7);
  const value = source === PC ? r[PC] + 2 : r[source];
  switch ((op >> 8) & 3) {
    case 0:
      return writeRegister(core, r, target, (target === PC ? r[PC] + 2 : r[target]) + value);
    case 1:
      addWithCarry(core, r[target], ~value, 1);
      return;
    case 2:
      return writeRegister(core, r, target, value);
    default:
      core.cycles += 1;
      if (op & 0x80) {
        r[LR] = r[PC] | 1;
        r[PC] = value & ~1;
      } else {
        jump(core, value);
      }
  }
}

function writeRegister(core, r, target, value) {
  if (target === PC) core.cycles += 1;
  r[target] = target === PC ? value & ~1 : target === SP ? value & ~3 : value;
}

/** BX and POP: to an address, or out of an exception. */
function jump(core, address) {
  if (address >>> 28 === 0xf) core.cycles += EXCEPTION_RETURN_CYCLES;
  core.BXWritePC(address);
}

/** Loads and stores with a register as the offset, 0x5000 to 0x5fff. */
export function loadStoreRegister(core, bus, r, op) {
  const address = (r[(op >> 6) & 7] + r[(op >> 3) & 7]) | 0;
  const target = op & 7;
  const kind = (op >> 9) & 7;
  core.cycles += kind < 3 ? writeCycles(address) : readCycles(address);
  switch (kind) {
    case 0:
      return bus.write32(address, r[target]);
    case 1:
      return bus.write16(address, r[target]);
    case 2:
      return bus.write8(address, r[target]);
    case 3:
      r[target] = (bus.read8(address) << 24) >> 24;
      return;
    case 4:
      r[target] = bus.read32(address);
      return;
    case 5:
      r[target] = bus.read16(address);
      return;
    case 6:
      r[target] = bus.read8(address);
      return;
    default:
      r[target] = (bus.read16(address) << 16) >> 16;
  }
}

/** 0xb000 to 0xbfff: the stack, extensions, byte reversal, interrupts masks and hints. */
export function miscellaneous(core, bus, r, op) {
  switch ((op >> 8) & 15) {
    case 0:
      r[SP] += op & 0x80 ? -((op & 0x7f) << 2) : (op & 0x7f) << 2;
      return;
    case 2:
      r[op & 7] = extended(r[(op >> 3) & 7], (op >> 6) & 3);
      return;
    case 4:
    case 5:
      return push(core, bus, r, op & 0x1ff);
    case 6:
      return maskInterrupts(core, bus, op);
    case 10:
      r[op & 7] = reversed(r[(op >> 3) & 7], (op >> 6) & 3);
      return;
    case 12:
    case 13:
      return pop(core, bus, r, op & 0x1ff);
    case 15:
      return hint(core, r, op);
    case 14: // BKPT: in the ROM, one of its functions
      return r[PC] >>> 0 < ROM_BYTES ? callRom(op & 0xff, core, bus, r) : slowly(core, r);
    default:
      return slowly(core, r);
  }
}

function push(core, bus, r, list) {
  let address = r[SP];
  for (let index = 8; index >= 0; index--) {
    if (list & (1 << index)) {
      address -= 4;
      bus.write32(address, r[index === 8 ? LR : index]);
      core.cycles += 1;
    }
  }
  r[SP] = address;
}

function pop(core, bus, r, list) {
  let address = r[SP];
  for (let index = 0; index < 8; index++) {
    if (list & (1 << index)) {
      r[index] = bus.read32(address);
      address += 4;
      core.cycles += 1;
    }
  }
  if (list & 0x100) {
    r[SP] = address + 4;
    core.cycles += 3;
    jump(core, bus.read32(address));
  } else {
    r[SP] = address;
  }
}

function maskInterrupts(core, bus, op) {
  core.PM = op === CPSID;
  bus.watch.update();
  if (op === CPSIE) core.interruptsUpdated = true;
}

function hint(core, r, op) {
  switch (op) {
    case WFE:
      core.cycles += 1;
      core.sleep.waitForEvent();
      return;
    case WFI:
      core.cycles += 1;
      core.sleep.waitForInterrupt();
      return;
    case SEV: // rp2040js only logs it: an executor that pends itself would sleep for ever
      core.eventRegistered = true;
      return;
    case NOP:
    case YIELD:
      return;
    default:
      slowly(core, r);
  }
}

/** 0xe800 to 0xffff: BL here, the rest (MRS, MSR, barriers) by rp2040js. */
export function wide(core, bus, r, op) {
  const second = bus.fetch(r[PC]);
  if (op >> 11 !== 0b11110 || (second & 0xd000) !== 0xd000) return slowly(core, r);
  const sign = (op >> 10) & 1;
  const i1 = ~((second >> 13) ^ sign) & 1;
  const i2 = ~((second >> 11) ^ sign) & 1;
  const offset = (-sign << 24) | (i1 << 23) | (i2 << 22) | ((op & 0x3ff) << 12) | ((second & 0x7ff) << 1);
  const next = r[PC] + 2;
  r[LR] = next | 1;
  r[PC] = next + offset;
  core.cycles += 2;
}

/** Leaves one instruction to rp2040js. */
function slowly(core, r) {
  r[PC] -= 2;
  core.cycles -= 1;
  core.executeInstruction();
}
