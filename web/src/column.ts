// Numbers of one kind, of which more come.

/** Numbers of a piece: a power of two. */
const PIECE = 2 ** 12;

type Numbers = Float64Array | Float32Array | Uint16Array | Uint8Array;

/** A column that grows by pieces, so that nothing is ever copied and no room is left over. A piece of nothing but zeros takes no room. */
export class Column<A extends Numbers> {
  length = 0;
  private readonly pieces: (A | undefined)[] = [];

  constructor(private readonly kind: new (length: number) => A) {}

  push(more: A): void {
    for (let from = 0; from < more.length; ) {
      const at = this.length % PIECE;
      const part = more.subarray(from, from + PIECE - at);
      if (at === 0) this.pieces.push(undefined);
      const last = this.pieces.length - 1;
      if (!this.pieces[last] && part.some((number: number) => number !== 0)) this.pieces[last] = new this.kind(PIECE);
      this.pieces[last]?.set(part, at);
      this.length += part.length;
      from += part.length;
    }
  }

  set(index: number, value: number): void {
    const piece = (index / PIECE) | 0;
    if (index < this.length) (this.pieces[piece] ??= new this.kind(PIECE))[index % PIECE] = value;
  }

  at(index: number): number {
    return this.pieces[(index / PIECE) | 0]?.[index % PIECE] ?? 0;
  }
}
