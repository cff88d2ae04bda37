/** What the cores of both chips have in common. */
import { Fault } from './fault.mjs';

/**
 * Runs a core by its own loop.
 *
 * @returns {Fault | null} what stopped it, if an instruction could not be carried out
 */
export function untilFault(loop, core, bus, clock, limit) {
  try {
    loop(core, bus, clock, limit);
    return null;
  } catch (error) {
    if (error instanceof Fault) return error;
    throw error;
  }
}

/** A condition of the architecture, 0 to 14. */
export function holds(core, condition) {
  switch (condition) {
    case 0: return core.Z;
    case 1: return !core.Z;
    case 2: return core.C;
    case 3: return !core.C;
    case 4: return core.N;
    case 5: return !core.N;
    case 6: return core.V;
    case 7: return !core.V;
    case 8: return core.C && !core.Z;
    case 9: return !core.C || core.Z;
    case 10: return core.N === core.V;
    case 11: return core.N !== core.V;
    case 12: return !core.Z && core.N === core.V;
    case 13: return core.Z || core.N !== core.V;
    default: return true;
  }
}

/** SXTH, SXTB, UXTH, UXTB, in the order of their codes. */
export function extended(value, kind) {
  switch (kind) {
    case 0: return (value << 16) >> 16;
    case 1: return (value << 24) >> 24;
    case 2: return value & 0xffff;
    default: return value & 0xff;
  }
}

/** REV, REV16, and REVSH as the fourth. */
export function reversed(value, kind) {
  const halves = ((value >>> 8) & 0x00ff00ff) | ((value & 0x00ff00ff) << 8);
  if (kind === 1) return halves;
  if (kind === 3) return (halves << 16) >> 16;
  return (halves >>> 16) | (halves << 16);
}
