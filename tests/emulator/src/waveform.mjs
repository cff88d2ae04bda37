const FIRST_CODE = 33;

/** The pins as a Value Change Dump, for a wave viewer. */
export class Waveform {
  /** @param {Map<number, string>} pins numbers and names */
  constructor(pins) {
    this.pins = pins;
    this.codes = new Map([...pins.keys()].map((pin, index) => [pin, String.fromCharCode(FIRST_CODE + index)]));
    const variables = [...pins].map(([pin, name]) => `$var wire 1 ${this.codes.get(pin)} ${name} $end`);
    this.rows = ['$timescale 1 ns $end', '$scope module gantry $end', ...variables, '$upscope $end', '$enddefinitions $end'];
    this.atNanos = -1;
  }

  attach(chip, nanos) {
    for (const [pin, code] of this.codes) {
      const change = (state) => this.#change(nanos(), code, state === 0 ? '0' : state === 1 ? '1' : 'z');
      chip.gpio[pin].addListener(change);
      change(chip.gpio[pin].value);
    }
  }

  #change(nanos, code, level) {
    if (nanos !== this.atNanos) this.rows.push(`#${nanos}`);
    this.atNanos = nanos;
    this.rows.push(level + code);
  }

  toString() {
    return this.rows.join('\n') + '\n';
  }
}
