import assert from 'node:assert/strict';
import test from 'node:test';
import { buildChip } from '../src/chip.mjs';
import { CLOCK_HZ, MachineClock } from '../src/clock.mjs';
import { checksum, Vfd } from '../src/vfd.mjs';
import { VfdWire } from '../src/vfd-wire.mjs';

const UART0 = 0x40034000;
const [DR, FR, IBRD, FBRD, CR] = [0x00, 0x18, 0x24, 0x28, 0x30];
const [RX_EMPTY, ENABLED] = [1 << 4, 0x301];
const GPIO_CTRL = 0x40014004;
const [FUNCTION_UART, FUNCTION_SIO] = [2, 5];
const [OUT_SET, OUT_CLEAR, OUTPUTS_SET] = [0xd0000014, 0xd0000018, 0xd0000024];
const PADS = { tx: 0, rx: 1, sends: 28, enable: 14 };
/** At 9,600 baud, by the divider 813 51/64. */
const BYTE_CYCLES = 130_208;
const SILENCE_CYCLES = 3.5 * BYTE_CYCLES;
/** The character that the receiver hears when the chip lets go of the wire. */
const NOBODY = '00';

const bytes = (hex) => hex.split(' ').map((byte) => parseInt(byte, 16));
const hex = (values) => values.map((value) => value.toString(16).padStart(2, '0')).join(' ');
const framed = (text) => [...bytes(text), ...checksum(bytes(text))];

const SPEED_100_HZ = '01 06 20 01 27 10';
const RUN = '01 06 20 00 00 12';
const STOP = '01 06 20 00 00 01';
const READ_STATUS = '01 03 21 00 00 05';

/** A chip whose UART0 is at 9,600 baud on its pads, with a VFD. Its core stands still while time passes. */
class Bench {
  constructor() {
    this.clock = new MachineClock();
    const nothing = () => {};
    Object.assign(this, buildChip(this.clock, { onWatchdog: nothing, onUartByte: nothing, onWarning: nothing }));
    for (const pad of [PADS.tx, PADS.rx]) this.writeAt(GPIO_CTRL + 8 * pad, FUNCTION_UART);
    for (const pad of [PADS.sends, PADS.enable]) {
      this.writeAt(GPIO_CTRL + 8 * pad, FUNCTION_SIO);
      this.writeAt(OUTPUTS_SET, 1 << pad);
    }
    for (const [register, value] of [[IBRD, 813], [FBRD, 51], [CR, ENABLED]]) this.writeAt(UART0 + register, value);
    this.wire = new VfdWire(this.clock, PADS);
    this.wire.attach(this.chip);
  }

  set(pad, high) {
    this.writeAt(high ? OUT_SET : OUT_CLEAR, 1 << pad);
  }

  run(cycles) {
    const to = this.core.cycles + Math.round(cycles);
    while (this.clock.next <= to) {
      this.core.cycles = this.clock.next;
      this.clock.fireDue();
    }
    this.core.cycles = to;
  }

  /** Sends a frame, and lets go of the wire so many cycles after the end of its last character. */
  send(frame, releasedAfter = 1000) {
    this.set(PADS.sends, true);
    for (const byte of frame) this.writeAt(UART0 + DR, byte);
    this.run(frame.length * BYTE_CYCLES + releasedAfter);
    this.set(PADS.sends, false);
  }

  /** What the chip has received. */
  received() {
    const got = [];
    while ((this.bus.read32((UART0 + FR) | 0) & RX_EMPTY) === 0) got.push(this.bus.read32((UART0 + DR) | 0) & 0xff);
    return hex(got);
  }

  exchange(frame, releasedAfter) {
    this.send(frame, releasedAfter);
    this.run(30 * BYTE_CYCLES);
    return this.received();
  }

  writeAt(address, value) {
    this.bus.write32(address | 0, value | 0);
  }
}

test('the CRC is that of published frames, low byte first', () => {
  assert.deepEqual(checksum([]), [0xff, 0xff]);
  // The check value of CRC-16/MODBUS, 0x4b37.
  assert.deepEqual(checksum([...'123456789'].map((digit) => digit.charCodeAt(0))), [0x37, 0x4b]);
  // The example of the serial line specification, appendix B: CRC 0x1241 of an exception status request, sent as 41 12.
  assert.equal(hex(checksum(bytes('02 07'))), '41 12');
  // Examples that are in many manuals.
  assert.equal(hex(checksum(bytes('01 03 00 00 00 0a'))), 'c5 cd');
  assert.equal(hex(checksum(bytes('11 03 00 6b 00 03'))), '76 87');
  assert.equal(hex(checksum(bytes('01 04 02 ff ff'))), 'b8 80');
});

test('a frame with any wrong bit is not answered, nor taken', () => {
  const vfd = new Vfd(new MachineClock());
  const frame = framed(SPEED_100_HZ);
  for (let bit = 0; bit < 8 * frame.length; bit++) {
    const wrong = frame.map((byte, index) => (index === bit >> 3 ? byte ^ (1 << (bit & 7)) : byte));
    assert.equal(vfd.answer(wrong), null, `bit ${bit}`);
  }
  assert.equal(vfd.requests, 0);
  assert.equal(hex(vfd.answer(framed(READ_STATUS))), hex(framed('01 03 0a 00 00 00 00 00 00 00 00 00 00')));
});

test('a frame that is too short or to another address is not answered', () => {
  const vfd = new Vfd(new MachineClock());
  const others = ['00', '02', 'f7'].map((address) => framed(`${address} 06 20 00 00 12`));
  for (const frame of [[], [1], [1, 3], framed('01'), ...others]) assert.equal(vfd.answer(frame), null, hex(frame));
  assert.equal(vfd.requests, 0);
  assert.notEqual(vfd.answer(framed(RUN)), null);
  assert.equal(vfd.requests, 1);
});

test('what it has not is refused with exception 2', () => {
  const vfd = new Vfd(new MachineClock());
  assert.deepEqual(vfd.answer(framed('01 06 20 02 00 01')), framed('01 86 02'));
  assert.deepEqual(vfd.answer(framed('01 04 21 00 00 01')), framed('01 84 02'));
});

test('it answers 3.5 characters after the last one, and no sooner', () => {
  const bench = new Bench();
  bench.send(framed(RUN), 0);
  // The first character of the reply is heard when it has ended.
  bench.run(SILENCE_CYCLES + BYTE_CYCLES - 20);
  assert.equal(bench.received(), NOBODY);
  bench.run(40);
  assert.equal(bench.received(), '01');
  bench.run(7 * BYTE_CYCLES);
  assert.equal(bench.received(), hex(framed(RUN).slice(1)));
  assert.equal(bench.wire.violations, 0);
});

test('a pause in a frame of less than that is none, and a longer one ends it', () => {
  const answered = (pauseCharacters) => {
    const bench = new Bench();
    const frame = framed(RUN);
    bench.set(PADS.sends, true);
    for (const byte of frame.slice(0, 3)) bench.writeAt(UART0 + DR, byte);
    bench.run((3 + pauseCharacters) * BYTE_CYCLES);
    bench.send(frame.slice(3));
    bench.run(30 * BYTE_CYCLES);
    return bench.wire.vfd.requests;
  };
  assert.deepEqual([answered(3.4), answered(3.6)], [1, 0]);
});

test('who lets go of the wire before the last character has ended is found out', () => {
  const released = (after) => {
    const bench = new Bench();
    const heard = bench.exchange(framed(RUN), after);
    return [bench.wire.violations, bench.wire.vfd.requests, heard];
  };
  const reply = `${NOBODY} ${hex(framed(RUN))}`;
  assert.deepEqual(released(10), [0, 1, reply]);
  // The last character is lost, and the frame is none.
  assert.deepEqual(released(-100), [1, 0, NOBODY]);
  assert.deepEqual(released(-1.5 * BYTE_CYCLES), [2, 0, NOBODY]);
});

test('who takes the wire after a character has begun is found out', () => {
  const bench = new Bench();
  for (const byte of framed(RUN)) bench.writeAt(UART0 + DR, byte);
  bench.run(0.5 * BYTE_CYCLES);
  bench.set(PADS.sends, true);
  bench.run(7.5 * BYTE_CYCLES);
  bench.set(PADS.sends, false);
  bench.run(30 * BYTE_CYCLES);
  assert.deepEqual([bench.wire.violations, bench.wire.vfd.requests], [1, 0]);
});

test('who holds the wire until the VFD answers is found out, and does not hear it', () => {
  const released = (characters) => {
    const bench = new Bench();
    const heard = bench.exchange(framed(RUN), characters * BYTE_CYCLES);
    return [bench.wire.violations, heard, Math.round(bench.wire.summary().released_ns_max / 1000)];
  };
  const reply = hex(framed(RUN));
  assert.deepEqual(released(3.4), [0, `${NOBODY} ${reply}`, 3542]);
  const [violations, heard, micros] = released(3.6);
  assert.deepEqual([violations, micros], [1, 3750]);
  assert.notEqual(heard, `${NOBODY} ${reply}`);
  assert.deepEqual(released(20).slice(0, 2), [1, NOBODY]);
});

test('it turns by its ramp while it is let, in both directions', () => {
  const bench = new Bench();
  const hz = () => bench.wire.summary().output_hz;
  bench.exchange(framed(SPEED_100_HZ));
  bench.exchange(framed(RUN));
  bench.run(CLOCK_HZ);
  assert.deepEqual([hz(), bench.wire.vfd.drives], [0, false]);
  bench.set(PADS.enable, true);
  bench.run(CLOCK_HZ / 4);
  assert.equal(hz().toFixed(3), '50.000');
  bench.run(CLOCK_HZ);
  assert.equal(hz(), 100);
  assert.equal(bench.exchange(framed(READ_STATUS)), `${NOBODY} ${hex(framed('01 03 0a 00 00 00 00 27 10 27 10 00 96'))}`);
  bench.set(PADS.enable, false);
  bench.run(CLOCK_HZ / 4);
  assert.equal(hz().toFixed(3), '50.000');
  bench.exchange(framed(STOP));
  bench.set(PADS.enable, true);
  bench.run(CLOCK_HZ);
  assert.deepEqual([hz(), bench.wire.vfd.drives], [0, false]);
  bench.exchange(framed('01 06 20 00 00 22'));
  bench.run(CLOCK_HZ);
  assert.equal(hz(), -100);
});

test('one whose wire is cut goes on and is silent, one that is garbled answers wrongly, one that has tripped says so and stands', () => {
  const bench = new Bench();
  bench.set(PADS.enable, true);
  bench.exchange(framed(SPEED_100_HZ));
  bench.exchange(framed(RUN));
  bench.run(CLOCK_HZ);
  const { vfd } = bench.wire;
  vfd.set('cut');
  assert.equal(bench.exchange(framed(STOP)), NOBODY);
  assert.equal(bench.wire.summary().output_hz, 100);
  vfd.set('garbled');
  const garbled = bytes(bench.exchange(framed(READ_STATUS))).slice(1);
  assert.notDeepEqual(checksum(garbled.slice(0, -2)), garbled.slice(-2));
  vfd.set('tripped');
  bench.run(CLOCK_HZ);
  assert.equal(bench.wire.summary().output_hz, 0);
  assert.equal(bench.exchange(framed(READ_STATUS)), `${NOBODY} ${hex(framed('01 03 0a 00 04 00 00 27 10 00 00 00 00'))}`);
  vfd.set('well');
  bench.exchange(framed(RUN));
  assert.equal(vfd.drives, true);
});
