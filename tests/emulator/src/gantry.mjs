import { Belts } from './belts.mjs';
import { Carriage } from './carriage.mjs';
import { nanosOf } from './clock.mjs';
import { DRIVERS, DriverTiming } from './driver-timing.mjs';
import { Drivers } from './drivers.mjs';
import { Estop } from './estop.mjs';
import { Jumper } from './jumper.mjs';
import { LimitSwitch, seededRandom } from './limit-switch.mjs';
import { AXES, AXES_USUAL, boardOf, SECOND } from './pins.mjs';
import { Probe } from './probe.mjs';
import { SecondMotor } from './second-motor.mjs';
import { StepStatistics } from './statistics.mjs';
import { Stops } from './stops.mjs';
import { ToolOutputs } from './tool.mjs';
import { ToolStops } from './tool-stops.mjs';
import { VfdWire } from './vfd-wire.mjs';

const HIGH = 1;

/** The plant: drivers, carriages and switches, the tool, its probe and the buttons, wired to the chip's pins. */
export class Gantry {
  #estop;
  /** The ENABLE pins that are high. */
  #disabled = new Set();

  /**
   * @param {import('./clock.mjs').MachineClock} clock
   * @param {{board?: string, axes?: number, startMm: number[], bounceMicros: number, seed: number, switches: Record<string, string>,
   *   driver?: string, estop?: 'no' | 'nc', enable?: 'wired' | 'open', second?: {axis: string, skewMm: number} | null,
   *   belts?: boolean, probePlate?: import('./probe-plate.mjs').ProbePlate | null}} options
   * @param {{from: number, to: number}[]} [options.jumpers] wires between the chip's pads
   * @param {string[]} [options.diag] axes whose limit input is wired to their driver's DIAG, not to their switch
   * @param {boolean} [options.vfd] whether a VFD is on the wire of UART0
   * @param {[string, string][]} [options.driverStates] of motors, at power-up: see tmc2209-faults.mjs
   * @param {number | null} [options.hardEndsMm] how far beyond its switch an end blocks every carriage; null if nothing does
   */
  constructor(clock, options) {
    this.clock = clock;
    this.board = boardOf(options.board ?? 'pico', options.axes ?? AXES_USUAL);
    this.timing = new DriverTiming(DRIVERS[options.driver ?? 'drv8825']);
    this.enable = options.enable ?? 'wired';
    this.statistics = new StepStatistics();
    this.tool = new ToolOutputs(clock, this.board.tool);
    this.stops = new Stops(clock, this.tool.offTimes);
    this.toolStops = new ToolStops(clock, this.tool.offTimes);
    this.#estop = new Estop(options.estop ?? 'no');
    this.levels = new Map(Object.values(this.board.contacts).map((pin) => [pin, true]));
    this.levels.set(this.board.estop, this.#estop.high);
    /** What a stop by an input is called. */
    this.stopNames = new Map(options.estop === 'nc' ? [] : [[this.board.estop, 'ESTOP']]);
    this.inputWatchers = new Set();
    this.directions = {};
    this.carriages = {};
    /** Called with (cycle, axis, direction, positionSteps) at every step. */
    this.stepWatchers = new Set();
    this.diag = new Set(options.diag ?? []);
    this.endMm = -(options.hardEndsMm ?? Infinity);
    const random = seededRandom(options.seed);
    /** Those that the firmware has. */
    this.axes = AXES.slice(0, options.axes ?? AXES_USUAL);
    this.axes.forEach((axis, index) => this.#addAxis(axis, options.startMm[index], options, random));
    /** What crosses the motors of X and Y, if anything does. */
    this.belts = options.belts ? new Belts(this.carriages) : null;
    this.second = options.second ? this.#secondMotor(options, random) : null;
    this.drivers = this.board.tmcWire === null ? null : this.#uartDrivers(options);
    this.vfdWire = options.vfd ? new VfdWire(clock, { ...this.board.vfdWire, enable: this.board.tool.enable }) : null;
    this.probe = new Probe(clock, this.carriages, (high) => this.#drive(this.board.contacts.probe, high));
    this.probe.setPlate(options.probePlate ?? null);
    this.jumpers = (options.jumpers ?? []).map((pads) => new Jumper(pads, (jumper) => this.#jumped(jumper)));
    // An input that nothing else is wired to reads high, as an open switch does.
    for (const { to } of this.jumpers) if (!this.levels.has(to)) this.levels.set(to, true);
  }

  #addAxis(axis, startMm, { bounceMicros, switches }, random) {
    const limitSwitch = this.#limitSwitch(axis, this.board.axes[axis].limit, bounceMicros, random);
    this.carriages[axis] = new Carriage(startMm, limitSwitch, this.endMm);
    limitSwitch.setMode(switches[axis] ?? 'normal');
    this.directions[axis] = -1;
  }

  #uartDrivers({ seed, driverStates = [] }) {
    for (const axis of this.diag) this.levels.set(this.board.axes[axis].limit, false);
    return new Drivers(this.clock, this.board, { seed, states: driverStates, onDiag: (axis, high) => this.#onDiag(axis, high) });
  }

  #secondMotor({ second, startMm, bounceMicros, switches }, random) {
    const limitSwitch = this.#limitSwitch(SECOND, this.board.second.limit, bounceMicros, random);
    const motor = new SecondMotor(this, second, startMm[AXES.indexOf(second.axis)], limitSwitch);
    limitSwitch.setMode(switches[SECOND] ?? 'normal');
    return motor;
  }

  #limitSwitch(name, pin, bounceMicros, random) {
    this.levels.set(pin, true);
    this.stopNames.set(pin, `${name}_LIMIT`);
    const onLevel = (high) => {
      if (this.diag.has(name)) return;
      this.#drive(pin, high);
      // A contact that bounces as it opens is not a new stop.
      if (!high && limitSwitch.held) this.#stop(this.stopNames.get(pin));
    };
    const limitSwitch = new LimitSwitch(this.clock, { bounceMicros, random, onLevel });
    return limitSwitch;
  }

  /** The limit switch of an axis, or of the second motor. */
  limitSwitch(name) {
    return name === SECOND ? this.second?.limitSwitch : this.carriages[name]?.limitSwitch;
  }

  /** Connects the gantry to a chip that has just been powered or reset. */
  attach(chip) {
    this.chip = chip;
    this.tool.attach(chip);
    this.drivers?.attach(chip);
    this.vfdWire?.attach(chip);
    for (const jumper of this.jumpers) jumper.attach(chip);
    for (const [pin, high] of this.levels) chip.gpio[pin].setInputValue(high);
    for (const axis of this.axes) {
      // A chip that has just been reset drives no pin: the driver's own pull-down holds DIR low.
      this.directions[axis] = -1;
      const { step, dir } = this.board.axes[axis];
      chip.gpio[step].addListener((state, before) => this.#onStepPin(axis, state === HIGH, before === HIGH));
      chip.gpio[dir].addListener((state, before) => this.#onDirPin(axis, state === HIGH, before === HIGH));
    }
    this.second?.attach(chip);
    // Until the firmware drives it, the driver's own pull-down holds ENABLE low.
    for (const pin of this.#enables) this.#onEnablePin(pin, false);
    if (this.enable === 'open') return;
    for (const pin of this.#enables) {
      chip.gpio[pin].addListener((state) => this.#onEnablePin(pin, state === HIGH));
    }
  }

  /** The machine's power is off and on again. */
  powerUp() {
    this.drivers?.powerUp();
  }

  /** A motor takes a step, if its driver drives it. */
  move(motor, carriage, direction) {
    const driver = this.drivers?.of(motor);
    if (this.#isCrossed(motor)) {
      const { belts } = this;
      belts.step(motor, direction, driver === undefined || driver.step(direction > 0, belts.blocked(motor, direction)));
    } else {
      carriage.step(direction, driver === undefined || driver.step(direction > 0, carriage.blocked(direction)));
    }
  }

  #isCrossed(motor) {
    return this.belts !== null && Belts.axesOf(motor).length > 1;
  }

  /** Where the axes are by the count of the motors, in steps. */
  countedSteps() {
    const counted = this.axes.map((axis) => this.carriages[axis].positionSteps);
    return this.belts?.placesOf(counted) ?? counted;
  }

  /** Presses the emergency stop or lets it go, cuts its wire or mends it. */
  changeEstop(change) {
    const stops = this.#estop.change(change);
    this.#drive(this.board.estop, this.#estop.high);
    if (stops) this.#stop('ESTOP');
  }

  /** @param {'hold' | 'start'} button */
  pressButton(button, pressed) {
    const pin = this.board.contacts[button];
    if (pin === undefined) throw new Error(`this board has no button for ${button}: its pin is the switch of the second motor`);
    this.#drive(pin, !pressed);
  }

  /** The contact of all drives' alarm closes, or opens. */
  changeAlarm(closed) {
    const pin = this.board.contacts.alarm;
    if (pin === undefined) throw new Error('this board has no input for the alarm of drives');
    if (closed && this.levels.get(pin)) this.#stop('ALARM');
    this.#drive(pin, !closed);
  }

  /** A reset byte has arrived. */
  reset() {
    this.stops.reset();
    this.toolStops.note('RESET');
  }

  /** Calls the watcher with the levels of all inputs, and with every change: (pin, high). */
  watchInputs(watcher) {
    this.inputWatchers.add(watcher);
    for (const [pin, high] of this.levels) watcher(pin, high);
  }

  /** Input pins that float when their switch is open, because the firmware has not switched the pull-up on. A proving image has outputs on some. */
  floatingInputs() {
    const driven = [...this.diag].map((axis) => this.board.axes[axis].limit);
    return [...this.levels.keys()].filter((pin) => !driven.includes(pin) && !this.chip.gpio[pin].pullupEnabled && !this.chip.gpio[pin].outputEnable);
  }

  /** The axes have been homed. The trace counts from here. */
  home(axes) {
    for (const axis of axes) {
      if (this.#isCrossed(axis)) this.belts.home(axis);
      else this.carriages[axis]?.home();
    }
  }

  get nanos() {
    return nanosOf(this.clock.cycles);
  }

  #stop(input) {
    this.stops.note(input);
    this.toolStops.note(input);
  }

  /** A driver's DIAG rises or falls; only where a jumper connects it does that matter. */
  #onDiag(axis, high) {
    if (!this.diag.has(axis)) return;
    this.#drive(this.board.axes[axis].limit, high);
    if (high) this.#stop(this.stopNames.get(this.board.axes[axis].limit));
  }

  /** What is wired to an input changes its level. Nothing is seen of that while a jumper pulls the input low. */
  #drive(pin, high) {
    this.levels.set(pin, high);
    if (!this.jumpers?.some(({ to, low }) => to === pin && low)) this.#show(pin, high);
  }

  /** A jumper pulls an input low, or lets go; nothing is seen of that while what else is wired to it, or another jumper, does so too. */
  #jumped(jumper) {
    const { to, low } = jumper;
    if (!this.levels.get(to) || this.jumpers.some((other) => other !== jumper && other.to === to && other.low)) return;
    this.#show(to, !low);
    if (low && this.stopNames.has(to)) this.#stop(this.stopNames.get(to));
  }

  #show(pin, high) {
    this.chip?.gpio[pin].setInputValue(high);
    for (const watch of this.inputWatchers) watch(pin, high);
  }

  #onStepPin(axis, high, wasHigh) {
    if (high === wasHigh) return;
    const { cycles } = this.clock;
    const nanos = nanosOf(cycles);
    if (!high) return this.timing.fall(axis, nanos);
    const carriage = this.carriages[axis];
    const direction = this.directions[axis];
    // Before the carriage moves, because its switch may report a stop.
    this.stops.step(axis, cycles);
    if (this.timing.rise(axis, nanos)) this.move(axis, carriage, direction);
    this.probe.step(axis, this.belts === null ? [axis] : Belts.axesOf(axis));
    this.statistics.step(axis, this.clock);
    this.tool.step(cycles);
    for (const watch of this.stepWatchers) watch(cycles, axis, direction, carriage.positionSteps);
  }

  #onDirPin(axis, high, wasHigh) {
    if (high === wasHigh) return;
    this.directions[axis] = high ? 1 : -1;
    this.timing.turn(axis, this.nanos);
    this.stops.turn();
  }

  get #enables() {
    return new Set(Object.values(this.board.axes).map(({ enable }) => enable));
  }

  /** Whether a driver is on, be it the only one. */
  get hasDriverOn() {
    return this.#disabled.size < this.#enables.size;
  }

  #onEnablePin(pin, high) {
    if (high) this.#disabled.add(pin);
    else this.#disabled.delete(pin);
    this.drivers?.enable(pin, !high);
    this.#onEnable();
  }

  /** The motors are on when every driver is. */
  #onEnable() {
    const energised = this.#disabled.size === 0;
    if (energised !== this.timing.energised) this.timing.enable(energised, this.nanos);
  }
}
