import { Fault } from '../fault.mjs';
import { FIRST_INTERRUPT, INTERRUPTS, PENDSV, SYSTICK } from './exceptions.mjs';

const [ACTLR, CPUID, ICSR, VTOR, AIRCR, SCR, CCR, SHPR1, SHPR3, SHCSR, CFSR, HFSR, CPACR, STIR, DEMCR] = [
  0xe008, 0xed00, 0xed04, 0xed08, 0xed0c, 0xed10, 0xed14, 0xed18, 0xed20, 0xed24, 0xed28, 0xed2c, 0xed88, 0xef00, 0xedfc,
];
const [DWT_CTRL, DWT_CYCCNT] = [0x1000, 0x1004];
const [SYST_FIRST, SYST_LAST] = [0xe010, 0xe01c];
const NVIC = { setEnable: 0xe100, clearEnable: 0xe180, setPending: 0xe200, clearPending: 0xe280, active: 0xe300, priority: 0xe400, end: 0xe500 };
const [PENDSVSET, PENDSVCLR, PENDSTSET, PENDSTCLR] = [1 << 28, 1 << 27, 1 << 26, 1 << 25];
const CORTEX_M33 = 0x411fd210;
const AIRCR_KEY = 0xfa050000 | 0;
const RESET_REQUEST = 1 << 2;
const OFFSET_MASK = 0xfffff;

/** The private peripherals of a Cortex-M33, from 0xe0000000: NVIC, SCB, SysTick, the cycle counter. */
export class System {
  /** @param {import('../clock.mjs').MachineClock} clock */
  constructor(clock) {
    this.clock = clock;
    this.cpacr = 0;
    this.ccr = 0;
    this.demcr = 0;
    this.counterStart = 0;
    this.shcsr = 0;
    this.actlr = 0;
  }

  /** @param {import('./core.mjs').CortexM33} core */
  attach(core, sysTick, onResetRequest) {
    Object.assign(this, { core, sysTick, onResetRequest, exceptions: core.exceptions });
  }

  /** Whether the firmware may use a coprocessor. */
  isEnabled(coprocessor) {
    return ((this.cpacr >>> (2 * coprocessor)) & 3) === 3;
  }

  read(address) {
    const offset = address & OFFSET_MASK;
    if (offset >= SYST_FIRST && offset <= SYST_LAST) return this.sysTick.read(offset & 0xfff);
    if (offset >= NVIC.setEnable && offset < NVIC.end) return this.#readNvic(offset);
    if (offset >= SHPR1 && offset <= SHPR3) return this.#priorities(4 + (offset - SHPR1));
    switch (offset) {
      case ACTLR: return this.actlr;
      case CPUID: return CORTEX_M33;
      case ICSR: return this.core.IPSR | (this.exceptions.isAnyPending ? 1 << 22 : 0) | (this.exceptions.systickPending ? PENDSTSET : 0) | (this.exceptions.pendSvPending ? PENDSVSET : 0);
      case VTOR: return this.core.VTOR;
      case AIRCR: return AIRCR_KEY;
      case SCR: return this.core.sleep.control;
      case CCR: return this.ccr;
      case SHCSR: return this.shcsr;
      case CFSR:
      case HFSR: return 0;
      case CPACR: return this.cpacr;
      case DEMCR: return this.demcr;
      case DWT_CTRL: return 1;
      case DWT_CYCCNT: return (this.clock.cycles - this.counterStart) | 0;
    }
    throw new Fault(`a read of the core's register 0x${(address >>> 0).toString(16)}, which is not emulated`);
  }

  write(address, value) {
    const offset = address & OFFSET_MASK;
    if (offset >= SYST_FIRST && offset <= SYST_LAST) return this.sysTick.write(offset & 0xfff, value);
    if (offset >= NVIC.setEnable && offset < NVIC.end) return this.#writeNvic(offset, value);
    if (offset >= SHPR1 && offset <= SHPR3) return this.#setPriorities(4 + (offset - SHPR1), value);
    switch (offset) {
      case ACTLR: this.actlr = value; return undefined;
      case ICSR: return this.#control(value);
      case VTOR: this.core.VTOR = value & ~0x7f; return undefined;
      case AIRCR:
        if ((value & RESET_REQUEST) !== 0) this.onResetRequest();
        return undefined;
      case SCR: return this.core.sleep.setControl(value);
      case CCR: this.ccr = value; return undefined;
      case SHCSR: this.shcsr = value; return undefined;
      case CFSR:
      case HFSR: return undefined;
      case CPACR: this.cpacr = value; return undefined;
      case STIR: return this.exceptions.pend(FIRST_INTERRUPT + (value & 0x1ff));
      case DEMCR: this.demcr = value; return undefined;
      case DWT_CTRL: return undefined;
      case DWT_CYCCNT: this.counterStart = this.clock.cycles - value; return undefined;
    }
    throw new Fault(`a write to the core's register 0x${(address >>> 0).toString(16)}, which is not emulated`);
  }

  /** Registers of bytes are written as bytes too. */
  writeByte(address, value) {
    const offset = address & OFFSET_MASK;
    if (offset >= NVIC.priority && offset < NVIC.end) this.exceptions.setPriority(FIRST_INTERRUPT + offset - NVIC.priority, value);
    else if (offset >= SHPR1 && offset < SHPR3 + 4) this.exceptions.setPriority(4 + offset - SHPR1, value);
    else throw new Fault(`a write of a byte to the core's register 0x${(address >>> 0).toString(16)}, which is not emulated`);
  }

  readByte(address) {
    return (this.read(address & ~3) >>> (8 * (address & 3))) & 0xff;
  }

  #control(value) {
    if (value & PENDSVSET) this.exceptions.pend(PENDSV);
    if (value & PENDSVCLR) this.exceptions.pend(PENDSV, false);
    if (value & PENDSTSET) this.exceptions.pend(SYSTICK);
    if (value & PENDSTCLR) this.exceptions.pend(SYSTICK, false);
  }

  #readNvic(offset) {
    const { exceptions } = this;
    if (offset >= NVIC.priority) return this.#priorities(FIRST_INTERRUPT + (offset - NVIC.priority));
    const from = FIRST_INTERRUPT + 8 * (offset & 0x7f);
    const states = offset >= NVIC.active ? Uint8Array.from(exceptions.pending, (_, number) => (exceptions.active.includes(number) ? 1 : 0)) : offset >= NVIC.setPending ? exceptions.pending : exceptions.enabled;
    let bits = 0;
    for (let index = 0; index < 32; index++) bits |= (states[from + index] ?? 0) << index;
    return bits;
  }

  #writeNvic(offset, value) {
    const { exceptions } = this;
    if (offset >= NVIC.priority) return this.#setPriorities(FIRST_INTERRUPT + (offset - NVIC.priority), value);
    const from = FIRST_INTERRUPT + 8 * (offset & 0x7f);
    for (let left = value; left !== 0; left &= left - 1) {
      const number = from + 31 - Math.clz32(left & -left);
      if (number >= FIRST_INTERRUPT + INTERRUPTS) continue;
      if (offset < NVIC.setPending) exceptions.enable(number, offset < NVIC.clearEnable);
      else exceptions.pend(number, offset < NVIC.clearPending);
    }
    return undefined;
  }

  #priorities(from) {
    let word = 0;
    for (let index = 0; index < 4; index++) word |= ((this.exceptions.priority[from + index] ?? 0) & 0xff) << (8 * index);
    return word;
  }

  #setPriorities(from, word) {
    for (let index = 0; index < 4; index++) {
      // Those of NMI and HardFault are fixed.
      if (from + index > 3) this.exceptions.setPriority(from + index, (word >>> (8 * index)) & 0xff);
    }
    return undefined;
  }
}
