import assert from 'node:assert/strict';
import test from 'node:test';
import { MachineClock } from '../src/clock.mjs';
import { LateAlarms } from '../src/late-alarms.mjs';
import { ExactTimer } from '../src/timer.mjs';
import { Uart } from '../src/uart.mjs';
import { bulkEndpoints } from '../src/usb-descriptors.mjs';
import { RESET_TIMER, Watchdog } from '../src/watchdog.mjs';

function chip() {
  const clock = new MachineClock();
  const interrupts = new Map();
  return { clock, interrupts, setInterrupt: (irq, on) => interrupts.set(irq, on), logger: {} };
}

function runTo(clock, cycle) {
  while (clock.next <= cycle) {
    clock.core.cycles = clock.next;
    clock.fireDue();
  }
  clock.core.cycles = cycle;
}

const write = (peripheral, offset, value) => peripheral.writeUint32Atomic(offset, value, 0);

test('an alarm fires on the cycle of its microsecond, wherever in one it was set', () => {
  const on = chip();
  const timer = new ExactTimer(on, 'TIMER');
  write(timer, 0x38, 1);
  runTo(on.clock, 124);
  write(timer, 0x10, 3);
  runTo(on.clock, 374);
  assert.equal(on.interrupts.get(0), false);
  assert.equal(timer.readUint32(0x28), 2);
  runTo(on.clock, 375);
  assert.equal(on.interrupts.get(0), true);
  assert.equal(timer.readUint32(0x28), 3);
});

test('an alarm for a time that has passed waits for the counter to come round', () => {
  const on = chip();
  const timer = new ExactTimer(on, 'TIMER');
  runTo(on.clock, 1250);
  write(timer, 0x10, 9);
  assert.equal(on.clock.next, (2 ** 32 + 9) * 125);
  write(timer, 0x20, 1);
  assert.equal(on.clock.next, Infinity);
});

test('an alarm that was set too late counts until it is set again, unless that is soon', () => {
  const on = chip();
  const late = new LateAlarms();
  const timer = new ExactTimer(on, 'TIMER', late);
  const setAt = (micros, target) => {
    runTo(on.clock, micros * 125);
    write(timer, 0x10, target);
  };
  setAt(10, 2 ** 32 - 1);
  setAt(40, 50);
  assert.equal(late.summary(on.clock.cycles).count, 0);
  setAt(60, 60);
  setAt(160, 159);
  assert.deepEqual(late.summary(on.clock.cycles), { count: 1, longest_us: 100, first_t_ns: 60_000 });
  setAt(165, 300);
  setAt(400, 399);
  setAt(410, 410);
  runTo(on.clock, 700 * 125);
  assert.deepEqual(late.summary(on.clock.cycles), { count: 2, longest_us: 290, first_t_ns: 60_000 });
});

test('the watchdog bites when it is not fed, at two counts a microsecond', () => {
  const on = chip();
  const bites = [];
  const watchdog = new Watchdog(on, 'WATCHDOG', (reason) => bites.push([on.clock.cycles, reason]));
  write(watchdog, 0x04, 200);
  write(watchdog, 0x00, 1 << 30);
  runTo(on.clock, 99 * 125);
  assert.equal(watchdog.readUint32(0x00) & 0xffffff, 2);
  write(watchdog, 0x04, 200);
  runTo(on.clock, 250 * 125);
  assert.deepEqual(bites, [[199 * 125, RESET_TIMER]]);
});

test('UART bytes take their time, and a lone one raises the receive time-out', () => {
  const on = chip();
  const sent = [];
  const uart = new Uart(on, 'UART0', 20, (byte) => sent.push([on.clock.cycles, byte]));
  write(uart, 0x24, 10);
  write(uart, 0x38, 0x50);
  write(uart, 0x00, 0x41);
  write(uart, 0x00, 0x42);
  uart.receive(0x43);
  runTo(on.clock, 5120);
  assert.deepEqual(sent, [[1600, 0x41], [3200, 0x42]]);
  assert.equal(on.interrupts.get(20), true);
  assert.equal(uart.readUint32(0x00), 0x43);
  assert.equal(on.interrupts.get(20), false);
});

test('a UART tells the beginning of each byte', () => {
  const on = chip();
  const begun = [];
  const uart = new Uart(on, 'UART1', 21, () => {});
  uart.onStart = (byte) => begun.push([on.clock.cycles, byte]);
  write(uart, 0x24, 10);
  write(uart, 0x00, 0x41);
  write(uart, 0x00, 0x42);
  runTo(on.clock, 3200);
  assert.deepEqual(begun, [[0, 0x41], [1600, 0x42]]);
});

test('a full UART loses bytes and says so', () => {
  const uart = new Uart(chip(), 'UART0', 20, () => {});
  write(uart, 0x24, 10);
  for (let byte = 0; byte < 33; byte++) uart.receive(byte);
  const received = Array.from({ length: 32 }, () => uart.readUint32(0x00));
  assert.equal(received.at(-1), 31);
  uart.receive(99);
  assert.equal(uart.readUint32(0x00), 99 | (1 << 11));
});

test('CDC-ACM endpoints are found by class, and their absence is an error', () => {
  const communications = [9, 4, 0, 0, 1, 2, 2, 0, 0, 7, 5, 0x81, 3, 8, 0, 255];
  const data = [9, 4, 1, 0, 2, 10, 0, 0, 0, 7, 5, 0x02, 2, 64, 0, 0, 7, 5, 0x82, 2, 64, 0, 0];
  assert.deepEqual(bulkEndpoints([...communications, ...data]), { interface: 0, in: 2, out: 2 });
  assert.throws(() => bulkEndpoints(communications), /no CDC-ACM/);
});

test('alarms of one cycle fire in the order in which they were set, and a reset spares those outside the chip', () => {
  const clock = new MachineClock();
  const fired = [];
  clock.createAlarm(() => fired.push('chip')).scheduleAt(5);
  clock.createOutsideAlarm(() => fired.push('first')).scheduleAt(10);
  clock.createOutsideAlarm(() => fired.push('second')).scheduleAt(10);
  clock.dropChipAlarms();
  runTo(clock, 10);
  assert.deepEqual(fired, ['first', 'second']);
});
