import { RP2040 } from 'rp2040js';
import { watchExceptions } from '../chip.mjs';
import { DeadlineWatch } from '../deadline-watch.mjs';
import { Dma } from '../dma.mjs';
import { RP2350 as DMA_LAYOUT } from '../dma-layout.mjs';
import { Flash } from '../flash.mjs';
import { Fault } from '../fault.mjs';
import { LateAlarms } from '../late-alarms.mjs';
import { Lockstep } from '../lockstep.mjs';
import { CortexM33, run } from '../m33/core.mjs';
import { Slowness } from '../m33/slowness.mjs';
import { System } from '../m33/system.mjs';
import { PadInputs } from '../pad-inputs.mjs';
import { PioBlock } from '../pio/block.mjs';
import { PioRegisters } from '../pio/registers.mjs';
import { Pwm } from '../pwm.mjs';
import { loadRp2350Rom } from '../rom/rp2350.mjs';
import { Sleep } from '../sleep.mjs';
import { SysTick } from '../systick.mjs';
import { ExactTimer } from '../timer.mjs';
import { Uart } from '../uart.mjs';
import { RESET_FORCED, Watchdog } from '../watchdog.mjs';
import { IMAGE_MARK, MARK_BYTES } from '../which-chip.mjs';
import { FlashCounts, XipCache } from '../xip-cache.mjs';
import { Rp2350Bus } from './bus.mjs';
import { Dcp } from './dcp.mjs';
import { Otp } from './otp.mjs';
import { Plain } from './plain.mjs';
import { Qmi, XIP_SETUP } from './qmi.mjs';
import * as registers from './registers.mjs';
import { Remapped } from './remapped.mjs';
import { Rp2350XipControl, XipSpace } from './xip.mjs';

const KIB = 1024;
const RAM_BYTES = 520 * KIB;
const FLASH_START = 0x10000000;
const ISOLATED = 1 << 8;
/** A pad after a reset (datasheet 9.11.3): isolated, its input off, pulled down, 4 mA. */
const PAD_AT_RESET = 0x116;
/** The project's interrupts of the RP2040, by which the shared peripherals name theirs. */
const [IRQ_PIO0, IRQ_PIO1, IRQ_UART0, IRQ_UART1] = [7, 9, 20, 21];
/** No block of the RP2040 has it: {@link registers.INTERRUPTS} has it in addition. */
const IRQ_PIO2 = registers.IRQ_PIO2;
/** FUNCSEL of PIO2, which rp2040js does not know. */
const FUNCTION_PIO2 = 8;
/** RP2350-A2: Raspberry Pi's JEDEC number and part 4, in revision 2. */
const CHIP_ID = 0x20004927;
const SLOT = {
  sysInfo: 0x40000, clocks: 0x40010, psm: 0x40018, resets: 0x40020, ioBank0: 0x40028, pads: 0x40038, xosc: 0x40048, pllSys: 0x40050, pllUsb: 0x40058,
  accessCtrl: 0x40060, uart0: 0x40070, uart1: 0x40078, pwm: 0x400a8, timer0: 0x400b0, xipCtrl: 0x400c8, qmi: 0x400d0, watchdog: 0x400d8, bootRam: 0x400e0, rosc: 0x400e8,
  powman: 0x40100, ticks: 0x40108, otp: 0x40130, otpRaw: 0x40134, dma: 0x50000, usb: 0x50110, pio0: 0x50200, pio1: 0x50300, pio2: 0x50400,
};

/**
 * An RP2350A: a Cortex-M33 with the peripherals of the emulated RP2040 at the RP2350's addresses. The second core, security,
 * the second timer and all else that the firmware does not use are left out.
 *
 * @param {import('../clock.mjs').MachineClock} clock
 * @param {object} board what the chip tells the board: see `buildChip` in `chip.mjs`
 * @param {object} options as there
 */
export function buildRp2350(clock, board, { missFactor = 1, coreFactor = 1, counts = new FlashCounts(), watch = new DeadlineWatch(clock), lateAlarms = new LateAlarms() } = {}) {
  const powerUpCycle = clock.core.cycles;
  const chip = new RP2040(clock);
  chip.logger = logger(board.onWarning);
  chip.sram = new Uint8Array(RAM_BYTES);
  chip.sramView = new DataView(chip.sram.buffer);
  const system = new System(clock);
  const core = new CortexM33(chip, system);
  Object.assign(core, { cycles: powerUpCycle, watch, doubles: new Dcp(), slowness: coreFactor === 1 ? null : new Slowness(coreFactor, counts) });
  chip.core = core;
  clock.core = core;
  core.sleep = new Sleep(core, board.onWarning, (heedsMask) => core.exceptions.wakes(heedsMask));
  system.attach(core, new SysTick(chip), () => board.onWatchdog(RESET_FORCED));
  chip.setInterrupt = (irq, isAsserted) => core.setInterrupt(numberOf(irq), isAsserted);
  chip.onBootsel = board.onBootsel;
  const cache = new XipCache(clock, counts, missFactor);
  const flash = new Flash(chip, cache, (onChange) => new Qmi(chip, 'QMI', onChange));
  const watchdog = new Watchdog(chip, 'WATCHDOG', board.onWatchdog);
  const uart = new Uart(chip, 'UART0', IRQ_UART0, board.onUartByte);
  chip.uart0 = uart;
  chip.uart1 = new Uart(chip, 'UART1', IRQ_UART1, () => {});
  chip.pwm = new Pwm(chip, 'PWM');
  runBeside(chip, clock, cache);
  for (const pin of chip.gpio) isolate(pin);
  attachPeripherals(chip, { flash, cache, watchdog, uart, timer: new ExactTimer(chip, 'TIMER0', lateAlarms) });
  loadRp2350Rom(chip);
  const bus = new Rp2350Bus(chip, flash, cache, watch);
  core.bus = bus;
  watch.attach(core);
  chip.dma.onAccess = (address, cycle) => bus.contend(address, cycle);
  watchExceptions(clock, bus);
  return { chip, core, bus, cache, flash, watchdog, uart, runCore: run, boot: () => boot(chip, flash), holdInterrupt: (number, isHeld) => core.exceptions.hold(numberOf(number), isHeld) };
}

function numberOf(irq) {
  const number = registers.INTERRUPTS.get(irq);
  if (number === undefined) throw new Error(`the RP2040's interrupt ${irq} has no number on an RP2350`);
  return number;
}

/** PIO and DMA, in step with the core. */
function runBeside(chip, clock, cache) {
  const lockstep = new Lockstep(clock);
  clock.lockstep = lockstep;
  const dma = new Dma(chip, 'DMA', lockstep, cache, DMA_LAYOUT);
  const pio = [IRQ_PIO0, IRQ_PIO1, IRQ_PIO2].map((irq, index) => new PioBlock(chip, index, { irq, lockstep }));
  pio.forEach((block, index) => Object.assign(block, { neighbours: { previous: pio.at(index - 1), next: pio[(index + 1) % pio.length] } }));
  Object.assign(chip, { dma, pio });
  for (const pin of chip.gpio) showPio2(pin, pio[2]);
  // The last first, because it may name the flags of the first.
  for (const part of [pio[2], pio[0], pio[1], dma]) lockstep.add(part);
  for (const block of pio) block.onRequest = (number, cycle) => dma.request(number, cycle);
  new PadInputs(chip, pio, clock);
}

/** A pad that is isolated drives nothing and sees nothing, until the firmware connects it. */
function isolate(pin) {
  const { outputEnable, inputEnable } = Object.getOwnPropertyDescriptors(Object.getPrototypeOf(pin));
  const connected = ({ get }) => ({ get: () => (pin.padValue & ISOLATED) === 0 && get.call(pin) });
  pin.padValue = PAD_AT_RESET;
  Object.defineProperties(pin, { outputEnable: connected(outputEnable), inputEnable: connected(inputEnable) });
}

/** What PIO2 drives reaches the pad of a pin that has its function. */
function showPio2(pin, block) {
  const { rawOutputEnable, rawOutputValue } = Object.getOwnPropertyDescriptors(Object.getPrototypeOf(pin));
  const driven = ({ get }, bitsOf) => ({ get: () => (pin.functionSelect === FUNCTION_PIO2 ? ((bitsOf() >>> pin.index) & 1) !== 0 : get.call(pin)) });
  Object.defineProperties(pin, { rawOutputEnable: driven(rawOutputEnable, () => block.pinDirections), rawOutputValue: driven(rawOutputValue, () => block.pinValues) });
}

function attachPeripherals(chip, { flash, cache, watchdog, uart, timer }) {
  const old = chip.peripherals;
  const remapped = (name, inner, { place, moved }) => new Remapped(chip, name, inner, place, moved);
  const sio = remapped('SIO', { readUint32: (offset) => chip.sio.readUint32(offset), writeUint32Atomic: (offset, value) => chip.sio.writeUint32(offset, value) }, registers.SIO);
  chip.peripherals = {
    [SLOT.sysInfo]: new Plain(chip, 'SYSINFO', new Map([[0, () => CHIP_ID]])),
    [SLOT.clocks]: new Plain(chip, 'CLOCKS', selected()),
    [SLOT.psm]: new Plain(chip, 'PSM', new Map([[0xc, () => 0x1ffffff]])),
    [SLOT.resets]: new Plain(chip, 'RESETS', new Map([[8, (read) => ~read(0) & 0x1fffffff]])),
    [SLOT.ioBank0]: remapped('IO_BANK0', old[0x40014], registers.IO_BANK0),
    [SLOT.pads]: old[0x4001c],
    [SLOT.xosc]: new Plain(chip, 'XOSC', new Map([[4, () => 0x80001000]])),
    [SLOT.pllSys]: pll(chip, 'PLL_SYS'),
    [SLOT.pllUsb]: pll(chip, 'PLL_USB'),
    [SLOT.accessCtrl]: new Plain(chip, 'ACCESSCTRL'),
    [SLOT.uart0]: uart,
    [SLOT.uart1]: chip.uart1,
    [SLOT.pwm]: remapped('PWM', chip.pwm, registers.PWM),
    [SLOT.timer0]: remapped('TIMER0', timer, registers.TIMER),
    [SLOT.xipCtrl]: new Rp2350XipControl(chip, 'XIP_CTRL', cache),
    [SLOT.qmi]: flash.interface,
    [SLOT.watchdog]: watchdog,
    [SLOT.bootRam]: new Plain(chip, 'BOOTRAM'),
    [SLOT.rosc]: new Plain(chip, 'ROSC', new Map([[0x18, () => 0x80001000]])),
    [SLOT.powman]: new Plain(chip, 'POWMAN', new Map([[0x0c, () => 0xb0]])),
    // RUNNING follows ENABLE.
    [SLOT.ticks]: new Plain(chip, 'TICKS', new Map([0, 0xc, 0x18, 0x24, 0x30, 0x3c].map((offset) => [offset, (read) => read(offset) | ((read(offset) & 1) << 1)]))),
    [SLOT.otp]: new Otp(chip, 'OTP_DATA', false),
    [SLOT.otpRaw]: new Otp(chip, 'OTP_DATA_RAW', true),
    [SLOT.dma]: chip.dma,
    [SLOT.usb]: old[0x50110],
    [SLOT.pio0]: remapped('PIO0', new PioRegisters(chip, 'PIO0', chip.pio[0]), registers.PIO),
    [SLOT.pio1]: remapped('PIO1', new PioRegisters(chip, 'PIO1', chip.pio[1]), registers.PIO),
    [SLOT.pio2]: remapped('PIO2', new PioRegisters(chip, 'PIO2', chip.pio[2]), registers.PIO),
  };
  XIP_SETUP.forEach((word, index) => chip.peripherals[SLOT.bootRam].writeUint32(4 * index, word >>> 0));
  attachCorePeripherals(chip, sio, new XipSpace(chip, flash, cache));
}

/** What is neither memory nor behind the peripherals' bridge: SIO, the core's own, and what flash has besides. */
function attachCorePeripherals(chip, sio, xip) {
  const { system } = chip.core;
  const { readUint32, writeUint32, writeUint8 } = chip;
  const [SIO_PAGE, CORE_PAGE] = [0xd, 0xe];
  chip.readUint32 = (address) => {
    const page = address >>> 28;
    if (page === SIO_PAGE) return sio.readUint32(address & 0xfff);
    if (xip.has(address)) return xip.read(address);
    return page === CORE_PAGE ? system.read(address) >>> 0 : readUint32.call(chip, address);
  };
  chip.writeUint32 = (address, value) => {
    const page = address >>> 28;
    if (page === SIO_PAGE) sio.writeUint32Atomic(address & 0xfff, value, 0);
    else if (page === CORE_PAGE) system.write(address, value | 0);
    else writeUint32.call(chip, address, value);
  };
  chip.writeUint8 = (address, value) => {
    if (address >>> 28 === CORE_PAGE) system.writeByte(address, value);
    else if (xip.has(address)) xip.write(address);
    else writeUint8.call(chip, address, value);
  };
}

/** Which source each clock has: the bit of the one that its control register names. */
function selected() {
  const [COUNT, BYTES, CTRL, SELECTED, REF, SYS] = [10, 0xc, 0, 8, 4, 5];
  const sources = (clock) => (clock === REF ? 3 : clock === SYS ? 1 : 0);
  return new Map(Array.from({ length: COUNT }, (_, clock) => [BYTES * clock + SELECTED, (read) => 1 << (read(BYTES * clock + CTRL) & sources(clock))]));
}

/** It is locked at once. */
function pll(chip, name) {
  return new Plain(chip, name, new Map([[0, (read) => read(0) | 0x80000000]]));
}

/** Starts the program as the ROM does: it looks for the mark of an image, and takes the vectors at the beginning of flash. */
function boot(chip, flash) {
  const { core } = chip;
  const view = new DataView(flash.bytes.buffer, flash.bytes.byteOffset);
  const isImage = Array.from({ length: MARK_BYTES / 4 }, (_, index) => view.getUint32(4 * index, true)).includes(IMAGE_MARK);
  if (!isImage) throw new Error(`there is no image definition in the first ${MARK_BYTES} bytes of flash: the RP2350's ROM would not start it`);
  core.VTOR = FLASH_START;
  core.SP = view.getUint32(0, true);
  core.PC = view.getUint32(4, true) & ~1;
}

/** rp2040js logs faults of the chip (a bad address). A missing register is only a warning. */
function logger(onWarning) {
  const silent = () => {};
  const warn = (component, message) => {
    if (component === 'RP2040') throw new Fault(message);
    onWarning(`${component}: ${message}`);
  };
  return { debug: silent, info: silent, warn, error: warn };
}
