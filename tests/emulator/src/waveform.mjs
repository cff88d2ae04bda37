const FIRST_CODE = 33;

/** The pins as a Value Change Dump, for a wave viewer. */
export class Waveform {
  /**
   * @param {Map<number, string>} outputs numbers and names of the pins whose level is the chip's
   * @param {Map<number, string>} inputs of those whose level comes from outside
   */
  constructor(outputs, inputs) {
    this.outputs = outputs;
    const pins = [...outputs, ...inputs];
    this.codes = new Map(pins.map(([pin], index) => [pin, String.fromCharCode(FIRST_CODE + index)]));
    const variables = pins.map(([pin, name]) => `$var wire 1 ${this.codes.get(pin)} ${name} $end`);
    this.rows = ['$timescale 1 ns $end', '$scope module gantry $end', ...variables, '$upscope $end', '$enddefinitions $end'];
    this.atNanos = -1;
  }

  attach(chip, nanos) {
    for (const pin of this.outputs.keys()) {
      const code = this.codes.get(pin);
      const change = (state) => this.#change(nanos(), code, state === 0 ? '0' : state === 1 ? '1' : 'z');
      chip.gpio[pin].addListener(change);
      change(chip.gpio[pin].value);
    }
  }

  /** The level of an input changes. Inputs that were not named are ignored. */
  input(nanos, pin, high) {
    const code = this.codes.get(pin);
    if (code !== undefined) this.#change(nanos, code, high ? '1' : '0');
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
