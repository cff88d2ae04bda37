import { Fault } from '../fault.mjs';

/** Arithmetic of the ROM: where IEEE 754 gives NaN, it gives an infinity. */
export function sum(a, b) {
  const result = a + b;
  return Number.isNaN(result) ? Infinity : result;
}

export const difference = (a, b) => sum(a, -b);

export function product(a, b) {
  const result = a * b;
  return Number.isNaN(result) ? infinityOf(a, b) : result;
}

export function quotient(a, b) {
  const result = a / b;
  return Number.isNaN(result) ? infinityOf(a, b) : result;
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

/** An infinity with the sign of the product or quotient. */
function infinityOf(a, b) {
  return isNegative(a) === isNegative(b) ? Infinity : -Infinity;
}

const isNegative = (value) => value < 0 || Object.is(value, -0);
