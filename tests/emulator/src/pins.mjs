/** Which pin is connected to what: the pin table of the gantry board. */
export const AXES = ['X', 'Y', 'Z', 'A'];
/** How many of them a firmware has that was not built for four. */
export const AXES_USUAL = 3;
export const PINS = {
  X: { step: 2, dir: 3, limit: 9 },
  Y: { step: 4, dir: 5, limit: 10 },
  Z: { step: 6, dir: 7, limit: 11 },
  A: { step: 21, dir: 22, limit: 26 },
};
/** The second motor of an axis: its name, and its pins, which are those of A. Which axis it is on is a setting of the firmware. */
export const SECOND = '2';
export const SECOND_PINS = PINS.A;
export const ENABLE_PIN = 8;
export const ESTOP_PIN = 12;
export const LED_PIN = 25;
/** Outputs of the chip to the tool. */
export const TOOL_OUTPUTS = { pwm: 13, enable: 14, direction: 15, flood: 16, mist: 17 };
/** Contacts to ground: the tool's probe, and the buttons for feed hold and cycle start. */
export const TOOL_INPUTS = { probe: 18, hold: 19, start: 20 };
export const STEPS_PER_MM = 50;

/** Every output that is recorded as a waveform, by name. @param {string[]} axes those that the firmware has */
export const namedOutputs = (axes) => new Map([
  [SECOND_PINS.step, 'SECOND_STEP'],
  [SECOND_PINS.dir, 'SECOND_DIR'],
  ...axes.flatMap((axis) => [
    [PINS[axis].step, `${axis}_STEP`],
    [PINS[axis].dir, `${axis}_DIR`],
  ]),
  [ENABLE_PIN, 'ENABLE_n'],
  [LED_PIN, 'LED'],
  ...Object.entries(TOOL_OUTPUTS).map(([output, pin]) => [pin, `TOOL_${output.toUpperCase()}`]),
]);

/** The inputs that are recorded as waveforms, by name. */
export const NAMED_INPUTS = new Map(Object.entries(TOOL_INPUTS).map(([input, pin]) => [pin, `${input.toUpperCase()}_n`]));
