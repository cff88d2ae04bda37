import { mover } from './remapped.mjs';

/** Where the RP2350's peripherals have the registers of the RP2040's, and which of their bits are elsewhere. */

const AS_THEY_ARE = { toInner: (_, word) => word, fromInner: (_, word) => word };

/** Datasheet 9.11.1: IO_BANK0. The fields of overrides, and the registers of interrupts behind 48 pins instead of 30. */
const CONTROL = mover([{ from: 0, to: 0, bits: 5 }, { from: 12, to: 8, bits: 2 }, { from: 14, to: 12, bits: 2 }, { from: 16, to: 16, bits: 2 }, { from: 28, to: 28, bits: 2 }]);
const PINS_END = 30 * 8;
const INTERRUPT_WORDS = 4;
const INTERRUPT_BLOCKS = [[0x230, 0xf0], [0x248, 0x100], [0x260, 0x110], [0x278, 0x120]];
const isControl = (offset) => offset < PINS_END && (offset & 4) !== 0;

export const IO_BANK0 = {
  place: (offset) => {
    if (offset < PINS_END) return offset;
    const block = INTERRUPT_BLOCKS.find(([from]) => offset >= from && offset < from + 4 * INTERRUPT_WORDS);
    return block === undefined ? null : offset - block[0] + block[1];
  },
  moved: { toInner: (offset, word) => (isControl(offset) ? CONTROL.there(word) : word), fromInner: (offset, word) => (isControl(offset) ? CONTROL.back(word) : word) },
};

/** Datasheet 12.8.5: TIMER0. LOCKED and SOURCE are new. */
export const TIMER = { place: (offset) => (offset < 0x34 ? offset : offset < 0x3c ? null : offset - 8), moved: AS_THEY_ARE };

/** Datasheet 11.7: PIO. Registers of the RX FIFO as a store, and GPIOBASE, are new; STATUS_SEL has another bit. */
const EXECCTRL = mover([{ from: 0, to: 0, bits: 4 }, { from: 5, to: 4, bits: 1 }, { from: 7, to: 7, bits: 25 }]);
const [SM0, SM_BYTES, SM_END, INTR] = [0xc8, 0x18, 0x128, 0x16c];
const isExecctrl = (offset) => offset >= SM0 && offset < SM_END && (offset - SM0) % SM_BYTES === 4;

export const PIO = {
  place: (offset) => (offset < SM_END ? offset : offset < INTR ? null : offset - (INTR - SM_END)),
  moved: { toInner: (offset, word) => (isExecctrl(offset) ? EXECCTRL.there(word) : word), fromInner: (offset, word) => (isExecctrl(offset) ? EXECCTRL.back(word) : word) },
};

/** Datasheet 12.5.3: PWM. Four slices more, whose pins an RP2350A does not have, and a second interrupt. */
const [SLICES_END, LAST_SLICES_END, PWM_EN, PWM_IRQ0_INTS] = [0xa0, 0xf0, 0xf0, 0x100];
export const PWM = {
  place: (offset) => (offset < SLICES_END ? offset : offset < LAST_SLICES_END ? null : offset <= PWM_IRQ0_INTS ? offset - (PWM_EN - SLICES_END) : null),
  moved: AS_THEY_ARE,
};

/** Datasheet 3.1.11: SIO. The registers of the pins above 31 stand between the others. */
const SIO_PLACES = new Map([[0x000, 0x000], [0x004, 0x004], [0x010, 0x010], [0x018, 0x014], [0x020, 0x018], [0x028, 0x01c], [0x030, 0x020], [0x038, 0x024], [0x040, 0x028], [0x048, 0x02c]]);
const [SPINLOCKS, SPINLOCKS_END] = [0x100, 0x180];
export const SIO = { place: (offset) => (offset >= SPINLOCKS && offset < SPINLOCKS_END ? offset : (SIO_PLACES.get(offset) ?? null)), moved: AS_THEY_ARE };

/** PIO2's first interrupt by a number that the RP2040 has not. */
export const IRQ_PIO2 = 40;

/** The RP2350's number of each interrupt of the RP2040's peripherals, of PIO2, and of the software interrupts by the names that rp-pac gives them. */
export const INTERRUPTS = new Map([[0, 0], [1, 1], [2, 2], [3, 3], [4, 8], [5, 14], [7, 15], [8, 16], [9, 17], [10, 18], [IRQ_PIO2, 19], [IRQ_PIO2 + 1, 20], [11, 10], [12, 11], [13, 21], [20, 33], [21, 34], ...[26, 27, 28, 29, 30].map((number) => [number, number + 21])]);
