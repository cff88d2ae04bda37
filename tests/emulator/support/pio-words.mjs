import { readFileSync } from 'node:fs';
import { PIO0, PioBench, REG } from './pio-bench.mjs';

/**
 * Runs experiments with PIO0 and prints their results, so that this emulator can be compared with another:
 * node tests/emulator/support/pio-words.mjs < experiments.json
 *
 * Input, for each experiment: `setup` contains the writes before cycle 0: [address, value]. Then every cycle begins
 * with the writes that are due, [cycle, address, value] in `writes`, and with a word for each state machine whose FIFO
 * has room, from its own list in `words`. A write on cycle N takes effect on N + 1. From cycle `takes_from` on, a word of
 * each RX FIFO is taken at the end of every cycle. After `cycles` cycles come the writes of `finish`.
 *
 * Output, for each state machine of each experiment: the cycles on which its pin (`pins`) rose and fell; those on which
 * the next pin changed, [cycle, whether it is high] in `turns`; the cycle on which its flag was set (or null); the
 * words taken from its RX FIFO, [cycle, word] in `taken`; and the word that is in it in the end, its `count`.
 */
class Experiment {
  static #fifoWords = 8;

  constructor(given) {
    this.given = given;
    this.bench = new PioBench();
    this.edges = given.pins.map((pin) => this.bench.watch(pin));
    this.turns = given.pins.map((pin) => this.bench.watch(pin + 1));
    this.halts = given.pins.map(() => null);
    this.fed = given.pins.map(() => 0);
    this.taken = given.pins.map(() => []);
    this.done = 0;
  }

  run() {
    const { setup, cycles, takes_from, finish, pins } = this.given;
    this.#write(setup);
    for (let cycle = 0; cycle < cycles; cycle++) {
      this.#writeDue(cycle);
      this.#feed();
      this.bench.runTo(cycle + 1);
      this.#noteHalts(cycle + 1);
      if (cycle >= takes_from) this.#take(cycle + 1);
    }
    this.#write(finish);
    return pins.map((_, index) => this.#seen(index));
  }

  #write(list) {
    for (const [address, value] of list) this.bench.writeAt(address, value);
  }

  #writeDue(cycle) {
    const { writes } = this.given;
    for (; writes[this.done]?.[0] === cycle; this.done++) this.#write([writes[this.done].slice(1)]);
  }

  #feed() {
    const levels = this.bench.read(REG.flevel);
    this.given.words.forEach((list, index) => {
      const hasRoom = ((levels >>> (8 * index)) & 0xf) < Experiment.#fifoWords;
      if (hasRoom && this.fed[index] < list.length) this.bench.write(REG.txf + 4 * index, list[this.fed[index]++]);
    });
  }

  #take(cycle) {
    const levels = this.bench.read(REG.flevel);
    this.taken.forEach((words, index) => {
      if ((levels >>> (8 * index + 4)) & 0xf) words.push([cycle, this.bench.read(REG.rxf + 4 * index)]);
    });
  }

  #noteHalts(cycle) {
    const flags = this.bench.read(REG.irq);
    this.halts.forEach((halt, index) => {
      if (halt === null && (flags >>> index) & 1) this.halts[index] = cycle;
    });
  }

  #seen(index) {
    const to = (level) => this.edges[index].filter(([, now]) => now === level).map(([cycle]) => cycle);
    return { rises: to(1), falls: to(0), turns: this.turns[index].map(([cycle, level]) => [cycle, level === 1]), halt: this.halts[index], taken: this.taken[index], count: this.bench.readAt(PIO0 + REG.rxf + 4 * index) };
  }
}

const experiments = JSON.parse(readFileSync(0, 'utf8'));
console.log(JSON.stringify(experiments.map((given) => new Experiment(given).run())));
