// Numbers of one kind, of which more come.

/** Numbers of a piece: a power of two. */
const PIECE = 2 ** 12;

type Numbers = Float64Array | Float32Array | Uint32Array;

/** A column that grows by pieces, so that nothing is ever copied and no room is left over. A piece of one number throughout is that number. */
export class Column<A extends Numbers> {
  length = 0;
  private readonly pieces: (A | number)[] = [];

  constructor(private readonly kind: new (length: number) => A) {}

  /** Adds one of these. A number by itself, for each of very many, would be one to clear away. */
  push(numbers: A, index: number): void {
    const value = numbers[index] ?? 0;
    const at = this.length++ % PIECE;
    if (at === 0) this.pieces.push(value);
    const last = this.pieces.length - 1;
    const piece = this.pieces[last];
    if (piece === value) return;
    if (typeof piece === "number") (this.pieces[last] = new this.kind(PIECE).fill(piece) as A)[at] = value;
    else if (piece) piece[at] = value;
  }

  at(index: number): number {
    const piece = this.pieces[(index / PIECE) | 0];
    return typeof piece === "number" ? piece : (piece?.[index % PIECE] ?? 0);
  }
}
