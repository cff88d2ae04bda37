import { trimmedText } from './lines.mjs';

/** A dialogue, a line each: machine time in seconds, `>` sent or `<` received, the text. */
export class Transcript {
  /** @param {(line: string) => void} [onLine] called as the lines come */
  constructor(onLine = () => {}) {
    this.lines = [];
    this.onLine = onLine;
  }

  sent(nanos, bytes) {
    this.#add(nanos, '>', trimmedText(bytes));
  }

  received(nanos, text) {
    this.#add(nanos, '<', text);
  }

  note(nanos, text) {
    this.#add(nanos, '#', text);
  }

  #add(nanos, mark, text) {
    const line = `${(nanos / 1e9).toFixed(6).padStart(12)} ${mark} ${text}`;
    this.lines.push(line);
    this.onLine(line);
  }

  toString() {
    return this.lines.join('\n') + '\n';
  }
}
