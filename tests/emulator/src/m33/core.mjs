import { NOWHERE } from '../bus.mjs';
import { Fault } from '../fault.mjs';
import { callRom } from '../rom/rom.mjs';
import { ROM_BYTES } from '../rom/image.mjs';
import { Exceptions, SYSTICK } from './exceptions.mjs';
import { holds, untilFault } from '../thumb.mjs';
import { execute16 } from './thumb16.mjs';
import { execute32 } from './thumb32.mjs';

/** An assumption, as all times of this core: those of a Cortex-M0+ with 15 for an entry, 10 for a return. */
const [ENTRY_CYCLES, RETURN_CYCLES] = [15, 10];
const [SP, LR, PC] = [13, 14, 15];
const [WFE, WFI, SEV] = [2, 3, 4];
/** ITSTATE outside of a block. */
const NO_BLOCK = 0;

/** Special registers by their number in MRS and MSR. */
const SPECIAL = { apsr: 0, xpsr: 3, ipsr: 5, msp: 8, psp: 9, msplim: 10, psplim: 11, primask: 16, basepri: 17, basepriMax: 18, faultmask: 19, control: 20 };

/**
 * Runs the core until `limit`, the clock's next alarm, or sleep, whichever comes first, with PIO and DMA at its side.
 *
 * @returns {import('../fault.mjs').Fault | null} what stopped it, if an instruction could not be carried out
 */
export function run(core, bus, clock, limit) {
  return untilFault(runOn, core, bus, clock, limit);
}

function runOn(core, bus, clock, limit) {
  const r = bus.registers;
  const { lockstep, profile } = clock;
  const { slowness } = core;
  while (core.cycles < clock.next && core.cycles < limit && !core.waiting) {
    const began = core.cycles;
    if (core.interruptsUpdated && core.checkForInterrupts()) core.cycles += ENTRY_CYCLES;
    const pc = r[PC];
    const since = core.cycles;
    bus.dataAddress = NOWHERE;
    core.step(bus, r, pc);
    if (slowness !== null) slowness.charge(core, began);
    if (profile !== null) profile.add(pc, core.cycles - since, core.cycles);
    if (lockstep.next <= core.cycles) lockstep.catchUp();
  }
}

/**
 * A Cortex-M33 with the instructions of the architecture's main extension and the multiplications of its DSP extension, without
 * floats, in the secure state, with the main stack alone.
 *
 * Each instruction takes a cycle; loads from memory, branches, tables and divisions more (`thumb16.mjs`, `multiply.mjs`). ARM
 * publishes no timing of this core, so these are assumptions, of which `slowness` shows how much depends on them.
 */
export class CortexM33 {
  /** @param {import('./system.mjs').System} system its private peripherals */
  constructor(chip, system) {
    this.chip = chip;
    this.system = system;
    this.registers = new Int32Array(16);
    this.cycles = 0;
    [this.N, this.Z, this.C, this.V, this.Q] = [false, false, false, false, false];
    /** The carry of the last shifter operand. */
    this.carryOut = false;
    /** ITSTATE: the condition and the mask of the block that the core is in; 0 outside. */
    this.it = NO_BLOCK;
    this.PM = false;
    this.BASEPRI = 0;
    this.IPSR = 0;
    this.VTOR = 0;
    this.psp = 0;
    this.msplim = 0;
    this.waiting = false;
    this.eventRegistered = false;
    this.interruptsUpdated = false;
    /** Whether a store that is exclusive would succeed. */
    this.exclusive = false;
    this.exceptions = new Exceptions(this);
    /** What each instruction takes more than is assumed. @type {import('./slowness.mjs').Slowness | null} */
    this.slowness = null;
  }

  get PC() {
    return this.registers[PC];
  }

  set PC(value) {
    this.registers[PC] = value;
  }

  get SP() {
    return this.registers[SP];
  }

  set SP(value) {
    this.registers[SP] = value & ~3;
  }

  get LR() {
    return this.registers[LR];
  }

  set LR(value) {
    this.registers[LR] = value;
  }

  /** Carries out the instruction at `pc`. */
  step(bus, r, pc) {
    const op = bus.fetch(pc);
    r[PC] = pc + 2;
    this.cycles += 1;
    const { it } = this;
    if (it === NO_BLOCK) return op >= 0xe800 ? execute32(this, bus, r, op) : execute16(this, bus, r, op);
    const runs = holds(this, it >> 4);
    if (!runs) {
      if (op >= 0xe800) r[PC] += 2;
    } else if (op >= 0xe800) {
      execute32(this, bus, r, op);
    } else {
      execute16(this, bus, r, op);
    }
    // A return from a handler brings the state of a block of its own.
    if (this.it === it) this.it = it & 7 ? (it & 0xe0) | ((it << 1) & 0x1f) : NO_BLOCK;
    return undefined;
  }

  /** IT: the next one to four instructions are carried out if the condition holds, or if it does not. */
  beginBlock(state) {
    this.it = state;
  }

  setFlags(value) {
    this.N = value < 0;
    this.Z = (value & 0x40000000) !== 0;
    this.C = (value & 0x20000000) !== 0;
    this.V = (value & 0x10000000) !== 0;
  }

  get apsr() {
    return (this.N ? 0x80000000 : 0) | (this.Z ? 0x40000000 : 0) | (this.C ? 0x20000000 : 0) | (this.V ? 0x10000000 : 0) | (this.Q ? 0x08000000 : 0);
  }

  get xpsr() {
    return this.apsr | this.IPSR | 0x01000000 | ((this.it & 3) << 25) | ((this.it & 0xfc) << 8);
  }

  set xpsr(value) {
    this.setFlags(value);
    this.Q = (value & 0x08000000) !== 0;
    this.IPSR = value & 0x1ff;
    this.it = ((value >>> 25) & 3) | ((value >>> 8) & 0xfc);
  }

  /** CPSIE, CPSID. */
  maskInterrupts(op) {
    if (op & 1) throw new Fault('CPS with FAULTMASK, which is not emulated');
    if (op & 2) this.#mask((op & 0x10) !== 0);
  }

  #mask(isMasked) {
    this.PM = isMasked;
    this.watch.update();
    if (!isMasked) this.interruptsUpdated = true;
  }

  #maskBelow(priority) {
    this.BASEPRI = priority;
    this.interruptsUpdated = true;
  }

  hint(number) {
    switch (number) {
      case WFE:
        this.cycles += 1;
        return this.sleep.waitForEvent();
      case WFI:
        this.cycles += 1;
        return this.sleep.waitForInterrupt();
      case SEV:
        this.eventRegistered = true;
        return undefined;
      default: // NOP, YIELD, CSDB and others that change nothing
        return undefined;
    }
  }

  breakpoint(number) {
    if (this.registers[PC] >>> 0 >= ROM_BYTES) throw new Fault(`a breakpoint (number ${number})`);
    callRom(number, this, this.bus, this.registers);
  }

  callSupervisor() {
    throw new Fault('SVC, which is not emulated');
  }

  readSpecialRegister(number) {
    switch (number) {
      case SPECIAL.apsr: return this.apsr;
      case SPECIAL.xpsr: return this.xpsr;
      case SPECIAL.ipsr: return this.IPSR;
      case SPECIAL.msp: return this.SP;
      case SPECIAL.psp: return this.psp;
      case SPECIAL.msplim: return this.msplim;
      case SPECIAL.psplim: return 0;
      case SPECIAL.primask: return this.PM ? 1 : 0;
      case SPECIAL.basepri:
      case SPECIAL.basepriMax: return this.BASEPRI;
      case SPECIAL.faultmask: return 0;
      case SPECIAL.control: return 0;
    }
    throw new Fault(`MRS of special register ${number}, which is not emulated`);
  }

  writeSpecialRegister(number, value) {
    switch (number) {
      case SPECIAL.apsr: return this.setFlags(value);
      case SPECIAL.msp: this.SP = value; return undefined;
      case SPECIAL.psp: this.psp = value; return undefined;
      case SPECIAL.msplim: this.msplim = value; return undefined;
      case SPECIAL.psplim: return undefined;
      case SPECIAL.primask: return this.#mask((value & 1) !== 0);
      case SPECIAL.basepri: return this.#maskBelow(value & 0xf0);
      case SPECIAL.basepriMax:
        // It only makes the mask stricter.
        if ((value & 0xf0) !== 0 && (this.BASEPRI === 0 || (value & 0xf0) < this.BASEPRI)) this.#maskBelow(value & 0xf0);
        return undefined;
      case SPECIAL.control:
        if ((value & 7) === 0) return undefined;
    }
    throw new Fault(`MSR of 0x${(value >>> 0).toString(16)} to special register ${number}, which is not emulated`);
  }

  /** SysTick's count has reached 0. */
  set pendingSystick(isPending) {
    this.exceptions.pend(SYSTICK, isPending);
  }

  setInterrupt(number, isAsserted) {
    this.exceptions.setLine(number, isAsserted);
  }

  checkForInterrupts() {
    return this.exceptions.enterNext();
  }

  exceptionEntry(number) {
    this.exceptions.enter(number);
  }

  exceptionReturn(value) {
    this.cycles += RETURN_CYCLES;
    this.exceptions.leave(value);
  }
}
