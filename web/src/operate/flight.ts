// Lines under way: no more bytes are sent than the controller takes.

/** Bytes that the controller takes before it has answered. */
const WINDOW_BYTES = 128;
/** The answer to a line that is not sent any more, or that a reset has made the controller forget. */
export const FORGOTTEN = "forgotten";

interface Line {
  text: string;
  /** Its answer: `ok`, `error:N` or `FORGOTTEN`. */
  answered(answer: string): void;
  /** What is printed before the answer; `undefined` lets everybody hear it. */
  printed: ((line: string) => void) | undefined;
}

export class Flight {
  private readonly waiting: Line[] = [];
  private readonly sent: Line[] = [];
  private bytes = 0;
  /** Lines of a person in a change of the tool, which are answered before those that wait for it. */
  private readonly byHand: Line[] = [];
  /** Nothing that waits is sent: it would be taken for a line by hand. */
  private isShut = false;

  constructor(private readonly send: (line: string) => void) {}

  /** Sends a line as soon as there is room. */
  push(text: string, answered: (answer: string) => void, printed?: (line: string) => void): void {
    this.waiting.push({ text, answered, printed });
    this.fill();
  }

  /** Sends a line at once, before all that wait. */
  pushByHand(text: string, answered: (answer: string) => void, printed?: (line: string) => void): void {
    this.byHand.push({ text, answered, printed });
    this.send(text);
  }

  /** How many lines by hand are under way. */
  get handLength(): number {
    return this.byHand.length;
  }

  /** Sends nothing that waits, and only lines by hand, before `open`. */
  shut(): void {
    this.isShut = true;
  }

  open(): void {
    this.isShut = false;
    this.fill();
  }

  /** How many lines wait or are under way. */
  get length(): number {
    return this.waiting.length + this.sent.length + this.byHand.length;
  }

  /** A line was printed before an answer; whether it was asked for by a line that keeps what it hears. */
  hears(line: string): boolean {
    const printed = (this.byHand[0] ?? this.sent[0])?.printed;
    printed?.(line);
    return printed !== undefined;
  }

  /** An answer has come. */
  answer(answer: string): void {
    const hand = this.byHand.shift();
    if (hand) return hand.answered(answer);
    const first = this.sent.shift();
    if (!first) return;
    this.bytes -= first.text.length + 1;
    first.answered(answer);
    this.fill();
  }

  /** Nothing more is sent; what is under way is answered still. */
  forgetWaiting(): void {
    for (const line of this.waiting.splice(0)) line.answered(FORGOTTEN);
  }

  /** The controller begins anew. What was under way or waited has to be answered with `FORGOTTEN`. */
  restart(): Line[] {
    this.bytes = 0;
    this.isShut = false;
    return [...this.byHand.splice(0), ...this.sent.splice(0), ...this.waiting.splice(0)];
  }

  private fill(): void {
    for (;;) {
      const next = this.waiting[0];
      if (!next || this.isShut) return;
      const length = next.text.length + 1;
      if (this.sent.length && this.bytes + length > WINDOW_BYTES) return;
      this.waiting.shift();
      this.sent.push(next);
      this.bytes += length;
      this.send(next.text);
    }
  }
}
