import { closeSync, openSync, writeSync } from 'node:fs';
import { AXES } from './pins.mjs';

const WORDS_PER_EDGE = 2;
const BUFFERED_EDGES = 1 << 16;
const TWO_TO_32 = 2 ** 32;

/**
 * Every rising edge of STEP in eight bytes, a little-endian number: cycle * 8 + axis * 2 + (1 if DIR is up). Written as
 * they come, so that thirty million of them need no memory.
 */
export class EdgeFile {
  /** @param {string} path */
  constructor(path) {
    this.file = openSync(path, 'w');
    this.words = new Uint32Array(BUFFERED_EDGES * WORDS_PER_EDGE);
    this.used = 0;
  }

  step(cycle, axis, direction) {
    const value = cycle * 8 + AXES.indexOf(axis) * 2 + (direction > 0 ? 1 : 0);
    this.words[this.used] = value % TWO_TO_32;
    this.words[this.used + 1] = Math.floor(value / TWO_TO_32);
    this.used += WORDS_PER_EDGE;
    if (this.used === this.words.length) this.#flush();
  }

  close() {
    this.#flush();
    closeSync(this.file);
  }

  /** The words are in the host's byte order, which is little-endian wherever Node runs. */
  #flush() {
    writeSync(this.file, new Uint8Array(this.words.buffer, 0, this.used * Uint32Array.BYTES_PER_ELEMENT));
    this.used = 0;
  }
}
