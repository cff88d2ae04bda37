import { callPanic, hang, jumpAstray } from './astray.mjs';
import { buildChip, loadInto } from './chip.mjs';
import { cyclesOfMillis, IS_RP2350, MachineClock, nanosOf } from './clock.mjs';
import { DeadlineWatch } from './deadline-watch.mjs';
import { enterHardFault } from './fault.mjs';
import { eraseUnder } from './flash-file.mjs';
import { Gantry } from './gantry.mjs';
import { LateAlarms } from './late-alarms.mjs';
import { PadFaults } from './pad-faults.mjs';
import { buildRp2350 } from './rp2350/chip.mjs';
import { UartCable } from './uart-cable.mjs';
import { UsbHost } from './usb-host.mjs';
import { isForRp2350 } from './which-chip.mjs';
import { RESET_FORCED, RESET_TIMER } from './watchdog.mjs';
import { FlashCounts } from './xip-cache.mjs';

const OTHER_CHIP = `the firmware is for an ${IS_RP2350 ? 'RP2040' : 'RP2350'}, and this process emulates the other chip: it takes that of --elf, or of EMULATED_CHIP if its runs come on stdin`;

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
    if (isForRp2350(segments) !== IS_RP2350) throw new Error(OTHER_CHIP);
    this.clock = new MachineClock();
    this.gantry = new Gantry(this.clock, options);
    this.padFaults = new PadFaults(this.clock, options.padFaults ?? []);
    this.warnings = new Set();
    this.resets = [];
    this.powerCycles = [];
    /**
     * When the firmware rebooted into BOOTSEL, and whether it left the motors on. After that the board is a drive and
     * does not run.
     */
    this.bootsel = null;
    this.faults = [];
    /** Number of faults that were requested. */
    this.crashes = 0;
    this.paused = false;
    /** The other end of the cable, set by the console that listens. */
    this.onBytes = () => {};
    /** Called when bytes have reached the chip: in its USB buffer, or its UART. */
    this.onDelivered = () => {};
    /** Called between parts of the run, to show progress. */
    this.onSlice = () => {};
    this.chipWatchers = [];
    /** 1 is the computed cost of a miss; null is flash that reads like RAM. */
    this.missFactor = options.missFactor === undefined ? 1 : options.missFactor;
    this.coreFactor = options.coreFactor ?? 1;
    this.flashCounts = new FlashCounts();
    this.watch = new DeadlineWatch(this.clock);
    this.lateAlarms = new LateAlarms();
    this.#build();
    if (kept !== null) this.flash.bytes.set(kept);
    eraseUnder(this.flash.bytes, segments);
    loadInto(this.chip, segments);
    const listener = { onData: (bytes) => this.#heard(bytes), onDelivered: (bytes) => this.#delivered(bytes) };
    this.cable = options.console === 'uart' ? new UartCable(this.clock, listener) : new UsbHost(this.clock, listener, options.framePpm);
    this.#start();
  }

  get nanos() {
    return nanosOf(this.clock.cycles);
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

  /** Calls the watcher with this chip, and with each new one after a reset. */
  watchChips(watcher) {
    this.chipWatchers.push(watcher);
    watcher(this.chip);
  }

  /** Makes `run` return on this very cycle, so that whatever waits for an event can act at its instant. */
  pause() {
    this.paused = true;
    this.clock.interrupt();
  }

  /** Makes the core jump to an address without memory, from which its next fetch is. */
  crash() {
    this.crashes += 1;
    this.gantry.toolStops.note('CRASH');
    jumpAstray(this.core);
  }

  /** Makes the core loop with its interrupts masked, for some time, or until the watchdog ends that. */
  hang(millis = null) {
    this.gantry.toolStops.note('HANG');
    const goOn = hang(this.core, this.chip.sram);
    if (millis !== null) this.clock.createAlarm(goOn).scheduleAt(this.clock.cycles + cyclesOfMillis(millis));
  }

  /**
   * Holds an interrupt back, so that the code that runs in it stops. Lower priorities continue. It stays pending, and the
   * firmware may enable and disable it meanwhile.
   */
  maskIrq(number) {
    this.heldInterrupt = number;
    this.holdInterrupt(number, true);
  }

  /** Lets it come: what runs in it goes on. */
  unmaskIrq() {
    this.holdInterrupt(this.heldInterrupt, false);
  }

  /** The state machine of the second motor counts a step that it has not made, as after a flipped bit. */
  miscountSecond() {
    const { block, index } = this.gantry.board.second.machine;
    const second = this.chip.pio[block].machines[index];
    second.y = (second.y - 1) | 0;
  }

  /** Makes the firmware panic by calling its function at this address. */
  panic(address) {
    this.gantry.toolStops.note('PANIC');
    callPanic(this.core, this.chip.sram, address);
  }

  /** Switches power off and on again at once. Everything restarts except flash, and the carriages stay where they are. */
  powerCycle() {
    this.powerCycles.push({ t_ns: this.nanos });
    this.gantry.toolStops.note('POWER');
    this.gantry.powerUp();
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
    const fault = this.runCore(this.core, this.bus, this.clock, limitCycle);
    if (fault !== null) this.#faulted(fault);
  }

  /** Sleeps until the next alarm, or until something outside the core wakes it: an edge, a flag, the end of a transfer. */
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
    const listeners = {
      onWatchdog: (reason) => this.#reset(reason),
      onBootsel: (...hints) => this.clock.createAlarm(() => this.#enterBootsel(hints)).schedule(0),
      onUartByte: (byte) => this.cable.received?.(byte),
      onWarning: (text) => this.warnings.add(text),
    };
    const build = IS_RP2350 ? buildRp2350 : buildChip;
    Object.assign(this, build(this.clock, listeners, { missFactor: this.missFactor, coreFactor: this.coreFactor, counts: this.flashCounts, watch: this.watch, lateAlarms: this.lateAlarms }));
  }

  #start() {
    this.boot();
    this.padFaults.attach(this.chip);
    this.gantry.attach(this.chip);
    this.cable.attach(this.chip, this.uart);
    for (const watch of this.chipWatchers) watch(this.chip);
  }

  /** The ROM's drive has received new firmware (here the same firmware again), and restarts the chip by the watchdog. */
  leaveBootsel() {
    this.bootsel = null;
    this.#restart(RESET_TIMER);
  }

  /** A watchdog reset: a new chip in the same place. Memory, scratch registers and the reason are kept. */
  #reset(reason) {
    this.gantry.toolStops.note('WATCHDOG');
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

  /** The ROM takes over: the pins are released and the cable is dead. Its arguments are kept in scratch registers. */
  #enterBootsel(hints) {
    const { watchdog } = this;
    this.gantry.toolStops.note('BOOTSEL');
    this.bootsel = { t_ns: this.nanos, energised: this.gantry.hasDriverOn };
    this.#renew();
    this.watchdog.scratch.set([...hints, ...watchdog.scratch.subarray(hints.length)]);
    this.core.waiting = true;
    this.padFaults.attach(this.chip);
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
    this.gantry.toolStops.note('FAULT');
    this.faults.push({ t_ns: this.nanos, pc: `0x${pc.toString(16)}`, what: fault.message });
    this.pause();
  }
}
