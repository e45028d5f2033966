// Where items are: a grid over the paper whose cells are linked lists, so that an item moves in constant time.

import { grown } from "./items";

const NONE = -1;
export const ACROSS = 128; // cells along the longer side of the paper

export class Grid {
  readonly columns: number;
  readonly rows: number;
  private readonly head: Int32Array;
  private next = new Int32Array(1024);
  private back = new Int32Array(1024); // the one before, or ~cell for the first of a cell

  // Cells of `side` um over a paper of width and height um; what lies outside goes to the nearest.
  constructor(width: number, height: number, readonly side: number) {
    this.columns = Math.max(1, Math.ceil(width / side));
    this.rows = Math.max(1, Math.ceil(height / side));
    this.head = new Int32Array(this.columns * this.rows).fill(NONE);
  }

  column(x: number): number {
    return Math.min(this.columns - 1, Math.max(0, Math.floor(x / this.side)));
  }

  row(y: number): number {
    return Math.min(this.rows - 1, Math.max(0, Math.floor(y / this.side)));
  }

  cell(x: number, y: number): number {
    return this.row(y) * this.columns + this.column(x);
  }

  add(id: number, cell: number): void {
    if (id >= this.next.length) {
      const size = 2 ** Math.ceil(Math.log2(id + 1));
      this.next = grown(this.next, new Int32Array(size));
      this.back = grown(this.back, new Int32Array(size));
    }
    const first = this.head[cell]!;
    this.next[id] = first;
    this.back[id] = ~cell;
    if (first !== NONE) this.back[first] = id;
    this.head[cell] = id;
  }

  remove(id: number): void {
    const next = this.next[id]!;
    const back = this.back[id]!;
    if (back < 0) this.head[~back] = next;
    else this.next[back] = next;
    if (next !== NONE) this.back[next] = back;
  }

  clear(): void {
    this.head.fill(NONE);
  }

  // The ids of items in the cells that a rectangle touches, um, written to `into`; how many.
  within(left: number, top: number, right: number, bottom: number, into: { ids: Int32Array }): number {
    let n = 0;
    for (let row = this.row(top); row <= this.row(bottom); row++) {
      for (let column = this.column(left); column <= this.column(right); column++) {
        for (let id = this.head[row * this.columns + column]!; id !== NONE; id = this.next[id]!) {
          if (n === into.ids.length) into.ids = grown(into.ids, new Int32Array(2 * n));
          into.ids[n++] = id;
        }
      }
    }
    return n;
  }
}
