// Units as people write them.

/** A unit of a setting, "mm/s2", as "mm/s²". */
export function unitInSigns(unit: string): string {
  return unit.replace(/^us$/, "µs").replace(/(?<=\/s)[23]$/, (power) => (power === "2" ? "²" : "³"));
}
