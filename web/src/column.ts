// Numbers of one kind, of which more come.

/** Numbers of a piece that is made here. As many that come at once are kept as they come. */
const PIECE = 2 ** 12;

type Numbers = Float64Array | Float32Array | Uint16Array | Uint8Array;

/** A column that grows by pieces, so that what is long is never copied: copies wait in memory until the browser clears up. A piece of
 * nothing but zeros takes no room. */
export class Column<A extends Numbers> {
  length = 0;
  private readonly pieces: (A | undefined)[] = [];
  /** Where each piece begins. */
  private readonly starts: number[] = [];
  /** Whether the last piece is made here, and so has room until it is full. */
  private isOpen = false;
  /** The piece that was looked at last: most looks are at its neighbours. */
  private near = 0;

  constructor(private readonly kind: new (length: number) => A) {}

  push(more: A): void {
    if (more.length >= PIECE) this.begin(more.some(isNotZero) ? more : undefined, more.length, false);
    else if (more.length) this.append(more);
  }

  set(index: number, value: number): void {
    if (index >= this.length) return;
    const piece = this.pieceOf(index);
    const start = this.starts[piece] ?? 0;
    (this.pieces[piece] ??= new this.kind(Math.max(PIECE, this.end(piece) - start)))[index - start] = value;
  }

  at(index: number): number {
    const piece = this.pieceOf(index);
    return this.pieces[piece]?.[index - (this.starts[piece] ?? 0)] ?? 0;
  }

  private begin(piece: A | undefined, length: number, isOpen: boolean): void {
    this.pieces.push(piece);
    this.starts.push(this.length);
    this.length += length;
    this.isOpen = isOpen;
  }

  /** Copies a few numbers to where there is room. */
  private append(few: A): void {
    const used = this.isOpen ? this.length - (this.starts.at(-1) ?? 0) : PIECE;
    const part = few.subarray(0, PIECE - used);
    const last = this.pieces.length - 1;
    if (part.some(isNotZero)) (this.pieces[last] ??= new this.kind(PIECE)).set(part, used);
    this.length += part.length;
    if (part.length === few.length) return;
    this.begin(undefined, 0, true);
    this.append(few.subarray(part.length) as A);
  }

  private end(piece: number): number {
    return this.starts[piece + 1] ?? this.length;
  }

  private pieceOf(index: number): number {
    if (index < (this.starts[this.near] ?? 0) || index >= this.end(this.near)) this.near = lastAt(this.starts.length, (piece) => this.starts[piece] ?? 0, index);
    return this.near;
  }
}

function isNotZero(number: number): boolean {
  return number !== 0;
}

/** The last of so many, in order, that is not above a value; -1 if there is none. */
export function lastAt(length: number, of: (index: number) => number, value: number): number {
  let [low, high] = [0, length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (of(middle) <= value) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}
