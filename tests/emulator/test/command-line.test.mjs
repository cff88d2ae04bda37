import assert from 'node:assert/strict';
import test from 'node:test';
import { kindOf } from '../src/console.mjs';
import { HELP, parseOptions } from '../src/options.mjs';
import { COMMANDS, parseScript } from '../src/script.mjs';

test('a script is commands with checked arguments', () => {
  const script = parseScript('# home\n\nsend G1 X1\nbytes 18 3f\nswitch X stuck-closed\nwait-ms 0.5\nreading off\n');
  assert.deepEqual(script.map(({ number, word }) => [number, word]), [[3, 'send'], [4, 'bytes'], [5, 'switch'], [6, 'wait-ms'], [7, 'reading']]);
  assert.equal(Buffer.from(script[0].argument).toString(), 'G1 X1\n');
  assert.deepEqual([...script[1].argument], [0x18, 0x3f]);
  assert.deepEqual(script[2].argument, ['X', 'stuck-closed']);
  assert.deepEqual([script[3].argument, script[4].argument], [0.5, false]);
});

test('a wrong script line says which, what and how', () => {
  assert.throws(() => parseScript('jump'), /line 1: no command jump; there are send/);
  assert.throws(() => parseScript('\nbytes 1g'), /line 2: .*two hexadecimal digits; write: bytes HEX/);
  assert.throws(() => parseScript('switch W normal'), /none of X, Y, Z; write: switch/);
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
  assert.throws(() => parseOptions(['--elf', 'a', '--script', 'b', '--start', '1,2']), /three places/);
  assert.throws(() => parseOptions(['--elf', 'a', '--script', 'b', '--console', 'wifi']), /usb or uart/);
});

test('the help shows every command', () => {
  for (const { usage } of Object.values(COMMANDS)) assert.ok(HELP.includes(usage));
});
