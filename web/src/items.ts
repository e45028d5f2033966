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

  // Takes a chunk in. `before` is called for each item that is there while it is still as it was, `after` for each once it is as it will be.
  take(chunk: ItemChunk, before?: (id: number) => void, after?: (id: number) => void): void {
    const { ids, x, y, scale, turn, kind, fill, flags } = chunk;
    if (ids.length) this.reserve(ids[ids.length - 1]! + 1);
    for (let k = 0; k < ids.length; k++) {
      const id = ids[k]!;
      const was = this.layer[id]!;
      if (was && before) before(id);
      if (chunk.gone) {
        if (was) this.count--;
        this.layer[id] = 0;
        continue;
      }
      if (!was) this.count++;
      this.layer[id] = chunk.layer;
      if (x) this.x[id] = x[k]!;
      if (y) this.y[id] = y[k]!;
      if (scale) this.scale[id] = scale[k]!;
      if (turn) this.turn[id] = turn[k]!;
      if (kind) this.kind[id] = kind[k]!;
      if (fill) this.fill[id] = fill[k]!;
      if (flags) this.flags[id] = flags[k]!;
      if (after) after(id);
    }
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
