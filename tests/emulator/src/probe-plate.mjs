export const PLATE_SIDES = ['below', 'above'];
/** Far smaller than a step, and far larger than rounding errors of a position. */
const TOLERANCE_MM = 1e-6;

/** A plate on one axis. It touches the probe at its place and beyond. */
export class ProbePlate {
  /**
   * @param {string} axis
   * @param {number} mm above the axis's limit switch
   * @param {'below' | 'above'} side on which side of the place it touches
   */
  constructor(axis, mm, side) {
    Object.assign(this, { axis, mm, side });
  }

  /** @param {number} placeMm where the carriage is */
  touches(placeMm) {
    return this.side === 'below' ? placeMm <= this.mm + TOLERANCE_MM : placeMm >= this.mm - TOLERANCE_MM;
  }
}
