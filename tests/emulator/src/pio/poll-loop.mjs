/**
 * Rounds of a program that jumps by the level of a pin and otherwise only counts X or Y down, such as
 * `low: jmp pin high` and `jmp x-- low`. While the level stays, and until a counter has reached 0, every round takes the
 * same cycles and the same counts, so the machine goes round without being stepped.
 */
export class PollLoop {
  constructor() {
    /** The pin that is looked at, as a bit. */
    this.pins = 0;
    /** Its level while the machine goes round, as that bit. */
    this.levels = 0;
    /** The cycles of a round. */
    this.round = 0;
    /** How often a round counts X and Y down. */
    this.xCounts = 0;
    this.yCounts = 0;
    /** When the machine has to look for itself, because a counter is about to end the rounds. */
    this.endsAt = Infinity;
  }

  /**
   * The machine is about to jump by the level of its pin.
   *
   * @param {import('./state-machine.mjs').StateMachine} machine
   * @param {{cycles: number, xCounts: number, yCounts: number}} polling the round that begins with this level
   * @returns {boolean} whether it goes round, twice at least
   */
  comesRound(machine, polling, pins, levels) {
    const rounds = Math.min(roundsOf(machine.x, polling.xCounts), roundsOf(machine.y, polling.yCounts));
    if (rounds < 2) return false;
    this.pins = pins;
    this.levels = levels;
    this.round = polling.cycles;
    this.xCounts = polling.xCounts;
    this.yCounts = polling.yCounts;
    this.endsAt = machine.next + rounds * polling.cycles;
    return true;
  }

  /** Makes up for rounds that the machine has gone without being stepped. */
  takeRounds(machine, rounds) {
    machine.x = (machine.x - rounds * this.xCounts) | 0;
    machine.y = (machine.y - rounds * this.yCounts) | 0;
  }
}

/** How many rounds a register lasts. Each count but the last finds it above 0. */
function roundsOf(register, counts) {
  return counts === 0 ? Infinity : Math.floor((register >>> 0) / counts);
}
