// How far along its plan a machine is, by what it reports: which line is under way, and where it stands.

import type { Motion } from "../motion";

/** What is known of where a program goes, and when. */
interface Course {
  motion: Motion;
  /** When a line begins to move the machine, s; undefined if it never does. */
  beginsS(line: number): number | undefined;
  /** When all that lines up to this one ask for is made, s. */
  endsS(line: number): number;
}

/** Parts of a phase that are looked at one by one. */
const PARTS = 8;
/** A place that is nearer than this to the one reported is it: the machine reports thousandths of a mm, and drawn places are no better than these, mm. */
const NEAR_MM = 0.02;

/** The time of the plan's motion at which the machine is at this place, s: of the line that is under way, or of anything up to that line where
 * the machine does not say which one is. It is the first such time that is not before `fromS`; where the path does not go there, the one that is nearest to it. */
export function madeAt(plan: Course, line: { from: number | undefined; to: number }, placeMm: number[], fromS: number): number {
  const { motion } = plan;
  const beginS = Math.max(fromS, (line.from === undefined ? undefined : plan.beginsS(line.from)) ?? fromS);
  const endS = Math.max(beginS, plan.endsS(line.to));
  const farAt = (timeS: number): number => far(motion.places(timeS), placeMm);
  let [nearestS, nearestMm] = [beginS, farAt(beginS)];
  for (let row = Math.max(0, motion.rowAt(beginS)); row < motion.length && motion.from(row) <= endS && nearestMm > NEAR_MM; row++) {
    const [from, to] = [Math.max(beginS, motion.from(row)), Math.min(endS, motion.to(row))];
    const partS = (to - from) / PARTS;
    for (let part = 0; part < PARTS && partS > 0 && nearestMm > NEAR_MM; part++) {
      const [begin, end] = [from + partS * part, from + partS * (part + 1)];
      // What is farther away than the part is long is not in it.
      if (Math.min(farAt(begin), farAt(end)) > motion.read(row).speedAlong(begin - motion.from(row)) * partS * 2 + NEAR_MM + nearestMm / 2) continue;
      const timeS = closest(farAt, begin, end);
      const mm = farAt(timeS);
      if (mm < nearestMm) [nearestS, nearestMm] = [timeS, mm];
    }
  }
  return nearestS;
}

/** Where a function that falls and then rises is least. */
function closest(of: (at: number) => number, low: number, high: number): number {
  for (let step = 0; step < 24; step++) {
    const third = (high - low) / 3;
    if (of(low + third) <= of(high - third)) high -= third;
    else low += third;
  }
  return (low + high) / 2;
}

function far(one: number[], other: number[]): number {
  return Math.hypot(...one.map((mm, axis) => mm - (other[axis] ?? mm)));
}
