/** Assembles PIO instructions (datasheet 3.4): each function returns a word; `side` is the five bits of delay and side-set. */
const [JMP, WAIT, IN, OUT, PUSH, MOV, IRQ, SET] = [0, 1, 2, 3, 4, 5, 6, 7];
export const CONDITION = { always: 0, xZero: 1, xCounts: 2, yZero: 3, yCounts: 4, different: 5, pin: 6, osrNotEmpty: 7 };
export const FROM = { pins: 0, x: 1, y: 2, null: 3, status: 5, isr: 6, osr: 7 };
export const TO = { pins: 0, x: 1, y: 2, null: 3, directions: 4, exec: 4, pc: 5, isr: 6, osr: 7, outExec: 7 };
export const OPERATION = { none: 0, invert: 1, reverse: 2 };
export const REL = 16;

const word = (kind, field, low) => (kind << 13) | (field << 8) | low;
export const jmp = (condition, target, field = 0) => word(JMP, field, (condition << 5) | target);
export const waitGpio = (high, pin, field = 0) => word(WAIT, field, (high << 7) | pin);
export const waitPin = (high, pin, field = 0) => word(WAIT, field, (high << 7) | (1 << 5) | pin);
export const waitIrq = (high, flag, field = 0) => word(WAIT, field, (high << 7) | (2 << 5) | flag);
export const shiftIn = (source, bits, field = 0) => word(IN, field, (source << 5) | (bits & 31));
export const shiftOut = (destination, bits, field = 0) => word(OUT, field, (destination << 5) | (bits & 31));
export const push = ({ ifFull = 0, block = 1 } = {}, field = 0) => word(PUSH, field, (ifFull << 6) | (block << 5));
export const pull = ({ ifEmpty = 0, block = 1 } = {}, field = 0) => word(PUSH, field, 0x80 | (ifEmpty << 6) | (block << 5));
export const mov = (destination, source, operation = 0, field = 0) => word(MOV, field, (destination << 5) | (operation << 3) | source);
export const irqSet = (flag, field = 0) => word(IRQ, field, flag);
export const irqWait = (flag, field = 0) => word(IRQ, field, 0x20 | flag);
export const irqClear = (flag, field = 0) => word(IRQ, field, 0x40 | flag);
export const set = (destination, value, field = 0) => word(SET, field, (destination << 5) | value);
