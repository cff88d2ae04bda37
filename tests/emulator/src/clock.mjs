import { Lockstep } from './lockstep.mjs';
import { isRp2350 } from './which-chip.mjs';

/** Whether this process emulates an RP2350. */
export const IS_RP2350 = isRp2350();
/** The system clock of a stock Pico, or Pico 2. */
export const CLOCK_HZ = IS_RP2350 ? 150_000_000 : 125_000_000;
export const NANOS_PER_CYCLE = 1e9 / CLOCK_HZ;
/** A whole number: as a cycle of an RP2350 has none, to half a nanosecond. */
export const nanosOf = (cycles) => Math.round(cycles * NANOS_PER_CYCLE);
export const CYCLES_PER_MICRO = CLOCK_HZ / 1e6;

export const cyclesOfMicros = (micros) => Math.round(micros * CYCLES_PER_MICRO);
export const cyclesOfMillis = (millis) => Math.round(millis * 1000 * CYCLES_PER_MICRO);

const PRESENT = -1;

/**
 * Machine time: whole cycles of the system clock since power-up, and the alarms waiting for them.
 *
 * The core owns the cycle counter (`core.cycles`), so a peripheral read in the middle of a run sees the instant of the
 * instruction that reads it. What an instruction has overtaken (an alarm, an edge of PIO) happens behind it, with its own
 * cycle on the clock. Alarms of one cycle fire in the order in which they were set.
 */
export class MachineClock {
  constructor() {
    /** The counter of cycles: the core, or this substitute before there is a core. */
    this.core = { cycles: 0 };
    /** The cycle of the earliest alarm: the run loop looks at it after every instruction. */
    this.next = Infinity;
    this.alarms = [];
    /** What runs beside the core. It catches up with every alarm before the alarm fires. */
    this.lockstep = new Lockstep(this);
    /** The cycle of an event that the core's last instruction has already passed. */
    this.past = PRESENT;
    /** Cycles the core has slept through. */
    this.asleepCycles = 0;
    /** Cycles spent in interrupt handlers that have ended, and the cycle at which the current one began. */
    this.handledCycles = 0;
    this.handlerStart = null;
    /** What each instruction takes, if somebody asks for it. @type {import('./profile.mjs').Profile | null} */
    this.profile = null;
  }

  get cycles() {
    return this.past === PRESENT ? this.core.cycles : this.past;
  }

  get awakeCycles() {
    return this.cycles - this.asleepCycles;
  }

  /** Cycles spent in interrupt handlers. They contain the work for a step at its instant, but not its planning. */
  get handlerCycles() {
    return this.handledCycles + (this.handlerStart === null ? 0 : this.cycles - this.handlerStart);
  }

  enterHandler() {
    this.handlerStart ??= this.cycles;
  }

  /** Back in thread mode. */
  leaveHandlers() {
    this.handledCycles = this.handlerCycles;
    this.handlerStart = null;
  }

  get nanos() {
    return nanosOf(this.cycles);
  }

  get micros() {
    return this.nanos / 1000;
  }

  /** An alarm inside the chip, for rp2040js's peripherals. A reset of the chip drops it. */
  createAlarm(callback) {
    return new Alarm(this, callback, true);
  }

  /** An alarm outside the chip (cables, switches, the sender). It outlives a reset. */
  createOutsideAlarm(callback) {
    return new Alarm(this, callback, false);
  }

  dropChipAlarms() {
    for (const alarm of this.alarms.filter((each) => each.onChip)) alarm.cancel();
  }

  /** Fires every alarm that is due, each at its own cycle, after what runs beside the core has reached that cycle. */
  fireDue() {
    this.#lookAhead();
    while (this.alarms.length > 0 && this.alarms[0].dueCycle <= this.core.cycles) {
      this.lockstep.catchUp();
      const alarm = this.alarms.shift();
      this.#lookAhead();
      this.past = alarm.dueCycle;
      alarm.dueCycle = null;
      alarm.callback();
      this.past = PRESENT;
    }
    this.lockstep.catchUp();
  }

  /** Performs an action that the core's current instruction has already passed, with the action's own cycle on the clock. */
  at(cycle, action) {
    const { past } = this;
    this.past = cycle;
    action();
    this.past = past;
  }

  /** Makes the run loop look up before the next instruction, as an alarm would. */
  interrupt() {
    this.next = 0;
  }

  insert(alarm) {
    let index = this.alarms.length;
    while (index > 0 && this.alarms[index - 1].dueCycle > alarm.dueCycle) index--;
    this.alarms.splice(index, 0, alarm);
    this.#lookAhead();
  }

  remove(alarm) {
    this.alarms.splice(this.alarms.indexOf(alarm), 1);
    this.#lookAhead();
  }

  #lookAhead() {
    this.next = this.alarms.length > 0 ? this.alarms[0].dueCycle : Infinity;
  }
}

class Alarm {
  constructor(clock, callback, onChip) {
    this.clock = clock;
    this.callback = callback;
    this.onChip = onChip;
    this.dueCycle = null;
  }

  get scheduled() {
    return this.dueCycle !== null;
  }

  /** The interface of rp2040js: a delay in nanoseconds, rounded up to a whole cycle and never zero. */
  schedule(delayNanos) {
    this.scheduleAt(this.clock.cycles + Math.max(1, Math.ceil(delayNanos / NANOS_PER_CYCLE)));
  }

  scheduleAt(cycle) {
    this.cancel();
    this.dueCycle = cycle;
    this.clock.insert(this);
  }

  cancel() {
    if (!this.scheduled) return;
    this.clock.remove(this);
    this.dueCycle = null;
  }
}
