/** The bits of an instruction for its delay and side-set. */
const DELAY_AND_SIDE = 0x1f00;
const JUMP_CONDITION_SHIFT = 5;
const TARGET = 31;
const [ALWAYS, X_COUNTS, Y_COUNTS, BY_PIN] = [0, 2, 4, 6];
const COUNTING = new Set([ALWAYS, X_COUNTS, Y_COUNTS]);
/** Every instruction of the longest round that is looked for. */
const MOST_INSTRUCTIONS = 8;
const JUMPS = 8;

/**
 * The round of a program that begins at a jump by the level of a pin, if the program comes back to it, only counts X and Y
 * down on its way, and has the same side-set everywhere.
 *
 * @param {Uint16Array} memory
 * @param {import('./program-view.mjs').ProgramView} view its cycles, side-set, and what follows each instruction
 * @param {number} start the address of the jump
 * @param {boolean} high the level at the pin
 * @returns {{cycles: number, xCounts: number, yCounts: number} | null}
 */
export function polling(memory, view, start, high) {
  if (conditionOf(memory[start]) !== BY_PIN) return null;
  const round = { cycles: view.cycles[start], xCounts: 0, yCounts: 0 };
  let at = high ? memory[start] & TARGET : view.follows[start];
  for (let left = MOST_INSTRUCTIONS; at !== start && left > 0; left--) {
    const condition = conditionOf(memory[at]);
    if (!COUNTING.has(condition) || !sameSide(view, at, start)) return null;
    if (condition === X_COUNTS) round.xCounts += 1;
    if (condition === Y_COUNTS) round.yCounts += 1;
    round.cycles += view.cycles[at];
    at = memory[at] & TARGET;
  }
  return at === start ? round : null;
}

const sameSide = ({ sideMasks, sideValues }, one, other) => sideMasks[one] === sideMasks[other] && sideValues[one] === sideValues[other];

/** The condition of a jump; no condition if it is another instruction. */
function conditionOf(op) {
  const upper = (op & ~DELAY_AND_SIDE) >> JUMP_CONDITION_SHIFT;
  return upper < JUMPS ? upper : undefined;
}
