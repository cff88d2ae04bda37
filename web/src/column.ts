// Numbers of one kind, of which more come.

/** As much more than is needed is taken when there is no more room. */
const ROOM = 1.5;

/** A column that grows. */
export class Column<A extends Float64Array | Float32Array | Uint8Array> {
  length = 0;
  constructor(private array: A) {}

  push(more: A): void {
    if (this.length + more.length > this.array.length) {
      const wider = new (this.array.constructor as new (length: number) => A)(Math.ceil(ROOM * (this.length + more.length)));
      wider.set(this.array);
      this.array = wider;
    }
    this.array.set(more, this.length);
    this.length += more.length;
  }

  set(index: number, value: number): void {
    this.array[index] = value;
  }

  at(index: number): number {
    return this.array[index] ?? 0;
  }
}
