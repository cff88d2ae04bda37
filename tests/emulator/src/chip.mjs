import { RP2040 } from 'rp2040js';
import { Bus } from './bus.mjs';
import { run } from './core.mjs';
import { DeadlineWatch } from './deadline-watch.mjs';
import { Dma } from './dma.mjs';
import { Fault, FetchFault } from './fault.mjs';
import { Flash, FLASH_START, hiddenFlash, isFlash } from './flash.mjs';
import { LateAlarms } from './late-alarms.mjs';
import { Lockstep } from './lockstep.mjs';
import { PadInputs } from './pad-inputs.mjs';
import { PioBlock } from './pio/block.mjs';
import { PioRegisters } from './pio/registers.mjs';
import { Pwm } from './pwm.mjs';
import { loadRom } from './rom/rom.mjs';
import { boot } from './second-stage.mjs';
import { Sleep } from './sleep.mjs';
import { identifyAsB2 } from './sys-info.mjs';
import { SysTick } from './systick.mjs';
import { ExactTimer } from './timer.mjs';
import { Uart } from './uart.mjs';
import { Watchdog } from './watchdog.mjs';
import { FlashCounts, XipCache } from './xip-cache.mjs';
import { XipControl } from './xip-control.mjs';

const RAM_START = 0x20000000;
const SLOT = { ssi: 0x18000, sysInfo: 0x40000, xipControl: 0x14000, pwm: 0x40050, timer: 0x40054, watchdog: 0x40058, uart0: 0x40034, uart1: 0x40038, dma: 0x50000, pio0: 0x50200, pio1: 0x50300 };
const [IRQ_UART0, IRQ_UART1] = [20, 21];
const [IRQ_PIO0, IRQ_PIO1] = [7, 9];

/**
 * An RP2040 with the project's own timer, watchdog, UARTs, PWM, PIO, DMA, SysTick and waking, on the machine's clock.
 *
 * @param {import('./clock.mjs').MachineClock} clock
 * @param {{onWatchdog: (reason: number) => void, onUartByte: (byte: number) => void, onWarning: (text: string) => void}} board
 *   what the chip tells the board
 * @param {{missFactor?: number | null, counts?: FlashCounts, watch?: DeadlineWatch, lateAlarms?: LateAlarms}} options
 *   what a miss of flash's cache costs, times the reckoned cycles; where its accesses are counted, and who watches those that
 *   matter; where the timer's alarms are counted that were set too late
 */
export function buildChip(clock, board, { missFactor = 1, counts = new FlashCounts(), watch = new DeadlineWatch(clock), lateAlarms = new LateAlarms() } = {}) {
  const powerUpCycle = clock.core.cycles;
  const chip = new RP2040(clock);
  chip.logger = quietLogger(board.onWarning);
  chip.core.cycles = powerUpCycle;
  clock.core = chip.core;
  chip.core.setInterrupt = setInterrupt;
  chip.core.sleep = new Sleep(chip.core, board.onWarning);
  chip.core.sleep.attach(chip.ppb);
  chip.onBootsel = board.onBootsel;
  chip.onBreak = (code) => {
    throw new Fault(`a breakpoint or an undefined instruction (number ${code})`);
  };
  const timer = new ExactTimer(chip, 'TIMER', lateAlarms);
  const watchdog = new Watchdog(chip, 'WATCHDOG', board.onWatchdog);
  const cache = new XipCache(clock, counts, missFactor);
  const flash = new Flash(chip, cache);
  const uart = new Uart(chip, 'UART0', IRQ_UART0, board.onUartByte);
  chip.uart0 = uart;
  chip.uart1 = new Uart(chip, 'UART1', IRQ_UART1, () => {});
  Object.assign(chip.peripherals, { [SLOT.ssi]: flash.interface, [SLOT.xipControl]: new XipControl(chip, 'XIP_CTRL', cache) });
  identifyAsB2(chip.peripherals[SLOT.sysInfo]);
  chip.pwm = new Pwm(chip, 'PWM');
  Object.assign(chip.peripherals, { [SLOT.pwm]: chip.pwm });
  Object.assign(chip.peripherals, { [SLOT.timer]: timer, [SLOT.watchdog]: watchdog, [SLOT.uart0]: uart, [SLOT.uart1]: chip.uart1 });
  loadRom(chip);
  new SysTick(chip).attach(chip.ppb);
  runBeside(chip, clock, cache);
  const bus = new Bus(chip, flash, cache, watch);
  watch.attach(chip.core);
  chip.dma.onAccess = (address, cycle) => bus.contend(address, cycle);
  watchExceptions(clock, bus);
  return { chip, core: chip.core, bus, cache, flash, watchdog, uart, runCore: run, boot: () => boot(chip, flash), holdInterrupt: holdInterrupt(chip.core) };
}

/** Replaces rp2040js's PIO and DMA by ours, which run in step with the core. */
function runBeside(chip, clock, cache) {
  const lockstep = new Lockstep(clock);
  clock.lockstep = lockstep;
  const dma = new Dma(chip, 'DMA', lockstep, cache);
  const pio = [new PioBlock(chip, 0, { irq: IRQ_PIO0, lockstep }), new PioBlock(chip, 1, { irq: IRQ_PIO1, lockstep })];
  Object.assign(chip, { dma, pio });
  const registers = pio.map((block, index) => new PioRegisters(chip, `PIO${index}`, block));
  Object.assign(chip.peripherals, { [SLOT.dma]: dma, [SLOT.pio0]: registers[0], [SLOT.pio1]: registers[1] });
  for (const part of [...pio, dma]) lockstep.add(part);
  for (const block of pio) block.onRequest = (number, cycle) => dma.request(number, cycle);
  new PadInputs(chip, pio, clock);
}

/** Writes the ELF's segments to the addresses where a flashing tool would write them. */
export function loadInto(chip, segments) {
  for (const { address, bytes } of segments) {
    const [memory, start] = address >= RAM_START ? [chip.sram, RAM_START] : [chip.flash, FLASH_START];
    const offset = address - start;
    if (offset < 0 || offset + bytes.length > memory.length) {
      throw new Error(`the ELF loads ${bytes.length} bytes at 0x${address.toString(16)}, outside flash and RAM`);
    }
    memory.set(bytes, offset);
  }
}

/** What holds interrupts back: they stay pending, and the firmware may enable and disable them meanwhile. */
function holdInterrupt(core) {
  let [pending, held] = [0, 0];
  return (number, isHeld) => {
    if (held === 0) pending = core.pendingInterrupts;
    held = isHeld ? held | (1 << number) : held & ~(1 << number);
    const get = () => pending & ~held;
    const set = (value) => void (pending = value | (pending & held));
    Object.defineProperty(core, 'pendingInterrupts', { configurable: true, get, set });
    if (isHeld) return;
    core.interruptsUpdated = true;
    core.sleep.enabled();
  };
}

/**
 * rp2040js enters the handler of a sleeping core at once, whatever PRIMASK is. Here the core is only woken, and the run
 * loop decides.
 */
function setInterrupt(irq, asserted) {
  const bit = 1 << irq;
  if (!asserted) {
    this.pendingInterrupts &= ~bit;
  } else if (!(this.pendingInterrupts & bit)) {
    this.pendingInterrupts |= bit;
    this.interruptsUpdated = true;
    this.sleep.pended();
  }
}

/** Counts the time in handlers (nested ones as one), reads vectors where the core does, and informs the watch. */
export function watchExceptions(clock, bus) {
  const { core, flash, watch } = bus;
  const { exceptionEntry, exceptionReturn, writeSpecialRegister } = core;
  clock.leaveHandlers();
  core.exceptionEntry = (number) => {
    const vector = core.VTOR + 4 * number;
    if (isFlash(vector) && !flash.readable) throw new FetchFault(hiddenFlash(vector));
    clock.enterHandler();
    exceptionEntry.call(core, number);
    // Bit 0 of a vector only says that the handler is Thumb code. In the PC, it would shift what a handler reads by it.
    core.PC &= ~1;
    bus.emptyPipeline();
    watch.update();
    if (isFlash(vector)) bus.readVector(vector);
  };
  core.exceptionReturn = (value) => {
    exceptionReturn.call(core, value);
    if (core.IPSR === 0) clock.leaveHandlers();
    watch.update();
  };
  core.writeSpecialRegister = (register, value) => {
    writeSpecialRegister.call(core, register, value);
    watch.update();
  };
}

/** rp2040js logs faults of the chip (a bad address or instruction). A missing register is only a warning. */
function quietLogger(onWarning) {
  const silent = () => {};
  const warn = (component, message) => {
    if (component === 'RP2040' || component === 'CortexM0Core') throw new Fault(message);
    onWarning(`${component}: ${message}`);
  };
  return { debug: silent, info: silent, warn, error: warn };
}
