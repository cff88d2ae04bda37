export const HEADER = 't_ns,axis,direction,position_steps';

/** The step trace: a row for every rising edge of STEP. */
export class StepTrace {
  constructor() {
    this.rows = [HEADER];
  }

  step(nanos, axis, direction, positionSteps) {
    this.rows.push(`${nanos},${axis},${direction},${positionSteps}`);
  }

  toString() {
    return this.rows.join('\n') + '\n';
  }
}
