import { kindOf } from './console.mjs';
import { cyclesOfMicros } from './clock.mjs';
import { differences } from './position-check.mjs';
import { SWITCH_MODES } from './limit-switch.mjs';
import { DRIVER_STATES } from './tmc2209-faults.mjs';
import { VFD_STATES } from './vfd.mjs';
import { AXES, SECOND, TOOL_OUTPUTS } from './pins.mjs';
import { PLATE_SIDES, ProbePlate } from './probe-plate.mjs';
import { Stillness } from './stillness.mjs';

const STATUS_REQUEST = Uint8Array.of(0x3f);

/** The script's commands: the argument of each, and what it does. */
export const COMMANDS = {
  send: { usage: 'send TEXT', parse: (rest) => new TextEncoder().encode(`${rest}\n`), run: (script, bytes) => script.console.sendLine(bytes) },
  bytes: { usage: 'bytes HEX HEX ...', parse: hexBytes, run: (script, bytes) => script.console.send(bytes) },
  expect: { usage: 'expect PREFIX', parse: some, run: (script, prefix) => script.expect(prefix) },
  'wait-reply': { usage: 'wait-reply', parse: nothing, run: (script) => script.expect('', 'reply') },
  'wait-idle': { usage: 'wait-idle', parse: nothing, run: (script) => script.console.waitIdle(script.timeoutSeconds) },
  'wait-reset': { usage: 'wait-reset', parse: nothing, run: (script) => script.waitReset() },
  'expect-bootsel': { usage: 'expect-bootsel', parse: nothing, run: (script) => script.expectBootsel() },
  'leave-bootsel': { usage: 'leave-bootsel', parse: nothing, run: (script) => script.leaveBootsel() },
  'power-cycle': { usage: 'power-cycle', parse: nothing, run: (script) => script.powerCycle() },
  'wait-ms': { usage: 'wait-ms MILLISECONDS', parse: positive, run: (script, millis) => script.waitMicros(millis * 1000) },
  'wait-us': { usage: 'wait-us MICROSECONDS', parse: positive, run: (script, micros) => script.waitMicros(micros) },
  'wait-edge': { usage: 'wait-edge', parse: nothing, run: (script) => script.waitEdge() },
  'wait-output': { usage: `wait-output ${TOOL_OUTPUTS.join('|')} on|off`, parse: outputState, run: (script, [output, on]) => script.waitOutput(output, on) },
  'wait-arrival': { usage: 'wait-arrival', parse: nothing, run: (script) => script.waitArrival() },
  'stop-within': { usage: 'stop-within MICROSECONDS', parse: positive, run: (script, micros) => script.stopWithin(micros) },
  'check-stopped': { usage: 'check-stopped', parse: nothing, run: (script) => script.checkStopped() },
  'check-position': { usage: 'check-position', parse: nothing, run: (script) => script.checkPosition() },
  'cold-cache': { usage: 'cold-cache', parse: nothing, run: (script) => script.board.cache.empty() },
  switch: { usage: `switch X|Y|Z|A|2 ${SWITCH_MODES.join('|')}`, parse: switchMode, run: (script, [name, mode]) => script.switchOf(name).setMode(mode) },
  driver: { usage: `driver X|Y|Z|A|2 ${DRIVER_STATES.join('|')}`, parse: driverState, run: (script, [motor, state]) => script.driverOf(motor).set(state) },
  vfd: { usage: `vfd ${VFD_STATES.join('|')}`, parse: vfdState, run: (script, state) => script.vfd.set(state) },
  'check-square': { usage: 'check-square STEPS', parse: whole, run: (script, steps) => script.checkSquare(steps) },
  'count-together': { usage: 'count-together', parse: nothing, run: (script) => void script.second.takeSteps() },
  'check-together': { usage: 'check-together', parse: nothing, run: (script) => script.checkTogether() },
  'miscount-second': { usage: 'miscount-second', parse: nothing, run: (script) => script.board.miscountSecond() },
  estop: { usage: 'estop pressed|released|cut|mended', parse: estopState, run: (script, change) => script.board.gantry.changeEstop(change) },
  probe: { usage: 'probe pressed|released', parse: pressed, run: (script, down) => script.board.gantry.probe.press(down) },
  'probe-plate': { usage: 'probe-plate X|Y|Z MM below|above, or probe-plate none', parse: plate, run: (script, plate) => script.board.gantry.probe.setPlate(plate) },
  hold: { usage: 'hold pressed|released', parse: pressed, run: (script, down) => script.board.gantry.pressButton('hold', down) },
  start: { usage: 'start pressed|released', parse: pressed, run: (script, down) => script.board.gantry.pressButton('start', down) },
  alarm: { usage: 'alarm pressed|released', parse: pressed, run: (script, down) => script.board.gantry.changeAlarm(down) },
  motors: { usage: 'motors on|off', parse: onOff, run: (script, on) => script.expectMotors(on) },
  crash: { usage: 'crash', parse: nothing, run: (script) => script.board.crash() },
  hang: { usage: 'hang, or hang MILLISECONDS', parse: positiveIfAny, run: (script, millis) => script.board.hang(millis) },
  'mask-irq': { usage: 'mask-irq NUMBER, an interrupt of the chip', parse: irq, run: (script, number) => script.board.maskIrq(number) },
  'unmask-irq': { usage: 'unmask-irq NUMBER, an interrupt of the chip', parse: irq, run: (script, number) => script.board.unmaskIrq(number) },
  panic: { usage: 'panic HEX, the address of a function that panics', parse: address, run: (script, at) => script.board.panic(at) },
  dtr: { usage: 'dtr on|off', parse: onOff, run: (script, on) => script.board.cable.setDtr(on) },
  'usb-line-coding': { usage: 'usb-line-coding BAUD', parse: baud, run: (script, rate) => script.board.cable.setLineCoding(rate) },
  reading: { usage: 'reading on|off', parse: onOff, run: (script, on) => script.board.cable.setReading(on) },
};

/**
 * A script's commands; empty lines and lines that begin with # are comments.
 *
 * @param {string} text
 * @returns {{number: number, source: string, word: string, argument: unknown}[]}
 */
export function parseScript(text) {
  const lines = text.split(/\r?\n/).map((source, index) => ({ number: index + 1, source: source.trimStart() }));
  return lines.filter(({ source }) => source.trim() !== '' && !source.startsWith('#')).map(parseLine);
}

function parseLine({ number, source }) {
  const [, word, rest] = /^(\S+)[ \t]?(.*)$/.exec(source);
  const command = COMMANDS[word];
  if (command === undefined) throw new Error(`script line ${number}: no command ${word}; there are ${Object.keys(COMMANDS).join(', ')}`);
  try {
    return { number, source, word, argument: command.parse(rest) };
  } catch (error) {
    throw new Error(`script line ${number}: ${error.message}; write: ${command.usage}`);
  }
}

/** Runs a script on the board. Each command starts at the machine time at which the previous one ended. */
export class ScriptRun {
  constructor(console, commands, { pollHz, timeoutSeconds }) {
    Object.assign(this, { console, commands, pollHz, timeoutSeconds, board: console.board, resetsSeen: 0, bootselSeen: false, edgeCycle: null, stillness: null });
  }

  run() {
    if (this.pollHz > 0) this.console.pollEvery(this.pollHz);
    for (const command of this.commands) {
      this.at = command.number;
      this.console.transcript.note(this.board.nanos, command.source);
      try {
        this.carryOut(command);
      } catch (error) {
        throw new Error(`script line ${command.number} (${command.source}): ${error.message}`);
      }
    }
  }

  carryOut({ word, argument }) {
    this.from = this.edgeCycle ?? this.board.clock.cycles;
    this.edgeCycle = null;
    COMMANDS[word].run(this, argument);
  }

  /** The script itself checks the replies. A reset that it did not wait for is a failure. */
  verdict() {
    const { resets, bootsel } = this.board;
    if (bootsel !== null && !this.bootselSeen) return `the firmware rebooted into BOOTSEL at ${(bootsel.t_ns / 1e9).toFixed(6)} s`;
    return resets.length > this.resetsSeen ? `the watchdog reset the board at ${(resets[this.resetsSeen].t_ns / 1e9).toFixed(6)} s` : null;
  }

  describe() {
    return `script line ${this.at} of ${this.commands.at(-1)?.number ?? 0}`;
  }

  /** The next reply or status must begin with the prefix. Other messages are searched for one that does. */
  expect(prefix, kind = /^(ok|error)/.test(prefix) ? 'reply' : kindOf(prefix)) {
    const next = () => this.console.take(kind, kind === 'message' ? prefix : '');
    const { text } = this.console.waitFor(`line beginning ${prefix || kind}`, next, this.timeoutSeconds);
    if (!text.startsWith(prefix)) throw new Error(`got ${text}`);
  }

  /** In BOOTSEL, the state in which the firmware left the motors counts. */
  expectMotors(on) {
    const { bootsel, gantry } = this.board;
    const energised = bootsel?.energised ?? (on ? gantry.timing.energised : gantry.hasDriverOn);
    if (energised !== on) throw new Error(`ENABLE ${energised ? 'energises' : 'frees'} the motors`);
  }

  waitMicros(micros) {
    const until = this.from + cyclesOfMicros(micros);
    while (this.board.clock.cycles < until) this.board.run(until);
  }

  /** Waits until the next rising edge of STEP on any axis. A wait that follows counts from the edge itself. */
  waitEdge() {
    const { board } = this;
    const { stepWatchers } = board.gantry;
    let edgeCycle = null;
    const watch = (cycle) => {
      edgeCycle ??= cycle;
      board.pause();
    };
    stepWatchers.add(watch);
    try {
      this.edgeCycle = this.console.waitFor('STEP edge', () => edgeCycle, this.timeoutSeconds);
    } finally {
      stepWatchers.delete(watch);
    }
  }

  /** Waits until an output of the tool is on or off. A wait that follows counts from the change itself. */
  waitOutput(output, on) {
    const { board } = this;
    const { tool } = board.gantry;
    let cycleSeen = this.#isOn(output) === on ? board.clock.cycles : null;
    const watch = (cycle) => {
      if (this.#isOn(output) !== on) return;
      cycleSeen ??= cycle;
      board.pause();
    };
    tool.watchers.add(watch);
    try {
      this.edgeCycle = this.console.waitFor(`output ${output} ${on ? 'on' : 'off'}`, () => cycleSeen, this.timeoutSeconds);
    } finally {
      tool.watchers.delete(watch);
    }
  }

  #isOn(output) {
    return this.board.gantry.tool.values[output] > 0;
  }

  /** Waits until everything sent has reached the chip. A wait that follows counts from that instant. */
  waitArrival() {
    const { board } = this;
    const { onDelivered } = board;
    let cycle = board.cable.unsent === 0 ? board.clock.cycles : null;
    board.onDelivered = () => {
      onDelivered();
      if (board.cable.unsent === 0) cycle ??= board.clock.cycles;
      board.pause();
    };
    try {
      this.edgeCycle = this.console.waitFor('arrival of what was sent', () => cycle, this.timeoutSeconds);
    } finally {
      board.onDelivered = onDelivered;
    }
  }

  /** No step may come later than this time, counted from now or from the event that was just waited for. */
  stopWithin(micros) {
    this.stillness ??= new Stillness(this.board.gantry);
    this.stillness.from(this.from + cyclesOfMicros(micros));
  }

  checkStopped() {
    const breach = this.stillness === null ? 'nothing was to be still: stop-within first' : this.stillness.end();
    if (breach !== null) throw new Error(breach);
  }

  /**
   * Requests the position and compares it with the edges that left. Steps that are made during the request may be
   * counted or not.
   */
  checkPosition() {
    const counted = () => this.board.gantry.countedSteps();
    const before = counted();
    this.console.inbox.status = [];
    this.console.send(STATUS_REQUEST);
    const { text } = this.console.waitFor('status', () => this.console.take('status'), this.timeoutSeconds);
    const after = counted();
    // Of two belts that turn against each other one steps first.
    const slack = this.board.gantry.belts !== null && after.some((steps, axis) => steps !== before[axis]) ? 1 : 0;
    const found = differences(text, before, after, slack);
    if (found.length > 0) throw new Error(found.join('; '));
  }

  switchOf(name) {
    return this.board.gantry.limitSwitch(name) ?? noSecond();
  }

  driverOf(motor) {
    const { drivers } = this.board.gantry;
    if (drivers === null) throw new Error('the drivers of this board have no UART: --board skr-pico has some that do');
    return drivers.of(motor);
  }

  get vfd() {
    const { vfdWire } = this.board.gantry;
    if (vfdWire === null) throw new Error('no VFD is connected: use --vfd');
    return vfdWire.vfd;
  }

  get second() {
    return this.board.gantry.second ?? noSecond();
  }

  /** The second motor stands as many steps farther from its switch than the first, or one more or less. */
  checkSquare(steps) {
    const { fartherSteps } = this.second;
    if (Math.abs(fartherSteps - steps) > 1) throw new Error(`the second motor stands ${fartherSteps} steps farther`);
  }

  /** Since count-together both motors have made the same steps, on the same cycles. */
  checkTogether() {
    const { together, alone } = this.second.takeSteps();
    if (alone !== 0 || together === 0) throw new Error(`${together} steps of both motors, ${alone} of one alone`);
  }

  waitReset() {
    this.console.waitFor('watchdog reset', () => (this.board.resets.length > this.resetsSeen ? true : null), this.timeoutSeconds);
    this.resetsSeen += 1;
  }

  /**
   * Waits until the firmware has asked the ROM for BOOTSEL. No command that talks to the board may follow before
   * leave-bootsel.
   */
  expectBootsel() {
    this.console.waitFor('BOOTSEL', () => this.board.bootsel, this.timeoutSeconds);
    this.bootselSeen = true;
  }

  leaveBootsel() {
    if (this.board.bootsel === null) throw new Error('the board is not in BOOTSEL: expect-bootsel first');
    this.board.leaveBootsel();
    this.console.forgetUnanswered();
    this.bootselSeen = false;
  }

  /** After this, nothing sent before is answered. */
  powerCycle() {
    if (this.board.bootsel !== null) throw new Error('the board is in BOOTSEL: it is a drive');
    this.board.powerCycle();
    this.console.forgetUnanswered();
  }
}

function some(rest) {
  if (rest.trim() === '') throw new Error('what to expect is missing');
  return rest;
}

function noSecond() {
  throw new Error('there is no second motor: --second gives an axis one');
}

function whole(rest) {
  if (!Number.isInteger(Number(rest)) || rest.trim() === '') throw new Error(`${rest || 'nothing'} is not a whole number`);
  return Number(rest);
}

function nothing(rest) {
  if (rest.trim() !== '') throw new Error(`nothing goes after it, not ${rest}`);
}

function positive(rest) {
  if (!(Number(rest) > 0)) throw new Error(`${rest || 'nothing'} is not a positive number`);
  return Number(rest);
}

/** For ever without a number. */
function positiveIfAny(rest) {
  return rest.trim() === '' ? null : positive(rest);
}

function baud(rest) {
  if (!/^[1-9]\d{0,9}$/.test(rest.trim()) || Number(rest) > 0xffffffff) throw new Error(`${rest || 'nothing'} is not a baud rate from 1 to 4294967295`);
  return Number(rest);
}

function irq(rest) {
  if (!/^\d{1,2}$/.test(rest.trim()) || Number(rest) > 31) throw new Error(`${rest || 'nothing'} is not an interrupt from 0 to 31`);
  return Number(rest);
}

function hexBytes(rest) {
  const words = rest.trim().split(/\s+/);
  if (!words.every((word) => /^[0-9a-f]{2}$/i.test(word))) throw new Error(`${rest || 'nothing'} is not bytes of two hexadecimal digits`);
  return Uint8Array.from(words, (word) => parseInt(word, 16));
}

function address(rest) {
  if (!/^[0-9a-f]{1,8}$/i.test(rest.trim())) throw new Error(`${rest || 'nothing'} is no address in hexadecimal`);
  return parseInt(rest, 16);
}

function oneOf(allowed, word) {
  if (!allowed.includes(word.trim())) throw new Error(`${word || 'nothing'} is none of ${allowed.join(', ')}`);
  return word.trim();
}

function onOff(rest) {
  return oneOf(['on', 'off'], rest) === 'on';
}

function pressed(rest) {
  return oneOf(['pressed', 'released'], rest) === 'pressed';
}

/** A position in millimetres above the limit switch; null for no plate. */
function plate(rest) {
  if (rest.trim() === 'none') return null;
  const [axis, mm, side, ...more] = rest.trim().split(/\s+/);
  nothing(more.join(' '));
  if (mm === undefined || !Number.isFinite(Number(mm))) throw new Error(`${mm ?? 'nothing'} is no place in mm`);
  return new ProbePlate(oneOf(AXES, axis), Number(mm), oneOf(PLATE_SIDES, side ?? ''));
}

/** Pressed or let go, or its wire. */
function estopState(rest) {
  return { pressed: { isPressed: true }, released: { isPressed: false }, cut: { isCut: true }, mended: { isCut: false } }[oneOf(['pressed', 'released', 'cut', 'mended'], rest)];
}

function outputState(rest) {
  const [output, state] = rest.trim().split(/\s+/);
  return [oneOf(TOOL_OUTPUTS, output ?? ''), onOff(state ?? '')];
}

function switchMode(rest) {
  const [axis, mode] = rest.trim().split(/\s+/);
  return [oneOf([...AXES, SECOND], axis ?? ''), oneOf(SWITCH_MODES, mode ?? '')];
}

function vfdState(rest) {
  return oneOf(VFD_STATES, rest.trim());
}

function driverState(rest) {
  const [motor, state] = rest.trim().split(/\s+/);
  return [oneOf([...AXES, SECOND], motor ?? ''), oneOf(DRIVER_STATES, state ?? '')];
}
