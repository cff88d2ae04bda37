const OPCODES = 0x10000;
const REGISTERS_READ = new Set([1, 2, 3, 6, 7]);
const REGISTERS_OUT = new Set([1, 2, 3, 5, 6]);
const REGISTERS_MOVED = new Set([1, 2, 5, 6, 7]);
const REGISTERS_SET = new Set([1, 2]);
const JUMP_IF_PIN = 6;

/**
 * Instructions that affect only their own machine: they read and write its registers, never a pin, flag or FIFO
 * (without side-set, autopush and autopull). A machine can carry these out ahead of time.
 */
export const PRIVATE = Uint8Array.from({ length: OPCODES }, (_, op) => (isPrivate(op >> 13, (op >> 5) & 7, op & 7) ? 1 : 0));

function isPrivate(kind, middle, low) {
  switch (kind) {
    case 0: // JMP
      return middle !== JUMP_IF_PIN;
    case 2: // IN
      return REGISTERS_READ.has(middle);
    case 3: // OUT
      return REGISTERS_OUT.has(middle);
    case 5: // MOV
      return REGISTERS_MOVED.has(middle) && REGISTERS_READ.has(low);
    case 7: // SET
      return REGISTERS_SET.has(middle);
    default:
      return false;
  }
}
