import { AXES, STEPS_PER_MM } from './pins.mjs';

/**
 * Where a status report and the gantry disagree, in words.
 *
 * @param {string} status a report with MPos, at the default 50 steps/mm
 * @param {number[]} before steps counted when the report was requested, one number per axis
 * @param {number[]} after steps counted when it had come
 * @param {number} slack by how many steps a report may be beside those, while belts turn against each other
 * @returns {string[]}
 */
export function differences(status, before, after, slack = 0) {
  const [, position] = /MPos:([-\d.,]+)/.exec(status) ?? [];
  if (position === undefined) return [`no MPos in ${status}`];
  const reported = position.split(',').map((mm) => Math.round(Number(mm) * STEPS_PER_MM));
  return AXES.slice(0, before.length).flatMap((axis, index) => {
    const [low, high] = [before[index], after[index]].sort((one, other) => one - other);
    if (reported[index] >= low - slack && reported[index] <= high + slack) return [];
    return [`${axis} is reported at ${reported[index]} steps, and ${low === high ? low : `${low} to ${high}`} left the pin`];
  });
}
