import { CLOCK_HZ } from './clock.mjs';

/** What can be wrong with it, or with its wire. */
export const VFD_STATES = ['well', 'cut', 'garbled', 'tripped'];

const ADDRESS = 1;
const RAMP_HZ_PER_S = 200;
const [READ, WRITE] = [3, 6];
const [STATUS, COMMAND, FREQUENCY] = [0x2100, 0x2000, 0x2001];
const [FORWARD, REVERSE, STOP] = [0x12, 0x22, 0x01];
const FAULT = 4;
const ILLEGAL_ADDRESS = 2;

/** A DURAPULSE GS20 as far as its registers of run, frequency and status go. Its motor turns while its terminal for that is on. */
export class Vfd {
  state = 'well';
  requests = 0;
  #run = 0;
  #setHz = 0;
  #outputHz = 0;
  #cycle = 0;
  #enabled = false;

  /** @param {import('./clock.mjs').MachineClock} clock */
  constructor(clock) {
    this.clock = clock;
  }

  enable(enabled) {
    this.#advance();
    this.#enabled = enabled;
  }

  set(state) {
    this.#advance();
    this.state = state;
    if (state === 'tripped') this.#run = 0;
  }

  /** The reply to a frame, or null. @param {number[]} frame */
  answer(frame) {
    this.#advance();
    const body = frame.slice(0, -2);
    if (this.state === 'cut' || body.length < 2 || body[0] !== ADDRESS || !sameBytes(checksum(body), frame.slice(-2))) return null;
    this.requests += 1;
    const reply = this.#reply(body);
    const whole = [...reply, ...checksum(reply)];
    if (this.state === 'garbled') whole[2] ^= 4;
    return whole;
  }

  #reply([address, called, ...data]) {
    const [register, value] = [data[0] * 256 + data[1], data[2] * 256 + data[3]];
    if (called === READ && register === STATUS) return [address, called, 2 * value, ...this.#status().slice(0, value).flatMap(bytesOf)];
    if (called === WRITE && register === FREQUENCY) this.#setHz = value / 100;
    else if (called === WRITE && register === COMMAND) this.#command(value);
    else return [address, called + 0x80, ILLEGAL_ADDRESS];
    return [address, called, ...data];
  }

  #command(word) {
    if (this.state !== 'tripped') this.#run = { [FORWARD]: 1, [REVERSE]: -1, [STOP]: 0 }[word] ?? this.#run;
  }

  #status() {
    const fault = this.state === 'tripped' ? FAULT : 0;
    const hundredths = Math.round(Math.abs(this.#outputHz) * 100);
    return [fault, 0, Math.round(this.#setHz * 100), hundredths, this.drives ? 150 : 0];
  }

  get drives() {
    return this.#enabled && this.#run !== 0;
  }

  #advance() {
    const most = ((this.clock.cycles - this.#cycle) / CLOCK_HZ) * RAMP_HZ_PER_S;
    this.#cycle = this.clock.cycles;
    const target = this.drives ? this.#run * this.#setHz : 0;
    this.#outputHz += Math.max(-most, Math.min(most, target - this.#outputHz));
  }

  summary() {
    this.#advance();
    return { requests: this.requests, drives: this.drives, output_hz: this.#outputHz };
  }
}

const bytesOf = (word) => [word >> 8, word & 0xff];
const sameBytes = (one, other) => one.length === other.length && one.every((byte, index) => byte === other[index]);

/** The end of a frame, low byte first. */
export function checksum(bytes) {
  let sum = 0xffff;
  for (const byte of bytes) {
    sum ^= byte;
    for (let bit = 0; bit < 8; bit += 1) sum = sum & 1 ? (sum >> 1) ^ 0xa001 : sum >> 1;
  }
  return [sum & 0xff, sum >> 8];
}
