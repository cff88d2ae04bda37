import { Fault } from '../fault.mjs';
import { undefinedOf } from './thumb32.mjs';

const PC = 15;
const DOUBLES = 4;

/** CDP, MCR, MRC, MCRR, MRRC and their second kinds. The RP2350's coprocessor of doubles is number 4; of the others none is emulated. */
export function coprocessor(core, r, op, second) {
  const number = (second >> 8) & 15;
  if (number !== DOUBLES) throw undefinedOf(op, second);
  if (!core.system.isEnabled(number)) throw new Fault(`coprocessor ${number} is not enabled (CPACR)`);
  const { doubles } = core;
  const keeps = (op & 0x1000) !== 0;
  const [target, crm] = [(second >> 12) & 15, second & 15];
  if ((op & 0x0fe0) === 0x0c40) {
    const [opc1, high] = [(second >> 4) & 15, op & 15];
    if (op & 0x10) [r[target], r[high]] = doubles.mrrc(opc1, crm, keeps);
    else doubles.mcrr(opc1, crm, r[target], r[high]);
  } else if ((op & 0x0f00) !== 0x0e00) {
    throw undefinedOf(op, second);
  } else if (!(second & 0x10)) {
    doubles.cdp((op >> 4) & 15, target, op & 15, crm, (second >> 5) & 7);
  } else if (op & 0x10) {
    const value = doubles.mrc((op >> 5) & 7, op & 15, crm, (second >> 5) & 7, keeps);
    if (target === PC) core.setFlags(value);
    else r[target] = value;
  } else {
    throw undefinedOf(op, second);
  }
}
