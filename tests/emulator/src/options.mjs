import { parseArgs } from 'node:util';
import { Belts } from './belts.mjs';
import { IS_RP2350 } from './clock.mjs';
import { DRIVERS } from './driver-timing.mjs';
import { ESTOP_CONTACTS } from './estop.mjs';
import { jumperOption } from './jumper.mjs';
import { SWITCH_MODES } from './limit-switch.mjs';
import { padFaultOptions } from './pad-faults.mjs';
import { AXES, AXES_USUAL, boardOf, BOARDS, SECOND } from './pins.mjs';
import { PLATE_SIDES, ProbePlate } from './probe-plate.mjs';
import { COMMANDS } from './script.mjs';
import { DRIVER_STATES } from './tmc2209-faults.mjs';

export const HELP = `Runs the firmware, unmodified, on an emulated Raspberry Pi Pico that drives three carriages.

Usage: node tests/emulator/run.mjs --elf ELF (--program FILE | --script FILE | --live) [options]

What to run
  --elf ELF            the firmware, as cargo xtask build leaves it in
                       target/thumbv6m-none-eabi/release/pico-gantry
  --program FILE       streams a G-code program, line by line as it is in the file, until all is answered and Idle
  --script FILE        runs a dialogue (see below); its transcript goes to stdout
  --live               does what another program asks on stdin (src/live.mjs): cargo xtask emulate --pty
  --serve              alone: carries out the command lines on stdin, each as JSON, in one process (tests/src/emulated/process.rs)
  --console usb|uart   the cable in use: USB CDC (default) or UART0 at the firmware's baud rate
  --stream wait|counting
                       send a line when the one before is answered (default), or count characters, 128 at most
  --poll-hz N          asks for status N times a second (default: 10 for a program, 0 for a script)
  --set N=VALUE        sends $N=VALUE ahead of the program's first line; may be given several times
  --timeout-s N        machine time to wait for a reply or for Idle (default 300)

The machine
  --board NAME         ${Object.keys(BOARDS).join(' or ')}: whose pins are wired, as the firmware was built for (default pico)
  --driver NAME        ${Object.keys(DRIVERS).join(' or ')}: whose least times every edge is held to (default: the board's)
  --start X,Y,Z        millimetres above the limit switches at power-up (default 35,40,15)
  --axes N             3 or 4, as the firmware was built (default 3)
  --second AXIS,MM     a second motor on this axis, so much farther from its switch than the first motor, such as Y,1.5
  --belts              crossed belts (CoreXY, for a firmware with $907=1): the motor of X moves X + Y, that of Y X - Y, each step
                       by half a step of both axes. Positions, edges and lost steps stay those of motors, places are the axes'
  --switch X=MODE      ${SWITCH_MODES.join(', ')}; may be given for each axis, and as 2 for the second motor
  --estop no|nc        the emergency stop's contact: normally open (default), or normally closed, as the firmware was built for
  --enable wired|open  whether ENABLE is connected to the drivers (default wired); where it is not, they are always on, as beside a
                       proving image, which keeps it off
  --driver-state X=STATE
                       of a UART driver (skr-pico) at power-up: ${DRIVER_STATES.join(', ')};
                       may be given for each axis, and as 2 for the second motor
  --vfd                a DURAPULSE GS20 and a module for RS-485 on the UART
  --diag X,Y,Z         jumpers from these drivers' DIAG to the axes' limit inputs, to which their switches are not wired then
  --hard-ends MM       an end so far beyond its switch blocks every carriage: its steps are lost there (default: nothing does)
  --probe-plate AXIS,MM,SIDE
                       a plate that closes the probe's contact while the axis is at its place, in millimetres above the
                       limit switch, or beyond it: ${PLATE_SIDES.join(' or ')}, such as Z,12.5,below
  --jumper FROM:TO     a wire between two pads, by their GP numbers, such as 28:9: while the firmware drives the first one low,
                       the other one reads low; may be given several times
  --frame-ppm N        the frames of the USB host, which it starts each millisecond, are N parts per million longer than the
                       chip's milliseconds, or shorter: --frame-ppm=-50 (default 0)
  --bounce-us N        the switches' contacts bounce for N microseconds (default 0)
  --seed N             of the bounces (default 1)
  --shift-edge GP:N:CYCLES
                       the Nth rising edge of this pad since the start comes so many cycles later, and its fall too: at the
                       pad, so that the gantry, what is written and the chip's inputs see the same; may be given several times
  --lose-edge GP:N     the Nth pulse of this pad since the start never comes to the pad; may be given several times
  --flash FILE         what flash holds beside the firmware: read from FILE at the start if it exists, written there at the
                       end, so that settings outlive the run
  --ideal-flash        flash reads like RAM, without its cache
  --miss-factor N      a word that is not in flash's cache costs N times the reckoned cycles (default 1)
  --core-factor N      of an RP2350, whose core has assumed timing: an instruction takes N times the assumed cycles, 1 or more
                       (default 1)

What to write
  --trace FILE         every rising edge of STEP: t_ns,axis,direction,position_steps
  --edges FILE         the same in eight bytes an edge: cycle * 8 + axis (0, 1, 2, 3) * 2 + (1 if DIR is up), little-endian
  --outputs FILE       every change of the tool's outputs: t_ns,output,value (pwm as a duty from 0 to 1, enable, direction, flood
                       and mist as 0 or 1); all are 0 before their first
  --transcript FILE    every line sent and received, with its machine time
  --json FILE          the summary
  --vcd FILE           STEP, DIR, ENABLE, LED, the tool's outputs and inputs, for a wave viewer
  --profile FILE       what the core spent on each instruction of flash and RAM: address,executions,in_motion,cycles; an
                       instruction's cycles have what the ROM and flash's cache took of them
  --progress           a line of progress on stderr each second, even if stderr is no terminal
  --help               this text

A script has a command a line; # begins a comment:
${Object.values(COMMANDS).map(({ usage }) => `  ${usage}`).join('\n')}
Each begins when the one before is done. expect takes the next reply (ok, error:N) or the next status (<...), which must
begin with the prefix; for anything else (Grbl, ALARM:, [MSG:) it waits until such a line comes. wait-edge waits for the next
STEP, wait-output until an output of the tool is so, wait-arrival until the chip has all that was sent, and a wait right after it
counts from that instant. From MICROSECONDS after stop-within to check-stopped there must be no step, and then no output of the tool on.
crash, hang and panic end the firmware, the second with interrupts masked; after hang MILLISECONDS it goes on.
mask-irq has what runs in one stand still until unmask-irq; check-position holds MPos against the counted steps; cold-cache
empties flash's cache, so that what runs next waits for flash. An example:
  expect Grbl
  send $H
  wait-ms 500
  bytes 18
  expect ALARM:6

Machine time is cycles of 125 MHz; no result depends on the wall clock. The exit code is 0 only if everything went through:
all lines answered with ok, Idle at the end, no driver timing violated and no reset that the script did not wait for.`;

/** Where the carriages stand at power-up, mm (or degrees) above their switches. */
const START = [35, 40, 15, 15];

/** More than any crystal is off, and than a USB host may be (500). */
const MOST_PPM = 10_000;

const SPEC = {
  elf: { type: 'string' },
  program: { type: 'string' },
  script: { type: 'string' },
  live: { type: 'boolean', default: false },
  serve: { type: 'boolean', default: false },
  console: { type: 'string', default: 'usb' },
  stream: { type: 'string' },
  'poll-hz': { type: 'string' },
  set: { type: 'string', multiple: true, default: [] },
  'timeout-s': { type: 'string' },
  board: { type: 'string', default: 'pico' },
  driver: { type: 'string' },
  start: { type: 'string' },
  axes: { type: 'string', default: '3' },
  second: { type: 'string' },
  belts: { type: 'boolean', default: false },
  switch: { type: 'string', multiple: true, default: [] },
  estop: { type: 'string', default: 'no' },
  enable: { type: 'string', default: 'wired' },
  'driver-state': { type: 'string', multiple: true, default: [] },
  diag: { type: 'string' },
  vfd: { type: 'boolean', default: false },
  'hard-ends': { type: 'string' },
  'probe-plate': { type: 'string' },
  jumper: { type: 'string', multiple: true, default: [] },
  'shift-edge': { type: 'string', multiple: true, default: [] },
  'lose-edge': { type: 'string', multiple: true, default: [] },
  'frame-ppm': { type: 'string', default: '0' },
  'bounce-us': { type: 'string', default: '0' },
  seed: { type: 'string', default: '1' },
  flash: { type: 'string' },
  'ideal-flash': { type: 'boolean', default: false },
  'miss-factor': { type: 'string' },
  'core-factor': { type: 'string' },
  trace: { type: 'string' },
  edges: { type: 'string' },
  outputs: { type: 'string' },
  transcript: { type: 'string' },
  json: { type: 'string' },
  vcd: { type: 'string' },
  profile: { type: 'string' },
  progress: { type: 'boolean', default: false },
  help: { type: 'boolean', default: false },
};

/** The command line, checked. @param {string[]} args */
export function parseOptions(args) {
  const { values } = parseArgs({ args, options: SPEC, strict: true, allowPositionals: false });
  if (values.help) return { help: true };
  if (values.serve) return { serve: true };
  if (values.elf === undefined) throw new Error('which firmware? Give --elf target/thumbv6m-none-eabi/release/pico-gantry, which cargo xtask build makes');
  const jobs = [values.program, values.script, values.live || undefined].filter((job) => job !== undefined);
  if (jobs.length !== 1) throw new Error('give either --program FILE, --script FILE or --live (--help shows them)');
  if (values.set.length > 0 && values.program === undefined) throw new Error('--set goes with --program: others send their own settings');
  if (values.live) {
    const idle = ['stream', 'poll-hz', 'timeout-s', 'progress'].find((name) => values[name]);
    if (idle !== undefined) throw new Error(`--${idle} is for a program or a script: who drives a live board sends and polls as it likes`);
  }
  return {
    ...values,
    console: choice('--console', ['usb', 'uart'], values.console),
    stream: choice('--stream', ['wait', 'counting'], values.stream ?? 'wait'),
    settings: values.set.map(settingLine),
    pollHz: number('--poll-hz', values['poll-hz'] ?? (values.program ? '10' : '0'), 0, 1000),
    timeoutSeconds: number('--timeout-s', values['timeout-s'] ?? '300', 0.001, 1e6),
    board: choice('--board', Object.keys(BOARDS), values.board),
    driver: choice('--driver', Object.keys(DRIVERS), values.driver ?? BOARDS[values.board]?.driver ?? ''),
    estop: choice('--estop', ESTOP_CONTACTS, values.estop),
    enable: choice('--enable', ['wired', 'open'], values.enable),
    axes: Number(choice('--axes', ['3', '4'], values.axes)),
    startMm: places(values.start ?? START.slice(0, AXES_USUAL).join(','), Number(values.axes)),
    second: values.second === undefined ? null : secondOption(values.second, values.belts),
    switches: Object.fromEntries(values.switch.map(switchOption)),
    ...driverOptions(values),
    vfd: vfdOption(values),
    hardEndsMm: values['hard-ends'] === undefined ? null : number('--hard-ends', values['hard-ends'], 0, 1000),
    probePlate: values['probe-plate'] === undefined ? null : plateOption(values['probe-plate']),
    jumpers: values.jumper.map(jumperOption),
    padFaults: padFaultOptions(values['shift-edge'], values['lose-edge']),
    framePpm: number('--frame-ppm', values['frame-ppm'], -MOST_PPM, MOST_PPM),
    bounceMicros: number('--bounce-us', values['bounce-us'], 0, 1e6),
    seed: number('--seed', values.seed, 0, 2 ** 32 - 1),
    missFactor: missFactor(values['ideal-flash'], values['miss-factor']),
    coreFactor: coreFactor(values['core-factor']),
  };
}

function choice(name, allowed, value) {
  if (!allowed.includes(value)) throw new Error(`${name} ${value}: choose ${allowed.join(' or ')}`);
  return value;
}

function number(name, text, least, most) {
  const value = Number(text);
  if (text.trim() === '' || !(value >= least && value <= most)) throw new Error(`${name} ${text}: give a number from ${least} to ${most}`);
  return value;
}

/** Ideal flash has no misses. */
function missFactor(ideal, factor) {
  if (ideal && factor !== undefined) throw new Error('--ideal-flash has no misses: leave --miss-factor out');
  return ideal ? null : number('--miss-factor', factor ?? '1', 0, 1000);
}

/** How many cycles an instruction of an RP2040 takes is known. */
function coreFactor(factor) {
  if (factor !== undefined && !IS_RP2350) throw new Error(`--core-factor ${factor}: the timing of an RP2040's core is not assumed: leave it out, or take the firmware of an RP2350`);
  return number('--core-factor', factor ?? '1', 1, 100);
}

function settingLine(text) {
  if (!/^[0-9]+=[0-9.]+$/.test(text)) throw new Error(`--set ${text}: give a setting's number and its value, such as 940=1`);
  return `$${text}\n`;
}

function places(text, axes) {
  const given = text.split(',');
  // A may be left out.
  const parts = given.length === AXES_USUAL ? [...given, ...START.slice(AXES_USUAL, axes).map(String)] : given;
  if (parts.length !== axes) throw new Error(`--start ${text}: give ${axes} places in mm, such as ${START.slice(0, axes)}`);
  return parts.map((part) => number('--start', part, -1000, 1000));
}

function secondOption(text, belts) {
  const [axis, mm] = text.split(',');
  if (belts && Belts.axesOf(axis).length > 1) throw new Error(`--second ${text}: with --belts ${axis} has two motors already: give another axis, or leave one of the options out`);
  return { axis: choice('--second axis', AXES, axis), skewMm: number('--second skew', mm ?? '0', -100, 100) };
}

function switchOption(text) {
  const [axis, mode] = text.split('=');
  return [choice('--switch axis', [...AXES, SECOND], axis), choice('--switch mode', SWITCH_MODES, mode)];
}

/** What is set about UART drivers, which not every board has. */
function driverOptions({ board, 'driver-state': states, diag }) {
  const wire = BOARDS[board]?.tmcWire;
  const [given] = [...(diag === undefined ? [] : ['--diag']), ...(states.length === 0 ? [] : ['--driver-state'])];
  if (given !== undefined && !wire) throw new Error(`${given}: the drivers of a ${board} have no UART: use --board skr-pico`);
  return {
    diag: diag === undefined ? [] : diag.split(',').map((axis) => choice('--diag', wire.diag, axis)),
    driverStates: states.map(driverStateOption),
  };
}

/** Whether a VFD is connected, which takes the UART and a pad. */
function vfdOption({ board, axes, console, vfd }) {
  if (vfd && (console === 'uart' || !boardOf(board, Number(axes))?.vfdWire)) throw new Error(`--vfd: its wire needs the UART and a pad: use --console usb, and no ${board} of five motors`);
  return vfd;
}

function driverStateOption(text) {
  const [motor, state] = text.split('=');
  return [choice('--driver-state motor', [...AXES, SECOND], motor), choice('--driver-state', DRIVER_STATES, state)];
}

function plateOption(text) {
  const [axis, mm, side, ...more] = text.split(',');
  if (side === undefined || more.length > 0) throw new Error(`--probe-plate ${text}: give an axis, a place in mm and a side, such as Z,12.5,below`);
  const place = number('--probe-plate place', mm, -1000, 1000);
  return new ProbePlate(choice('--probe-plate axis', AXES, axis), place, choice('--probe-plate side', PLATE_SIDES, side));
}
