import assert from 'node:assert/strict';
import test from 'node:test';
import { kindOf } from '../src/console.mjs';
import { HELP, parseOptions } from '../src/options.mjs';
import { differences } from '../src/position-check.mjs';
import { ProbePlate } from '../src/probe-plate.mjs';
import { COMMANDS, parseScript, ScriptRun } from '../src/script.mjs';

test('a script is commands with checked arguments', () => {
  const script = parseScript('# home\n\nsend G1 X1\nbytes 18 3f\nswitch X stuck-closed\nwait-ms 0.5\nreading off\n');
  assert.deepEqual(script.map(({ number, word }) => [number, word]), [[3, 'send'], [4, 'bytes'], [5, 'switch'], [6, 'wait-ms'], [7, 'reading']]);
  assert.equal(Buffer.from(script[0].argument).toString(), 'G1 X1\n');
  assert.deepEqual([...script[1].argument], [0x18, 0x3f]);
  assert.deepEqual(script[2].argument, ['X', 'stuck-closed']);
  assert.deepEqual([script[3].argument, script[4].argument], [0.5, false]);
});

test('the reported position is held against the counted steps, and may be any that was passed meanwhile', () => {
  const status = '<Run|MPos:1.020,-0.040,0.000|FS:997,0>';
  assert.deepEqual(differences(status, [51, -2, 0], [51, -2, 0]), []);
  assert.deepEqual(differences(status, [50, -3, 0], [52, -2, 0]), []);
  assert.deepEqual(differences(status, [52, -2, 0], [52, -2, 0]), ['X is reported at 51 steps, and 52 left the pin']);
  assert.deepEqual(differences(status, [51, -5, 0], [51, -3, 0]), ['Y is reported at -2 steps, and -5 to -3 left the pin']);
  assert.deepEqual(differences(status, [52, -3, 0], [52, -3, 0], 1), []);
  assert.deepEqual(differences(status, [53, -3, 0], [54, -3, 0], 1), ['X is reported at 51 steps, and 53 to 54 left the pin']);
  assert.deepEqual(differences('<Idle>', [], []), ['no MPos in <Idle>']);
});

test('crossed belts are asked for, and not where an axis has two motors already', () => {
  const option = (...args) => parseOptions(['--elf', 'a', '--live', ...args]);
  assert.equal(option().belts, false);
  assert.equal(option('--belts', '--second', 'Z,1').belts, true);
  for (const axis of ['X', 'Y']) assert.throws(() => option('--belts', '--second', `${axis},1`), new RegExp(`with --belts ${axis} has two motors already`));
});

test('contacts are closed by hand, and a plate is put in the way of an axis', () => {
  const script = parseScript('probe pressed\nhold released\nprobe-plate Z 12.5 below\nprobe-plate none\n');
  assert.deepEqual(script.map(({ argument }) => argument), [true, false, new ProbePlate('Z', 12.5, 'below'), null]);
  assert.throws(() => parseScript('probe-plate Z 12.5'), /nothing is none of below, above; write: probe-plate X/);
  assert.throws(() => parseScript('probe-plate Z high above'), /high is no place in mm/);
  assert.deepEqual(parseScript('wait-output pwm off')[0].argument, ['pwm', false]);
  assert.throws(() => parseScript('wait-output laser on'), /none of pwm, enable/);
  assert.throws(() => parseScript('start'), /none of pressed, released/);
  const option = (text) => parseOptions(['--elf', 'a', '--live', '--probe-plate', text]).probePlate;
  assert.deepEqual(option('X,-1.5,above'), new ProbePlate('X', -1.5, 'above'));
  assert.equal(parseOptions(['--elf', 'a', '--live']).probePlate, null);
  assert.throws(() => option('X,1'), /give an axis, a place in mm and a side/);
  assert.throws(() => option('W,1,below'), /choose X or Y or Z/);
});

test('a driver is brought into a state by a script, if the board has UART drivers', () => {
  const [{ argument, word }] = parseScript('driver 2 overheated');
  assert.deepEqual([word, argument], ['driver', ['2', 'overheated']]);
  assert.throws(() => parseScript('driver X cold'), /cold is none of on, off, late/);
  assert.throws(() => parseScript('driver W off'), /W is none of X, Y, Z, A, 2/);
  const states = [];
  const drivers = { of: (motor) => ({ set: (state) => states.push([motor, state]) }) };
  const run = (gantry) => COMMANDS[word].run(new ScriptRun({ board: { gantry } }, [], {}), argument);
  run({ drivers });
  assert.deepEqual(states, [['2', 'overheated']]);
  assert.throws(() => run({ drivers: null }), /have no UART: --board skr-pico has some that do/);
});

test('a wrong script line says which, what and how', () => {
  assert.throws(() => parseScript('jump'), /line 1: no command jump; there are send/);
  assert.throws(() => parseScript('\nbytes 1g'), /line 2: .*two hexadecimal digits; write: bytes HEX/);
  assert.throws(() => parseScript('switch W normal'), /none of X, Y, Z, A, 2; write: switch/);
  assert.throws(() => parseScript('wait-ms'), /positive number/);
});

test('lines are told apart', () => {
  assert.deepEqual(['ok', 'error:9', '<Idle|', 'ALARM:1', 'okay'].map(kindOf), ['reply', 'reply', 'status', 'message', 'message']);
});

test('options are checked, and default to the bench', () => {
  const options = parseOptions(['--elf', 'a', '--program', 'b', '--switch', 'Z=stuck-open']);
  assert.deepEqual(options.startMm, [35, 40, 15]);
  assert.deepEqual(options.switches, { Z: 'stuck-open' });
  assert.equal(options.pollHz, 10);
  assert.equal(parseOptions(['--elf', 'a', '--script', 'b']).pollHz, 0);
  assert.throws(() => parseOptions(['--program', 'b']), /cargo xtask build/);
  assert.throws(() => parseOptions(['--elf', 'a']), /either --program/);
  assert.equal(parseOptions(['--elf', 'a', '--live']).stream, 'wait');
  for (const idle of [['--stream', 'counting'], ['--poll-hz', '4'], ['--timeout-s', '1'], ['--progress']]) {
    assert.throws(() => parseOptions(['--elf', 'a', '--live', ...idle]), new RegExp(`${idle[0]} is for a program or a script`));
  }
  assert.throws(() => parseOptions(['--elf', 'a', '--script', 'b', '--start', '1,2']), /give 3 places/);
  assert.throws(() => parseOptions(['--elf', 'a', '--script', 'b', '--console', 'wifi']), /usb or uart/);
  assert.throws(() => parseOptions(['--elf', 'a', '--script', 'b', '--driver', 'a4988']), /drv8825 or tmc2209/);
});

test('what a miss of the cache of flash costs can be multiplied', () => {
  const factor = (...args) => parseOptions(['--elf', 'a', '--program', 'b', ...args]).missFactor;
  assert.deepEqual([factor(), factor('--ideal-flash'), factor('--miss-factor', '1.5'), factor('--miss-factor', '0')], [1, null, 1.5, 0]);
  assert.throws(() => factor('--miss-factor=-1'), /--miss-factor -1: give a number from 0 to 1000/);
  assert.throws(() => factor('--miss-factor', 'much'), /--miss-factor much: give a number/);
  assert.throws(() => factor('--ideal-flash', '--miss-factor', '2'), /--ideal-flash has no misses: leave --miss-factor out/);
  assert.equal(parseOptions(['--elf', 'a', '--live']).missFactor, 1);
  assert.throws(() => factor('--core-factor', '1.6'), /--core-factor 1.6: the timing of an RP2040's core is not assumed/);
  for (const option of ['--ideal-flash', '--miss-factor', '--core-factor']) assert.ok(HELP.includes(option));
});

test('settings become lines ahead of a program', () => {
  const options = parseOptions(['--elf', 'a', '--program', 'b', '--set', '910=120', '--set', '940=3']);
  assert.deepEqual(options.settings, ['$910=120\n', '$940=3\n']);
  assert.throws(() => parseOptions(['--elf', 'a', '--program', 'b', '--set', 'speed-profile=3']), /such as 940=1/);
  assert.throws(() => parseOptions(['--elf', 'a', '--script', 'b', '--set', '940=1']), /goes with --program/);
});

test('the help shows every command', () => {
  for (const { usage } of Object.values(COMMANDS)) assert.ok(HELP.includes(usage));
});
