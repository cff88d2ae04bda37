import assert from 'node:assert/strict';
import test from 'node:test';
import { homedAxes, lineEnds, printable, programLines, trimmedText } from '../src/lines.mjs';

const bytes = (text) => Buffer.from(text, 'latin1');

test('a program is split byte for byte, and its last line gets an end', () => {
  const lines = programLines(bytes('G0 X1\r\n\n\xff\x18G1')).map((line) => Buffer.from(line).toString('latin1'));
  assert.deepEqual(lines, ['G0 X1\r\n', '\n', '\xff\x18G1\n']);
  assert.deepEqual(programLines(bytes('')), []);
});

test('a line has an answer for each of its ends', () => {
  assert.equal(lineEnds(bytes('G0\r\n')), 2);
  assert.equal(trimmedText(bytes('G0\x01\r\n')), 'G0\\x01');
  assert.equal(printable(bytes('a\xc2\n')), 'a\\xc2\\x0a');
});

test('homing lines name their axes', () => {
  assert.deepEqual(homedAxes('$H'), ['X', 'Y', 'Z']);
  assert.deepEqual(homedAxes('$hy'), ['Y']);
  assert.deepEqual(homedAxes('$H (all) ; find every zero'), ['X', 'Y', 'Z']);
  assert.deepEqual(homedAxes('$$'), []);
  assert.deepEqual(homedAxes('; $H'), []);
});
