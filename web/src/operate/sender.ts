// Who sends a program: this page (page-sender.ts), or its server, which holds it whatever becomes of the page (server-sender.ts).

import type { NamedProgram } from "./operate";

/** A program, and the lines that make a machine at power-up such as this one was when it was begun. */
export interface Begun extends NamedProgram {
  before: string[];
  /** The plain lines that it makes, if it computes or calls. */
  made?: [number: number, text: string][] | undefined;
}

/** How far a program has come. */
export interface Progress {
  lines: number;
  answered: number;
  /** The line of the file that was answered last, from 1; 0 for none. */
  last: number;
  /** The line of the file that is answered next. */
  next: number | undefined;
  /** The last line of the file that is sent. */
  end: number;
}

export interface Sender {
  /** While a program is sent. */
  readonly progress: Progress | undefined;
  start(program: Begun): void;
}

/** What becomes known of a program that is sent. */
export interface SenderWatcher {
  began(progress: Progress): void;
  /** What was begun, which may be known later than that it was. */
  knows(begun: Begun): void;
  /** It is sent no more, or was not begun, and why. */
  ended(words: string): void;
}
