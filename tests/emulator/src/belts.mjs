/**
 * Crossed belts (CoreXY, H-bot): the motors of X and Y move the carriage along both axes. The motor of X makes X + Y, that of Y
 * makes X - Y, so a step of either is half a step of each axis. An end of either axis keeps the whole step back, because the
 * other belt holds the carriage.
 */
export class Belts {
  #carriages;

  /** @param {Record<string, import('./carriage.mjs').Carriage>} carriages */
  constructor(carriages) {
    this.#carriages = carriages;
  }

  /** The axes that a motor moves. */
  static axesOf(motor) {
    return BOTH.includes(motor) ? BOTH : [motor];
  }

  /** Whether a hard end keeps a motor from a step. */
  blocked(motor, direction) {
    return this.#ways(motor, direction).some(([axis, steps]) => this.#carriages[axis].blocked(steps));
  }

  /** A step of a motor. One that is not driven, or is against a hard end of either axis, is lost. */
  step(motor, direction, driven = true) {
    const isMade = driven && !this.blocked(motor, direction);
    this.#carriages[motor].count(direction, isMade);
    if (!isMade) return;
    for (const [axis, steps] of this.#ways(motor, direction)) this.#carriages[axis].shift(steps);
  }

  /**
   * Where the axes are by the count of the motors, in steps. An axis that is half a step beside a whole one is at the one that is
   * nearer to zero, as the firmware has it.
   */
  placesOf(counted) {
    const [x, y, ...others] = counted;
    return [Math.trunc((x + y) / 2), Math.trunc((x - y) / 2), ...others];
  }

  /** An axis has been homed. The motors' counts become those of a machine that is at 0 there and, along the other axis, where it was. */
  home(axis) {
    const motors = BOTH.map((motor) => this.#carriages[motor]);
    const [x, y] = this.placesOf(motors.map(({ positionSteps }) => positionSteps)).map((steps, index) => (BOTH[index] === axis ? 0 : steps));
    [motors[0].positionSteps, motors[1].positionSteps] = [x + y, x - y];
  }

  /** How many steps each axis moves. */
  #ways(motor, direction) {
    const half = direction / 2;
    return [['X', half], ['Y', motor === 'Y' ? -half : half]];
  }
}

/** The axes that the belts move, and their motors. */
const BOTH = ['X', 'Y'];
