const MOST_WORDS = 8;

/** A FIFO of 32-bit words. It is four deep, or eight when the machine's other FIFO is joined to it. */
export class Fifo {
  constructor() {
    this.words = new Int32Array(MOST_WORDS);
    this.resize(MOST_WORDS / 2);
  }

  /** Sets the depth (0, 4 or 8 words) and empties it, as the chip does. */
  resize(depth) {
    this.depth = depth;
    this.head = 0;
    this.level = 0;
  }

  get full() {
    return this.level >= this.depth;
  }

  get empty() {
    return this.level === 0;
  }

  push(word) {
    this.words[(this.head + this.level) & (MOST_WORDS - 1)] = word;
    this.level += 1;
  }

  pop() {
    const word = this.words[this.head];
    this.head = (this.head + 1) & (MOST_WORDS - 1);
    this.level -= 1;
    return word;
  }
}
