import { callPanic, hang, jumpAstray } from './astray.mjs';
import { buildChip, loadInto } from './chip.mjs';
import { MachineClock, NANOS_PER_CYCLE } from './clock.mjs';
import { run } from './core.mjs';
import { DeadlineWatch } from './deadline-watch.mjs';
import { enterHardFault } from './fault.mjs';
import { eraseUnder } from './flash-file.mjs';
import { Gantry } from './gantry.mjs';
import { boot } from './second-stage.mjs';
import { UartCable } from './uart-cable.mjs';
import { UsbHost } from './usb-host.mjs';
import { RESET_FORCED, RESET_TIMER } from './watchdog.mjs';
import { FlashCounts } from './xip-cache.mjs';

/** Grbl's ctrl-X. */
const RESET_BYTE = 0x18;

/** The whole machine on the desk: a Pico with its firmware, the gantry, and one cable to the sender. */
export class Board {
  /**
   * @param {{address: number, bytes: Uint8Array}[]} segments the firmware
   * @param {{console: 'usb' | 'uart'} & object} options see options.mjs
   * @param {Uint8Array | null} kept what flash holds from an earlier run
   */
  constructor(segments, options, kept = null) {
    this.clock = new MachineClock();
    this.gantry = new Gantry(this.clock, options);
    this.warnings = new Set();
    this.resets = [];
    this.powerCycles = [];
    /** When the firmware rebooted into BOOTSEL, and whether it left the motors on: from then on the board is a drive, and runs no more. */
    this.bootsel = null;
    this.faults = [];
    /** Faults that were asked for. */
    this.crashes = 0;
    this.paused = false;
    /** The far end of the cable: set by the console that listens. */
    this.onBytes = () => {};
    /** Called when bytes have reached the chip: in its USB buffer, or its UART. */
    this.onDelivered = () => {};
    /** Called between stretches of the run, to show progress. */
    this.onSlice = () => {};
    this.chipWatchers = [];
    /** 1 is what is reckoned; null is flash that reads like RAM. */
    this.missFactor = options.missFactor === undefined ? 1 : options.missFactor;
    this.flashCounts = new FlashCounts();
    this.watch = new DeadlineWatch(this.clock);
    this.#build();
    if (kept !== null) this.flash.bytes.set(kept);
    eraseUnder(this.flash.bytes, segments);
    loadInto(this.chip, segments);
    const listener = { onData: (bytes) => this.#heard(bytes), onDelivered: (bytes) => this.#delivered(bytes) };
    this.cable = options.console === 'uart' ? new UartCable(this.clock, listener) : new UsbHost(this.clock, listener);
    this.#start();
  }

  get nanos() {
    return this.clock.cycles * NANOS_PER_CYCLE;
  }

  /** Runs the machine until the given cycle, or until something calls `pause`. */
  run(limitCycle) {
    const { clock } = this;
    this.paused = false;
    while (!this.paused && clock.cycles < limitCycle) {
      clock.fireDue();
      if (this.paused) break;
      if (this.core.waiting) this.#sleep(limitCycle);
      else this.#execute(limitCycle);
      this.onSlice();
    }
  }

  /** Shows the watcher this chip, and every one that a reset makes. */
  watchChips(watcher) {
    this.chipWatchers.push(watcher);
    watcher(this.chip);
  }

  /** Makes `run` return on this very cycle: what waits for an event then acts on it at its instant. */
  pause() {
    this.paused = true;
    this.clock.interrupt();
  }

  /** Sends the core astray, as a wild jump would: its next fetch is from where there is no memory. */
  crash() {
    this.crashes += 1;
    this.gantry.toolStops.told('CRASH');
    jumpAstray(this.core);
  }

  /** Has the core hang with its interrupts masked: only the watchdog ends that. */
  hang() {
    hang(this.core, this.chip.sram);
  }

  /** Masks an interrupt, and so has whatever runs in it stand still: what is below it goes on. */
  maskIrq(number) {
    this.core.enabledInterrupts &= ~(1 << number);
  }

  /** Has the firmware panic, by its function at that address. */
  panic(address) {
    this.gantry.toolStops.told('PANIC');
    callPanic(this.core, this.chip.sram, address);
  }

  /** Takes power away and gives it back at once: all is new but flash, and the carriages stay where they are. */
  powerCycle() {
    this.powerCycles.push({ t_ns: this.nanos });
    this.gantry.toolStops.told('POWER');
    this.#renew();
    this.#start();
    this.pause();
  }

  /** The sender sends bytes. */
  send(bytes) {
    if (bytes.length > 0) this.watch.senderSpoke();
    this.cable.write(bytes);
  }

  /** The firmware has sent bytes. */
  #heard(bytes) {
    this.watch.firmwareSpoke();
    this.onBytes(bytes);
  }

  /** Bytes have reached the firmware. */
  #delivered(bytes) {
    if (bytes.includes(RESET_BYTE)) this.gantry.reset();
    this.onDelivered();
  }

  #execute(limitCycle) {
    const fault = run(this.core, this.bus, this.clock, limitCycle);
    if (fault !== null) this.#faulted(fault);
  }

  /** Until the next alarm, or until something beside the core wakes it: an edge, a flag, the end of a transfer. */
  #sleep(limitCycle) {
    const { clock, core } = this;
    const { lockstep } = clock;
    while (core.waiting && lockstep.next <= Math.min(clock.next, limitCycle)) {
      this.#sleepUntil(Math.floor(lockstep.next));
      lockstep.tick(core.cycles);
    }
    if (core.waiting) this.#sleepUntil(Math.min(clock.next, limitCycle));
  }

  #sleepUntil(cycle) {
    const cycles = Math.max(0, cycle - this.core.cycles);
    this.core.cycles += cycles;
    this.clock.asleepCycles += cycles;
  }

  #build() {
    const tells = {
      onWatchdog: (reason) => this.#reset(reason),
      onBootsel: (...hints) => this.clock.createAlarm(() => this.#enterBootsel(hints)).schedule(0),
      onUartByte: (byte) => this.cable.received?.(byte),
      onWarning: (text) => this.warnings.add(text),
    };
    Object.assign(this, buildChip(this.clock, tells, { missFactor: this.missFactor, counts: this.flashCounts, watch: this.watch }));
  }

  #start() {
    boot(this.chip, this.flash);
    this.gantry.attach(this.chip);
    this.cable.attach(this.chip, this.uart);
    for (const watch of this.chipWatchers) watch(this.chip);
  }

  /** The ROM's drive has taken new firmware, here the same again, and restarts the chip: by the watchdog. */
  leaveBootsel() {
    this.bootsel = null;
    this.#restart(RESET_TIMER);
  }

  /** A watchdog reset: a fresh chip in the same place, with memory, scratch registers and the reason kept. */
  #reset(reason) {
    this.gantry.toolStops.told('WATCHDOG');
    this.resets.push({ t_ns: this.nanos, reason: reason === RESET_FORCED ? 'forced' : 'timed out' });
    this.#restart(reason);
  }

  #restart(reason) {
    const { chip, watchdog } = this;
    this.#renew();
    this.chip.sram.set(chip.sram);
    this.watchdog.scratch.set(watchdog.scratch);
    this.watchdog.reason = reason;
    this.#start();
    this.pause();
  }

  /** The ROM takes over: the pins go, the cable is dead. It keeps what it is told in scratch registers. */
  #enterBootsel(hints) {
    const { watchdog } = this;
    this.gantry.toolStops.told('BOOTSEL');
    this.bootsel = { t_ns: this.nanos, energised: this.gantry.timing.energised };
    this.#renew();
    this.watchdog.scratch.set([...hints, ...watchdog.scratch.subarray(hints.length)]);
    this.core.waiting = true;
    this.gantry.attach(this.chip);
    for (const watch of this.chipWatchers) watch(this.chip);
    this.pause();
  }

  /** A fresh chip with the same flash. */
  #renew() {
    const { flash } = this;
    this.clock.dropChipAlarms();
    this.#build();
    this.flash.bytes.set(flash.bytes);
  }

  #faulted(fault) {
    const pc = enterHardFault(this.core, fault);
    this.gantry.toolStops.told('FAULT');
    this.faults.push({ t_ns: this.nanos, pc: `0x${pc.toString(16)}`, what: fault.message });
    this.pause();
  }
}
