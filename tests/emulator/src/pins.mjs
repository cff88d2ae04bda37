/** Which pin is connected to what: the tables of the boards, as in boards/pico-gantry/src/pins. */
export const AXES = ['X', 'Y', 'Z', 'A'];
/** How many of them a firmware has that was not built for four. */
export const AXES_USUAL = 3;
/** The second motor of an axis: its name. Which axis it is on is a setting of the firmware. */
export const SECOND = '2';
export const STEPS_PER_MM = 50;

/** The fourth motor, which is A's or the second one of an axis, and the state machine that makes its steps. */
const FOURTH_MACHINE = { block: 0, index: 3 };
const PICO_FOURTH = { step: 21, dir: 22, limit: 26, enable: 8, machine: FOURTH_MACHINE };
const SKR_PICO_FOURTH = { step: 14, dir: 13, limit: 26, enable: 15, machine: FOURTH_MACHINE };

/** A Pico and a Pico 2 have the same pins. */
const PICO = {
  driver: 'drv8825',
  axes: {
    X: { step: 2, dir: 3, limit: 9, enable: 8 },
    Y: { step: 4, dir: 5, limit: 10, enable: 8 },
    Z: { step: 6, dir: 7, limit: 11, enable: 8 },
    A: PICO_FOURTH,
  },
  second: PICO_FOURTH,
  estop: 12,
  led: 25,
  tool: { pwm: 13, enable: 14, direction: 15, flood: 16, mist: 17 },
  contacts: { probe: 18, hold: 19, start: 20, alarm: 27 },
  tmcWire: null,
  vfdWire: { tx: 0, rx: 1, sends: 28 },
};

/** A Pico 2 with four axes has a fifth motor too. Its switch is where the button for cycle start would be. */
const PICO2_OF_FIVE = { ...PICO, second: { step: 27, dir: 28, limit: 20, enable: 8, machine: { block: 2, index: 0 } }, contacts: { probe: 18, hold: 19 }, vfdWire: null };

/**
 * Whose drivers it has, or is taken to have. For each axis, and the second motor of one, its STEP and DIR, its limit switch, and ENABLE of its driver. Then the emergency stop, the LED if there is one,
 * the outputs to the tool, and contacts to ground: the tool's probe, the buttons for feed hold and cycle start, and the alarm of drives.
 * Then the wire to UART drivers, if it has any: its pads, the drivers' addresses, and the axes whose limit input a jumper
 * connects with DIAG. Last the wire to a VFD, if it has a pad that says when it sends.
 */
export const BOARDS = {
  pico: PICO,
  pico2: PICO,
  'skr-pico': {
    driver: 'tmc2209',
    axes: {
      X: { step: 11, dir: 10, limit: 4, enable: 12 },
      Y: { step: 6, dir: 5, limit: 3, enable: 7 },
      Z: { step: 19, dir: 28, limit: 25, enable: 2 },
      A: SKR_PICO_FOURTH,
    },
    second: SKR_PICO_FOURTH,
    estop: 16,
    led: null,
    tool: { pwm: 20, enable: 17, direction: 18, flood: 21, mist: 23 },
    contacts: { probe: 22, hold: 29, start: 27 },
    tmcWire: { tx: 8, rx: 9, addresses: { X: 0, Y: 2, Z: 1, A: 3 }, diag: ['X', 'Y', 'Z'] },
    vfdWire: { tx: 0, rx: 1, sends: 24 },
  },
};
/** The pins of a board with firmware for so many axes. */
export const boardOf = (name, axes) => (name === 'pico2' && axes > AXES_USUAL ? PICO2_OF_FIVE : BOARDS[name]);

/** The outputs to the tool, by name. */
export const TOOL_OUTPUTS = Object.keys(BOARDS.pico.tool);

/** Every output of a board that is recorded as a waveform, by name. @param {string[]} axes those that the firmware has */
export const namedOutputs = (board, axes) => new Map([
  [board.second.step, 'SECOND_STEP'],
  [board.second.dir, 'SECOND_DIR'],
  ...axes.flatMap((axis) => [
    [board.axes[axis].step, `${axis}_STEP`],
    [board.axes[axis].dir, `${axis}_DIR`],
  ]),
  [board.axes.X.enable, 'ENABLE_n'],
  ...(board.led === null ? [] : [[board.led, 'LED']]),
  ...TOOL_OUTPUTS.map((output) => [board.tool[output], `TOOL_${output.toUpperCase()}`]),
]);

/** The inputs of a board that are recorded as waveforms, by name. */
export const namedInputs = (board) => new Map(Object.entries(board.contacts).map(([input, pin]) => [pin, `${input.toUpperCase()}_n`]));
