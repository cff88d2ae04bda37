import { Fault } from '../fault.mjs';

/**
 * Arithmetic of the ROM. Where IEEE 754 gives NaN it gives an infinity, and the firmware goes to it without a check. So
 * whoever gets there has planned nonsense, and that is a fault here.
 */
export function sum(a, b) {
  return meaningful(a + b, 'sum', a, b);
}

export const difference = (a, b) => sum(a, -b);

export function product(a, b) {
  return meaningful(a * b, 'product', a, b);
}

export function quotient(a, b) {
  return meaningful(a / b, 'quotient', a, b);
}

export function squareRoot(a) {
  return a < 0 ? -Infinity : Math.sqrt(a);
}

export function logarithm(a) {
  return a <= 0 ? -Infinity : Math.log(a);
}

export function compare(a, b) {
  return a < b ? -1 : a > b ? 1 : 0;
}

/** A function of an angle. Outside its range the ROM returns an undefined value, so that is a fault here. */
export function ofAngle(name, operation, furthest) {
  return (angle) => {
    if (Math.abs(angle) < furthest) return operation(angle);
    throw new Fault(`the ROM's ${name} of ${angle}: it takes angles between -${furthest} and ${furthest}`);
  };
}

function meaningful(result, name, a, b) {
  if (Number.isNaN(result)) throw new Fault(`the ROM's ${name} of ${a} and ${b}: it has no NaN to return`);
  return result;
}
