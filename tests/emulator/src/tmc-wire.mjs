import { CLOCK_HZ, cyclesOfMillis } from './clock.mjs';
import { answer, DatagramReader } from './tmc2209-datagram.mjs';

const FUNCTION_UART = 2;
const BITS_PER_BYTE = 10;
/** What a driver with a clock of 12 MHz hears (data sheet 4.1.1). */
const [LOWEST_BAUD, HIGHEST_BAUD] = [9000, 750_000];
const LATE_CYCLES = cyclesOfMillis(5);
/** The bit that is wrong in a garbled answer. */
const [WRONG_BYTE, WRONG_BIT] = [4, 1 << 3];

/** The one wire between the chip's UART1 and the drivers, on which all hear all, the chip its own bytes too. */
export class TmcWire {
  #reader = new DatagramReader();
  /** The byte on the wire, the low bits of all who talk at once. @type {{byte: number, bitCycles: number} | null} */
  #sounding = null;
  #end;

  /**
   * @param {import('./clock.mjs').MachineClock} clock
   * @param {{tx: number, rx: number}} pads
   * @param {import('./tmc2209.mjs').Tmc2209[]} drivers
   */
  constructor(clock, pads, drivers) {
    Object.assign(this, { clock, pads, drivers });
    this.#end = clock.createOutsideAlarm(() => this.#ended());
  }

  /** Connects it to a chip that has just been powered or reset. */
  attach(chip) {
    this.chip = chip;
    chip.uart1.onStart = (byte) => {
      if (chip.uart1.sends && this.#isConnected(this.pads.tx)) this.#say(byte, chip.uart1.bitCycles);
    };
  }

  /** Somebody begins a byte. One that begins while another is on the wire spoils it, and is lost itself. */
  #say(byte, bitCycles) {
    const { cycles } = this.clock;
    // The byte before may end on this very cycle.
    if (this.#end.scheduled && this.#end.dueCycle <= cycles) this.#ended();
    if (this.#sounding !== null) {
      this.#sounding.byte &= byte;
      return;
    }
    this.#sounding = { byte, bitCycles };
    this.#end.scheduleAt(cycles + Math.max(1, Math.round(BITS_PER_BYTE * bitCycles)));
  }

  #ended() {
    const { byte, bitCycles } = this.#sounding;
    this.#sounding = null;
    this.#end.cancel();
    this.#toChip(byte);
    const baud = CLOCK_HZ / bitCycles;
    if (baud >= LOWEST_BAUD && baud <= HIGHEST_BAUD) this.#toDrivers(byte, bitCycles);
  }

  #toChip(byte) {
    const { uart1 } = this.chip;
    if (uart1.ready && this.#isConnected(this.pads.rx)) uart1.receive(byte);
  }

  #isConnected(pad) {
    return this.chip.gpio[pad].functionSelect === FUNCTION_UART;
  }

  #toDrivers(byte, bitCycles) {
    const datagram = this.#reader.hear(byte, this.clock.cycles, bitCycles);
    if (datagram === null) return;
    for (const driver of this.drivers) {
      if (driver.powered && driver.address === datagram.address) this.#take(driver, datagram, bitCycles);
    }
  }

  #take(driver, { register, write, value, intact }, bitCycles) {
    if (!intact) {
      driver.refused += 1;
    } else if (write) {
      driver.writes += 1;
      driver.write(register, value);
    } else {
      driver.reads += 1;
      this.#answer(driver, answer(register, driver.read(register)), bitCycles);
    }
  }

  #answer(driver, bytes, bitCycles) {
    const { faults } = driver;
    if (faults.garbled && driver.reads % 2 === 0) bytes[WRONG_BYTE] ^= WRONG_BIT;
    const byteCycles = Math.round(BITS_PER_BYTE * bitCycles);
    const talk = this.clock.createOutsideAlarm(() => {
      if (!driver.powered) return;
      this.#say(bytes.shift(), bitCycles);
      if (bytes.length > 0) talk.scheduleAt(this.clock.cycles + byteCycles);
    });
    talk.scheduleAt(this.clock.cycles + Math.round(driver.sendDelayBits * bitCycles) + (faults.late ? LATE_CYCLES : 0));
  }
}
