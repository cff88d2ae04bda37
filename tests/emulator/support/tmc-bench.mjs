import { buildChip } from '../src/chip.mjs';
import { MachineClock } from '../src/clock.mjs';
import { Gantry } from '../src/gantry.mjs';
import { BOARDS } from '../src/pins.mjs';
import { TmcWire } from '../src/tmc-wire.mjs';
import { Tmc2209 } from '../src/tmc2209.mjs';

const UART1 = 0x40038000;
const [DR, FR, IBRD, FBRD, CR] = [0x00, 0x18, 0x24, 0x28, 0x30];
const [RX_EMPTY, ENABLED] = [1 << 4, 0x301];
const GPIO_CTRL = 0x40014004;
const [FUNCTION_UART, FUNCTION_SIO] = [2, 5];
const [OUT_SET, OUT_CLEAR, OUTPUTS_SET] = [0xd0000014, 0xd0000018, 0xd0000024];
export const PADS = { tx: 8, rx: 9 };
/** At 115,200 baud, by the divider 67 52/64. */
export const BIT_CYCLES = 1085;
export const BYTE_CYCLES = 10 * BIT_CYCLES;
/** Long enough for a request, the longest delay and its answer. */
const EXCHANGE_CYCLES = 40 * BYTE_CYCLES;
const SKR_PICO = { board: 'skr-pico', startMm: [35, 40, 15], bounceMicros: 0, seed: 1, switches: {} };

export const bytes = (hex) => hex.split(' ').map((byte) => parseInt(byte, 16));
export const hex = (values) => values.map((value) => value.toString(16).padStart(2, '0')).join(' ');

/** A chip whose UART1 is at 115,200 baud on its pads, and whose core stands still while time passes. */
export class TmcBench {
  constructor() {
    this.clock = new MachineClock();
    const nothing = () => {};
    Object.assign(this, buildChip(this.clock, { onWatchdog: nothing, onUartByte: nothing, onWarning: nothing }));
    for (const pad of Object.values(PADS)) this.writeAt(GPIO_CTRL + 8 * pad, FUNCTION_UART);
    this.setBaud(67, 52);
    this.control(ENABLED);
  }

  setBaud(whole, part) {
    this.write(IBRD, whole);
    this.write(FBRD, part);
  }

  /** UARTEN is bit 0, TXE 8, RXE 9. */
  control(bits) {
    this.write(CR, bits);
  }

  /** Takes a pad from the UART. */
  disconnect(pad) {
    this.writeAt(GPIO_CTRL + 8 * pad, FUNCTION_SIO);
  }

  /** Drivers at these addresses, on a wire to the chip. */
  withDrivers(...addresses) {
    this.drivers = addresses.map((address) => new Tmc2209(this.clock, { address, seed: 1, levels: () => ({ step: false, dir: false }) }));
    this.wire = new TmcWire(this.clock, PADS, this.drivers);
    this.wire.attach(this.chip);
    return this;
  }

  /** The gantry of an SKR Pico, with its STEP, DIR and ENABLE driven low. */
  withGantry(options = {}) {
    this.gantry = new Gantry(this.clock, { ...SKR_PICO, ...options });
    this.gantry.attach(this.chip);
    const { axes } = BOARDS['skr-pico'];
    for (const { step, dir, enable } of Object.values(axes)) {
      for (const pin of [step, dir, enable]) {
        this.writeAt(GPIO_CTRL + 8 * pin, FUNCTION_SIO);
        this.writeAt(OUTPUTS_SET, 1 << pin);
      }
    }
    return this;
  }

  /** @param {string} axis @param {'step' | 'dir' | 'enable'} signal */
  set(axis, signal, high) {
    this.writeAt(high ? OUT_SET : OUT_CLEAR, 1 << BOARDS['skr-pico'].axes[axis][signal]);
  }

  /** Steps at this distance, beginning one from now. */
  step(axis, count, apartCycles) {
    for (let step = 0; step < count; step++) {
      this.run(apartCycles - 100);
      this.set(axis, 'step', true);
      this.run(100);
      this.set(axis, 'step', false);
    }
  }

  run(cycles) {
    this.runTo(this.core.cycles + cycles);
  }

  runTo(cycle) {
    while (this.clock.next <= cycle) {
      this.core.cycles = this.clock.next;
      this.clock.fireDue();
    }
    this.core.cycles = cycle;
  }

  send(text) {
    for (const byte of bytes(text)) this.write(DR, byte);
  }

  /** What the chip has received. */
  received() {
    const got = [];
    while ((this.bus.read32((UART1 + FR) | 0) & RX_EMPTY) === 0) got.push(this.bus.read32((UART1 + DR) | 0));
    return hex(got);
  }

  /** Sends a datagram, and gives what came after its echo. */
  exchange(text) {
    this.send(text);
    this.run(EXCHANGE_CYCLES);
    const received = this.received();
    if (!received.startsWith(text)) throw new Error(`no echo of ${text}, but ${received}`);
    return received.slice(text.length).trim();
  }

  write(register, value) {
    this.writeAt(UART1 + register, value);
  }

  writeAt(address, value) {
    this.bus.write32(address | 0, value | 0);
  }
}
