// The items of the drawing in columns of typed arrays; an item's id is its row.

import type { ItemChunk } from "./protocol";

export class Items {
  count = 0;
  end = 0; // no id is this or more
  layer = new Uint32Array(1024); // 0: no such item
  x = new Int32Array(1024);
  y = new Int32Array(1024);
  scale = new Uint32Array(1024);
  turn = new Uint16Array(1024);
  kind = new Uint32Array(1024);
  fill = new Uint32Array(1024);
  flags = new Uint8Array(1024);

  clear(): void {
    this.layer.fill(0);
    this.count = this.end = 0;
  }

  // Takes a chunk in; its items' ids are then as `id` says.
  take(chunk: ItemChunk): void {
    const { n, ids, first, x, y, dx, dy, scale, turn, kind, fill, flags } = chunk;
    if (!n) return;
    this.reserve(Items.id(chunk, n - 1) + 1);
    for (let k = 0; k < n; k++) {
      const id = ids ? ids[k]! : first + k;
      if (this.layer[id]) this.count--;
      if (!chunk.gone) this.count++;
      this.layer[id] = chunk.gone ? 0 : chunk.layer;
    }
    if (!ids) {
      if (x) this.x.set(x, first);
      if (y) this.y.set(y, first);
      if (scale) this.scale.set(scale, first);
      if (turn) this.turn.set(turn, first);
      if (kind) this.kind.set(kind, first);
      if (fill) this.fill.set(fill, first);
      if (flags) this.flags.set(flags, first);
    }
    for (let k = 0; k < n && (ids || dx); k++) {
      const id = ids ? ids[k]! : first + k;
      if (dx) {
        this.x[id]! += dx[k]!;
        this.y[id]! += dy![k]!;
      }
      if (!ids) continue;
      if (x) this.x[id] = x[k]!;
      if (y) this.y[id] = y[k]!;
      if (scale) this.scale[id] = scale[k]!;
      if (turn) this.turn[id] = turn[k]!;
      if (kind) this.kind[id] = kind[k]!;
      if (fill) this.fill[id] = fill[k]!;
      if (flags) this.flags[id] = flags[k]!;
    }
  }

  // The id of a chunk's k-th item.
  static id(chunk: ItemChunk, k: number): number {
    return chunk.ids ? chunk.ids[k]! : chunk.first + k;
  }

  private reserve(end: number): void {
    this.end = Math.max(this.end, end);
    if (end <= this.layer.length) return;
    const size = 2 ** Math.ceil(Math.log2(end));
    this.layer = grown(this.layer, new Uint32Array(size));
    this.x = grown(this.x, new Int32Array(size));
    this.y = grown(this.y, new Int32Array(size));
    this.scale = grown(this.scale, new Uint32Array(size));
    this.turn = grown(this.turn, new Uint16Array(size));
    this.kind = grown(this.kind, new Uint32Array(size));
    this.fill = grown(this.fill, new Uint32Array(size));
    this.flags = grown(this.flags, new Uint8Array(size));
  }
}

export function grown<T extends Uint32Array | Int32Array | Uint16Array | Uint8Array>(old: T, larger: T): T {
  larger.set(old);
  return larger;
}
