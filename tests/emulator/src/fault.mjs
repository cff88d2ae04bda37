const HARD_FAULT = 3;
const PC = 15;

/** An error to which a Cortex-M0+ reacts with a HardFault. */
export class Fault extends Error {}

/** The program counter points to an address without a program. */
export class FetchFault extends Fault {}

/**
 * Enters the HardFault handler with the instruction at fault in the frame.
 *
 * @returns {number} the address of that instruction
 */
export function enterHardFault(core, fault) {
  const r = core.registers;
  if (!(fault instanceof FetchFault)) r[PC] -= 2;
  const at = r[PC];
  if (core.IPSR === HARD_FAULT) throw new Error(`the core locked up: ${fault.message} at pc 0x${at.toString(16)}, within the HardFault handler`);
  core.waiting = false;
  try {
    core.exceptionEntry(HARD_FAULT);
  } catch (error) {
    if (!(error instanceof Fault)) throw error;
    throw new Error(`the core locked up: ${fault.message} at pc 0x${at.toString(16)}, and the HardFault handler's vector is out of reach too`);
  }
  return at;
}
