const LAST_GPIO = 29;
const MOST_CYCLES = 125_000_000;
const MOST_EDGES = 2 ** 32;
const [PASSED, LOST] = ['passed', 'lost'];

/**
 * Faults of outputs that a test asks for, between what drives a pad and the pad: a pulse that comes late, or never. All
 * who see the pad see the same, outside the chip and inside.
 */
export class PadFaults {
  /**
   * @param {import('./clock.mjs').MachineClock} clock
   * @param {{pad: number, edge: number, cycles: number | null}[]} faults which rising edge of which pad, counted from 1 since
   *   the start of the run, and by how many cycles its pulse is late; null if it is lost
   */
  constructor(clock, faults) {
    const pads = new Set(faults.map(({ pad }) => pad));
    this.pads = [...pads].map((pad) => new FaultyPad(clock, pad, new Map(faults.filter((fault) => fault.pad === pad).map(({ edge, cycles }) => [edge, cycles ?? LOST]))));
  }

  /** Connects them to a chip that has just been powered or reset. Edges are counted on. */
  attach(chip) {
    for (const pad of this.pads) pad.attach(chip.gpio[pad.index]);
  }
}

/** A pad that is high while a pulse that passes is driven, or a late one has come and not ended. */
class FaultyPad {
  #clock;
  #faults;
  #pin = null;
  #edges = 0;
  #driven = false;
  /** What becomes of the pulse that is driven: it passes, is lost, or is late by this many cycles. */
  #fate = PASSED;
  #lateHigh = 0;
  #pending = new Set();

  constructor(clock, index, faults) {
    this.#clock = clock;
    this.index = index;
    this.#faults = faults;
  }

  attach(pin) {
    for (const alarm of this.#pending) alarm.cancel();
    this.#pending.clear();
    this.#pin = pin;
    this.#driven = false;
    this.#lateHigh = 0;
    const { checkForUpdates } = pin;
    const { get } = Object.getOwnPropertyDescriptor(Object.getPrototypeOf(pin), 'outputValue');
    pin.faulty = true;
    Object.defineProperty(pin, 'outputValue', { get: () => (this.#driven && this.#fate === PASSED) || this.#lateHigh > 0 });
    pin.checkForUpdates = () => {
      this.#drive(pin.outputEnable && get.call(pin));
      checkForUpdates.call(pin);
    };
  }

  #drive(high) {
    if (high === this.#driven) return;
    this.#driven = high;
    if (high) {
      this.#edges += 1;
      this.#fate = this.#faults.get(this.#edges) ?? PASSED;
    }
    if (typeof this.#fate === 'number') this.#later(this.#fate, high ? 1 : -1);
  }

  /** The edge of a late pulse comes to the pad. */
  #later(cycles, change) {
    const alarm = this.#clock.createOutsideAlarm(() => {
      this.#pending.delete(alarm);
      this.#lateHigh += change;
      this.#pin.checkForUpdates();
    });
    this.#pending.add(alarm);
    alarm.scheduleAt(this.#clock.cycles + cycles);
  }
}

/**
 * The faults of the options --shift-edge GP:N:CYCLES and --lose-edge GP:N.
 *
 * @param {string[]} shifted
 * @param {string[]} lost
 */
export function padFaultOptions(shifted, lost) {
  const faults = [...shifted.map((text) => shiftOption(text)), ...lost.map((text) => loseOption(text))];
  const edges = new Set(faults.map(({ pad, edge }) => `${pad}:${edge}`));
  if (edges.size < faults.length) throw new Error('--shift-edge and --lose-edge name an edge twice: give each edge one fault');
  return faults;
}

function shiftOption(text) {
  const remedy = `give a pad from 0 to ${LAST_GPIO}, the number of its rising edge from 1, and how many cycles later it comes, from 1 to ${MOST_CYCLES}, such as 2:100:5`;
  const [pad, edge, cycles] = numbers('--shift-edge', text, 3, remedy);
  if (!(cycles >= 1 && cycles <= MOST_CYCLES)) throw new Error(`--shift-edge ${text}: ${remedy}`);
  return { pad, edge, cycles };
}

function loseOption(text) {
  const [pad, edge] = numbers('--lose-edge', text, 2, `give a pad from 0 to ${LAST_GPIO} and the number of its rising edge from 1, such as 2:100`);
  return { pad, edge, cycles: null };
}

/** The whole numbers of an option, of which the first is a pad and the second an edge. */
function numbers(option, text, count, remedy) {
  const parts = text.split(':').map((part) => (/^[0-9]+$/.test(part) ? Number(part) : NaN));
  const [pad, edge] = parts;
  if (parts.length !== count || !(pad <= LAST_GPIO) || !(edge >= 1 && edge <= MOST_EDGES)) throw new Error(`${option} ${text}: ${remedy}`);
  return parts;
}
