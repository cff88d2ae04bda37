// Numbers of one kind, of which more come.

/** Numbers of a piece: a power of two. */
const PIECE = 2 ** 12;

type Numbers = Float64Array | Float32Array | Uint8Array;

/** A column that grows by pieces, so that nothing is ever copied and no room is left over. */
export class Column<A extends Numbers> {
  length = 0;
  private readonly pieces: A[] = [];

  constructor(private readonly kind: new (length: number) => A) {}

  push(more: A): void {
    for (let from = 0; from < more.length; ) {
      const at = this.length % PIECE;
      if (at === 0) this.pieces.push(new this.kind(PIECE));
      const part = more.subarray(from, from + PIECE - at);
      this.pieces.at(-1)?.set(part, at);
      this.length += part.length;
      from += part.length;
    }
  }

  set(index: number, value: number): void {
    const piece = this.pieces[(index / PIECE) | 0];
    if (piece) piece[index % PIECE] = value;
  }

  at(index: number): number {
    return this.pieces[(index / PIECE) | 0]?.[index % PIECE] ?? 0;
  }
}
