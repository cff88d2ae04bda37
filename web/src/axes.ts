// The axes of a machine, in the order in which it reports them.

export const AXIS_NAMES = ["X", "Y", "Z", "A"] as const;
/** Those that a machine has if nothing says otherwise. */
export const AXES = 3;
/** The fourth. It is rotary, in degrees, unless a setting makes it linear. */
export const A = 3;
/** Bit 0 is 1 for a rotary A, which is the default, and 0 for a linear one. */
const ROTARY = 376;
/** The steps of A: only a machine that has A has this setting. */
const STEPS_OF_A = 103;

export const isRotary = (settings: ReadonlyMap<number, string>): boolean => (Number(settings.get(ROTARY) ?? 1) & 1) === 1;

/** How many axes a machine with all these settings has, of those that can be simulated. */
export const axesOf = (settings: ReadonlyMap<number, string>): number => (settings.has(STEPS_OF_A) ? A + 1 : AXES);

/** The unit of an axis. */
export const unitOf = (axis: number, isRotary: boolean): "mm" | "degrees" => (axis === A && isRotary ? "degrees" : "mm");

/** Places in words: those of one unit together, as `X 1.00, Y 2.00 mm, A 90.00 degrees`. */
export function placesInWords(places: { axis: number; words: string }[], isRotary: boolean, between = ", "): string {
  const units = ["mm", "degrees"] as const;
  const groups = units.map((unit) => [places.filter(({ axis }) => unitOf(axis, isRotary) === unit), unit] as const).filter(([group]) => group.length);
  return groups.map(([group, unit]) => `${group.map(({ axis, words }) => `${AXIS_NAMES[axis]} ${words}`).join(between)} ${unit}`).join(between);
}
