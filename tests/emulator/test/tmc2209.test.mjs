import assert from 'node:assert/strict';
import test from 'node:test';
import { MachineClock } from '../src/clock.mjs';
import { REGISTER } from '../src/tmc2209-registers.mjs';
import { Tmc2209 } from '../src/tmc2209.mjs';

const { GCONF, GSTAT, IFCNT, OTP_READ, IOIN, FACTORY_CONF, IHOLD_IRUN, TPOWERDOWN, TSTEP, TPWMTHRS, MSCNT, CHOPCONF, DRV_STATUS, PWMCONF } = REGISTER;
const [STANDS, STEALTH] = [2 ** 31, 2 ** 30];
/** Of 12 MHz, in cycles of 125 MHz. */
const CLOCK = 125 / 12;
const UART_AND_MRES = 0xc0;
const SECOND = 125_000_000;

function driver(address = 0, levels = { step: false, dir: false }) {
  const clock = new MachineClock();
  const diag = [];
  const it = new Tmc2209(clock, { address, seed: 1, levels: () => levels, onDiag: (high) => diag.push(high) });
  const run = (cycles) => {
    clock.core.cycles += cycles;
    clock.fireDue();
  };
  const step = (count, cycles, up = true) => {
    let driven = true;
    for (let at = 0; at < count; at++) {
      run(cycles);
      driven = it.step(up, false);
    }
    return driven;
  };
  return { it, diag, run, step, flags: () => it.read(DRV_STATUS) & 0xfff, current: () => (it.read(DRV_STATUS) >>> 16) & 0x1f };
}

test('after power-up the registers have the values of the data sheet', () => {
  const { it } = driver();
  assert.deepEqual([GCONF, GSTAT, IFCNT, CHOPCONF, PWMCONF, TSTEP, MSCNT].map((register) => it.read(register)), [0x101, 1, 0, 0x10000053, 0xc10d0024, 0xfffff, 0]);
  assert.equal(it.read(OTP_READ) & 0x1f, it.read(FACTORY_CONF));
  assert.deepEqual([it.runCurrent, it.holdCurrent, it.chopper], [31, 16, 'StealthChop']);
});

test('a register keeps its own bits, and one that can only be written reads as 0', () => {
  const { it } = driver();
  it.write(GCONF, 0xffffffff);
  it.write(CHOPCONF, 0x95000053);
  it.write(IHOLD_IRUN, 0x60f05);
  it.write(DRV_STATUS, 0xfff);
  it.write(0x7f, 1);
  assert.deepEqual([it.read(GCONF), it.read(CHOPCONF), it.read(IHOLD_IRUN), it.read(0x7f)], [0x3ff, 0x95000053, 0, 0]);
  assert.deepEqual([it.runCurrent, it.holdCurrent, it.chopper, it.read(IFCNT)], [15, 5, 'SpreadCycle', 5]);
  for (let count = 5; count < 257; count++) it.write(GCONF, 0);
  assert.equal(it.read(IFCNT), 1);
});

test('a flag of GSTAT is cleared by writing a one', () => {
  const { it } = driver();
  it.write(GSTAT, 2);
  assert.equal(it.read(GSTAT), 1);
  it.write(GSTAT, 1);
  assert.equal(it.read(GSTAT), 0);
});

test('IOIN shows the pins and the version', () => {
  const levels = { step: true, dir: true };
  const { it } = driver(2, levels);
  assert.equal(it.read(IOIN), 0x210002c8);
  Object.assign(levels, { step: false, dir: false });
  it.enable(false);
  assert.equal(it.read(IOIN), 0x21000049);
});

test('without mstep_reg_select the address pins say the microsteps', () => {
  const microsteps = [0, 1, 2, 3].map((address) => driver(address).it.microsteps);
  assert.deepEqual(microsteps, [8, 32, 64, 16]);
  const { it } = driver();
  it.write(GCONF, UART_AND_MRES);
  assert.equal(it.microsteps, 256);
  it.write(CHOPCONF, 0x14000053);
  assert.equal(it.microsteps, 16);
  it.write(CHOPCONF, 0x18000053);
  assert.equal(it.microsteps, 1);
});

test('MSCNT counts 1/256 of full steps, down with DIR low, and the other way with shaft', () => {
  const { it, step } = driver();
  step(3, 1000);
  assert.equal(it.read(MSCNT), 96);
  step(4, 1000, false);
  assert.equal(it.read(MSCNT), 992);
  it.write(GCONF, 8);
  step(2, 1000, false);
  assert.equal(it.read(MSCNT), 32);
});

test('TSTEP is the time of 1/256 step, and a motor stands 2^20 clocks after its last', () => {
  const { it, run, step } = driver();
  step(2, 32 * 300 * CLOCK);
  assert.equal(it.read(TSTEP), 300);
  assert.equal(it.read(DRV_STATUS) & STANDS, 0);
  run(Math.floor(2 ** 20 * CLOCK));
  assert.equal(it.read(TSTEP), 300);
  run(1);
  assert.equal(it.read(TSTEP), 0xfffff);
  assert.equal(it.read(DRV_STATUS), STANDS + STEALTH + (31 << 16));
});

test('the current falls to IHOLD after TPOWERDOWN, step by step, unless PDN_UART governs it', () => {
  const { it, run, current } = driver();
  it.write(IHOLD_IRUN, 0x11410);
  it.write(TPOWERDOWN, 2);
  assert.equal(current(), 20);
  it.write(GCONF, UART_AND_MRES);
  assert.equal(current(), 16);
  it.step(true, false);
  assert.equal(current(), 20);
  run(Math.ceil((2 ** 20 + 2 * 2 ** 18 + 2 ** 18) * CLOCK) - 1);
  assert.equal(current(), 20);
  run(1);
  assert.equal(current(), 19);
  run(SECOND);
  assert.equal(current(), 16);
});

test('beyond TPWMTHRS it is in SpreadCycle, with a hysteresis of 1/16', () => {
  const { it, step } = driver();
  const stealth = (tstep) => {
    step(2, Math.ceil(32 * tstep * CLOCK));
    return (it.read(DRV_STATUS) & STEALTH) !== 0;
  };
  it.write(TPWMTHRS, 320);
  assert.deepEqual([320, 299, 298, 319, 320].map(stealth), [true, true, false, false, true]);
  it.write(GCONF, 4);
  assert.equal(stealth(320), false);
});

test('a hot driver warns, and an overheated one is off until it is cool', () => {
  const { it, step, flags, diag } = driver();
  it.write(GSTAT, 1);
  it.set('hot');
  assert.equal(flags(), 0x101);
  assert.equal(step(1, 1000), true);
  assert.equal(it.read(GSTAT), 0);
  it.set('overheated');
  assert.equal(flags(), 0xf03);
  assert.equal(step(1, 1000), false);
  it.write(GSTAT, 2);
  assert.equal(it.read(GSTAT), 2);
  it.set('hot');
  assert.equal(flags(), 0x103);
  assert.equal(it.energised, false);
  it.set('well');
  assert.equal(flags(), 0);
  assert.equal(step(1, 1000), true);
  it.write(GSTAT, 2);
  assert.equal(it.read(GSTAT), 0);
  // DIAG stays until the driver is switched off.
  assert.deepEqual(diag, [true]);
  it.enable(false);
  assert.deepEqual(diag, [true, false]);
});

test('OTTRIM says from where on it is hot', () => {
  const { it, flags } = driver();
  it.write(FACTORY_CONF, 0x20e);
  it.set('hot');
  assert.equal(flags(), 0x100);
});

test('a short is kept until the driver is switched off by ENN or TOFF', () => {
  const { it, step, flags, diag } = driver();
  it.set('shorted');
  assert.deepEqual([flags(), it.read(GSTAT), step(1, 1000), it.diag], [4, 3, false, true]);
  it.set('well');
  assert.deepEqual([flags(), step(1, 1000)], [4, false]);
  it.write(CHOPCONF, 0x10000050);
  assert.deepEqual([flags(), it.diag, step(1, 1000)], [0, false, false]);
  it.write(CHOPCONF, 0x10000053);
  assert.equal(step(1, 1000), true);
  it.enable(false);
  it.set('shorted');
  assert.equal(flags(), 0);
  it.enable(true);
  assert.deepEqual([flags(), diag], [4, [true, false, true]]);
});

test('an open motor cable drives nothing, and is reported', () => {
  const { it, step, flags } = driver();
  it.set('open');
  assert.deepEqual([flags(), step(1, 1000), it.diag], [0xc0, false, false]);
  it.set('well');
  assert.deepEqual([flags(), step(1, 1000)], [0, true]);
});

test('a driver without supply makes no step, and has forgotten all when it is back', () => {
  const { it, step } = driver();
  it.write(GCONF, UART_AND_MRES);
  it.write(GSTAT, 1);
  step(3, 1000);
  it.set('off');
  assert.equal(step(1, 1000), false);
  it.set('on');
  assert.deepEqual([GCONF, GSTAT, IFCNT, MSCNT].map((register) => it.read(register)), [0x101, 1, 0, 0]);
  assert.equal(step(1, 1000), true);
});
