import assert from 'node:assert/strict';
import test from 'node:test';
import { crc8 } from '../src/tmc2209-datagram.mjs';
import { BIT_CYCLES, BYTE_CYCLES, bytes, PADS, TmcBench } from '../support/tmc-bench.mjs';

const READ_COUNT = '05 00 02 8f';
const WRITE_GCONF = '05 00 80 00 00 00 c4 a0';

test('the CRC is the remainder of a division by x^8 + x^2 + x + 1, of bits from the lowest on', () => {
  // 05 00 00 is x^23 + x^21, which times x^8 leaves x^6 + x^3.
  assert.equal(crc8(bytes('05 00 00')), 0x48);
  assert.equal(crc8(bytes('05 00 02')), 0x8f);
  assert.equal(crc8(bytes('05 02 06')), 0x34);
  assert.equal(crc8(bytes('05 ff 02 00 00 00 01')), 0xc5);
});

test('a read request is heard by all, the chip too, and answered eight bit times later', () => {
  const bench = new TmcBench().withDrivers(0);
  bench.send(READ_COUNT);
  bench.run(4 * BYTE_CYCLES - 1);
  assert.equal(bench.received(), '05 00 02');
  bench.run(1);
  assert.equal(bench.received(), '8f');
  bench.run(8 * BIT_CYCLES + BYTE_CYCLES - 1);
  assert.equal(bench.received(), '');
  bench.run(1);
  assert.equal(bench.received(), '05');
  bench.run(7 * BYTE_CYCLES);
  assert.equal(bench.received(), 'ff 02 00 00 00 00 4c');
});

test('NODECONF says how long after', () => {
  const bench = new TmcBench().withDrivers(0);
  bench.exchange('05 00 83 00 00 02 00 4d');
  bench.send(READ_COUNT);
  bench.run(4 * BYTE_CYCLES + 3 * 8 * BIT_CYCLES + BYTE_CYCLES - 1);
  assert.equal(bench.received(), READ_COUNT);
  bench.run(1);
  assert.equal(bench.received(), '05');
});

test('a write with the right CRC is taken, counted, and not answered', () => {
  const bench = new TmcBench().withDrivers(0);
  assert.equal(bench.exchange(WRITE_GCONF), '');
  assert.equal(bench.exchange(READ_COUNT), '05 ff 02 00 00 00 01 c5');
  assert.equal(bench.drivers[0].read(0x00), 0xc4);
  const { reads, writes, refused } = bench.drivers[0];
  assert.deepEqual({ reads, writes, refused }, { reads: 1, writes: 1, refused: 0 });
});

test('a wrong CRC is refused, and nothing is heard until the wire was idle for twelve bit times', () => {
  const bench = new TmcBench().withDrivers(0);
  assert.equal(bench.exchange('05 00 80 00 00 00 c4 a1'), '');
  assert.equal(bench.drivers[0].refused, 1);
  assert.equal(bench.drivers[0].read(0x00), 0x101);
  bench.send(`05 00 02 8e ${READ_COUNT}`);
  bench.run(30 * BYTE_CYCLES);
  assert.equal(bench.received(), `05 00 02 8e ${READ_COUNT}`);
  bench.send('05 00 02 8e');
  bench.run(4 * BYTE_CYCLES + 12 * BIT_CYCLES);
  bench.received();
  assert.equal(bench.exchange(READ_COUNT), '05 ff 02 00 00 00 00 4c');
});

test('a datagram begins with the sync nibble', () => {
  const bench = new TmcBench().withDrivers(0);
  // All have their right CRC; the bits above the nibble may be any.
  assert.deepEqual(['04 00 02 84', '07 00 02 09', '95 00 02 b5'].map((request) => bench.exchange(request).length > 0), [false, false, true]);
});

test('a datagram that pauses for more than 63 bit times between two starts begins anew', () => {
  const split = (pauseBits) => {
    const bench = new TmcBench().withDrivers(0);
    bench.send('05 00');
    bench.run(2 * BYTE_CYCLES + pauseBits * BIT_CYCLES);
    bench.send('02 8f');
    bench.run(30 * BYTE_CYCLES);
    return bench.received().length;
  };
  assert.equal(split(53), '05 00 02 8f 05 ff 02 00 00 00 00 4c'.length);
  assert.equal(split(54), READ_COUNT.length);
});

test('a driver answers to its own address only', () => {
  const bench = new TmcBench().withDrivers(0, 2);
  assert.equal(bench.exchange('05 02 06 34'), '05 ff 06 21 00 00 48 3f');
  assert.deepEqual(bench.drivers.map(({ reads }) => reads), [0, 1]);
  assert.equal(bench.exchange('05 03 6f 69'), '');
});

test('two drivers with one address both answer, and where they differ the answer is garbled', () => {
  const bench = new TmcBench().withDrivers(0, 0);
  assert.equal(bench.exchange(READ_COUNT), '05 ff 02 00 00 00 00 4c');
  bench.drivers[1].write(0x00, 0xc4);
  // 4c and c5 at once.
  assert.equal(bench.exchange(READ_COUNT), '05 ff 02 00 00 00 00 44');
});

test('who talks while another does garbles both', () => {
  const bench = new TmcBench().withDrivers(0);
  bench.send(READ_COUNT);
  bench.run(4 * BYTE_CYCLES + 8 * BIT_CYCLES + 100);
  bench.received();
  bench.send('00');
  bench.run(10 * BYTE_CYCLES);
  assert.equal(bench.received(), '00 ff 02 00 00 00 00 4c');
});

test('a receiver that nobody reads keeps 32 bytes, and marks the next', () => {
  const bench = new TmcBench().withDrivers(0);
  for (let request = 0; request < 3; request++) {
    bench.send(READ_COUNT);
    bench.run(20 * BYTE_CYCLES);
  }
  const received = bench.received().split(' ');
  assert.equal(received.length, 32);
  assert.deepEqual(received.slice(28), ['05', 'ff', '02', '00']);
  bench.send('05');
  bench.run(BYTE_CYCLES);
  assert.equal(bench.received(), '805');
});

test('nothing is said or heard without the pad, or by a half of the UART that is off', () => {
  const heard = (switchOff) => {
    const bench = new TmcBench().withDrivers(0);
    switchOff(bench);
    bench.send(READ_COUNT);
    bench.run(20 * BYTE_CYCLES);
    return [bench.received(), bench.drivers[0].reads];
  };
  assert.deepEqual(heard((bench) => bench.disconnect(PADS.tx)), ['', 0]);
  assert.deepEqual(heard((bench) => bench.disconnect(PADS.rx)), ['', 1]);
  assert.deepEqual(heard((bench) => bench.control(0x201)), ['', 0]);
  assert.deepEqual(heard((bench) => bench.control(0x101)), ['', 1]);
});

test('a driver hears rates from 9,000 to 750,000 baud, and answers at the same', () => {
  const reads = (whole, part) => {
    const bench = new TmcBench().withDrivers(0);
    bench.setBaud(whole, part);
    bench.send(READ_COUNT);
    bench.run(125_000_000);
    return bench.received().length > READ_COUNT.length ? bench.drivers[0].reads : 0;
  };
  // 8,995 and 9,005 baud; 748,500 and 753,000.
  assert.deepEqual([reads(868, 32), reads(867, 36), reads(10, 28), reads(10, 24)], [0, 1, 1, 0]);
});

test('a driver whose supply is off is silent, and starts anew when it is back', () => {
  const bench = new TmcBench().withDrivers(0);
  const [driver] = bench.drivers;
  bench.exchange(WRITE_GCONF);
  driver.write(0x01, 1);
  driver.set('off');
  assert.equal(bench.exchange(READ_COUNT), '');
  driver.set('on');
  assert.equal(bench.exchange(READ_COUNT), '05 ff 02 00 00 00 00 4c');
  assert.equal(bench.exchange('05 00 00 48'), '05 ff 00 00 00 01 01 bb');
  assert.equal(driver.read(0x01), 1);
  bench.send(READ_COUNT);
  bench.run(7 * BYTE_CYCLES);
  driver.set('off');
  bench.run(10 * BYTE_CYCLES);
  assert.equal(bench.received(), `${READ_COUNT} 05 ff 02`);
});

test('a driver that is late answers 5 ms later, and one that is garbled wrongly every second time', () => {
  const bench = new TmcBench().withDrivers(0);
  const [driver] = bench.drivers;
  driver.set('late');
  assert.equal(bench.exchange(READ_COUNT), '');
  bench.run(625_000);
  assert.equal(bench.received(), '05 ff 02 00 00 00 00 4c');
  driver.set('well');
  driver.set('garbled');
  const answers = [0, 1, 2, 3].map(() => bench.exchange(READ_COUNT));
  const [right, wrong] = ['05 ff 02 00 00 00 00 4c', '05 ff 02 00 08 00 00 4c'];
  assert.deepEqual(answers, [wrong, right, wrong, right]);
  driver.set('well');
  assert.deepEqual([bench.exchange(READ_COUNT), bench.exchange(READ_COUNT)], [right, right]);
});
