import { Carriage } from './carriage.mjs';
import { SECOND, STEPS_PER_MM } from './pins.mjs';

const HIGH = 1;

/**
 * The second motor of an axis, at the other side of its gantry: a driver, a carriage and a switch of its own. It also
 * tells which of its steps came on the same cycle as one of the axis's first motor.
 */
export class SecondMotor {
  /**
   * @param {import('./gantry.mjs').Gantry} gantry
   * @param {{axis: string, skewMm: number}} options the axis, and how much farther from its switch than the first motor it stands
   */
  constructor(gantry, { axis, skewMm }, startMm, limitSwitch) {
    Object.assign(this, { gantry, axis, limitSwitch });
    this.carriage = new Carriage(startMm + skewMm, limitSwitch, gantry.endMm);
    this.direction = -1;
    this.lastCycle = { [axis]: -1, [SECOND]: -1 };
    /** Steps of both motors on one cycle, and steps of one alone. */
    this.together = 0;
    this.alone = 0;
    /** Called with (cycle) at every step of it. */
    this.stepWatchers = new Set();
    gantry.stepWatchers.add((cycle, stepped) => {
      if (stepped === axis) this.#pair(axis, SECOND, cycle);
    });
  }

  attach(chip) {
    this.direction = -1;
    const { step, dir } = this.gantry.board.second;
    chip.gpio[step].addListener((state, before) => this.#onStepPin(state === HIGH, before === HIGH));
    chip.gpio[dir].addListener((state, before) => this.#onDirPin(state === HIGH, before === HIGH));
  }

  /** How many steps farther from its switch it stands than the axis's first motor does from its own. */
  get fartherSteps() {
    return Math.round((this.carriage.placeMm - this.gantry.carriages[this.axis].placeMm) * STEPS_PER_MM);
  }

  /** @returns {{together: number, alone: number}} the steps since the last call */
  takeSteps() {
    const { together, alone } = this;
    [this.together, this.alone] = [0, 0];
    return { together, alone };
  }

  #pair(stepped, other, cycle) {
    this.lastCycle[stepped] = cycle;
    if (this.lastCycle[other] === cycle) {
      this.together += 1;
      this.alone -= 1;
    } else {
      this.alone += 1;
    }
  }

  #onStepPin(high, wasHigh) {
    if (high === wasHigh) return;
    const { clock, timing, stops } = this.gantry;
    if (!high) return timing.fall(SECOND, this.gantry.nanos);
    stops.step(SECOND, clock.cycles);
    if (timing.rise(SECOND, this.gantry.nanos)) this.gantry.move(SECOND, this.carriage, this.direction);
    this.#pair(SECOND, this.axis, clock.cycles);
    for (const watch of this.stepWatchers) watch(clock.cycles);
  }

  #onDirPin(high, wasHigh) {
    if (high === wasHigh) return;
    this.direction = high ? 1 : -1;
    this.gantry.timing.turn(SECOND, this.gantry.nanos);
    this.gantry.stops.turn();
  }
}
