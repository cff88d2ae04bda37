/** Which pin is connected to what: the pin table of the gantry board. */
export const AXES = ['X', 'Y', 'Z'];
export const PINS = {
  X: { step: 2, dir: 3, limit: 9 },
  Y: { step: 4, dir: 5, limit: 10 },
  Z: { step: 6, dir: 7, limit: 11 },
};
/** The second motor of an axis: its name, its pins. Which axis it is on is a setting of the firmware. */
export const SECOND = '2';
export const SECOND_PINS = { step: 21, dir: 22, limit: 26 };
export const ENABLE_PIN = 8;
export const ESTOP_PIN = 12;
export const LED_PIN = 25;
/** Outputs of the chip to the tool. */
export const TOOL_OUTPUTS = { pwm: 13, enable: 14, direction: 15, flood: 16, mist: 17 };
/** Contacts to ground: the tool's probe, and the buttons for feed hold and cycle start. */
export const TOOL_INPUTS = { probe: 18, hold: 19, start: 20 };
export const STEPS_PER_MM = 50;

/** Every output that is recorded as a waveform, by name. */
export const NAMED_OUTPUTS = new Map([
  ...AXES.flatMap((axis) => [
    [PINS[axis].step, `${axis}_STEP`],
    [PINS[axis].dir, `${axis}_DIR`],
  ]),
  [SECOND_PINS.step, 'SECOND_STEP'],
  [SECOND_PINS.dir, 'SECOND_DIR'],
  [ENABLE_PIN, 'ENABLE_n'],
  [LED_PIN, 'LED'],
  ...Object.entries(TOOL_OUTPUTS).map(([output, pin]) => [pin, `TOOL_${output.toUpperCase()}`]),
]);

/** The inputs that are recorded as waveforms, by name. */
export const NAMED_INPUTS = new Map(Object.entries(TOOL_INPUTS).map(([input, pin]) => [pin, `${input.toUpperCase()}_n`]));
