// A slider's places, from -1 to 1, and the factors that they mean: a tenth, as it is, ten times as much.

/** The slider's steps are this fine. */
export const STEP = 0.001;

export const factorAt = (place: number): number => 10 ** place;

export const placeOf = (factor: number): number => Math.max(-1, Math.min(1, Math.log10(factor)));

/** A value as a person would set it: three digits, and no finer than settings are listed. */
export function rounded(value: number): number {
  return Number(Number(value.toPrecision(3)).toFixed(3));
}

/** As it is entered: without an exponent, which the machine does not read. */
export const written = (value: number): string => value.toFixed(4).replace(/\.?0+$/, "");
