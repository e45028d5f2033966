// What there is to paint, as the painter keeps it: items in a grid for each layer, kinds as outlines, and which places have changed.

import { Grid, ACROSS } from "./grid";
import { Items, grown } from "./items";
import { Outline } from "./outline";
import type { Frame, ItemChunk, Kind, Layer, LineKind, LineSet } from "./protocol";

export class Scene {
  readonly items = new Items();
  readonly kinds = new Map<number, Outline>();
  layers: Layer[] = [];
  width = 1; // um
  height = 1;
  lines = new Map<LineKind, LineGrid>();
  private grids = new Map<number, Grid>();
  private reaches = new Map<number, number>(); // um, of each layer's largest
  private changed = new Grid(1, 1, 1); // its cells' numbers alone are used
  private stale = new Uint8Array(1);
  private cells = new Int32Array(0); // of each item, -1 without one
  private homes = new Uint32Array(0); // the layer in whose grid it is

  // A paper of mm; items stay until a reset, so that the screen is not empty meanwhile.
  begin(width: number, height: number): void {
    this.lines.clear();
    if (this.width === width * 1000 && this.height === height * 1000) return this.touchAll();
    this.width = width * 1000;
    this.height = height * 1000;
    this.changed = this.grid();
    this.stale = new Uint8Array(this.changed.columns * this.changed.rows);
    this.reset();
  }

  reset(): void {
    this.items.clear();
    this.cells.fill(-1);
    this.homes.fill(0);
    this.kinds.clear();
    this.grids.clear();
    this.reaches.clear();
    this.stale.fill(1);
  }

  know(kinds: Kind[]): void {
    if (kinds.some((kind) => this.kinds.has(kind.id))) this.stale.fill(1); // some take the place of others
    for (const kind of kinds) this.kinds.set(kind.id, new Outline(kind.d, kind.closed, kind.reach));
  }

  // Takes the layers; whether any looks different.
  list(layers: Layer[]): boolean {
    const look = (all: Layer[]): string => JSON.stringify(all.map((one) => [one.id, one.rgb, one.pen, one.hidden]));
    const different = look(layers) !== look(this.layers);
    this.layers = layers;
    if (different) this.stale.fill(1);
    return different;
  }

  take(frame: Frame): void {
    if (frame.type === "lines") {
      this.lines.set(frame.lines.what, new LineGrid(frame.lines, this.grid()));
      this.stale.fill(1);
    }
    if (frame.type === "items") for (const chunk of frame.chunks) this.change(chunk);
  }

  // Takes a chunk in; items go to other cells of their grids where they must, and both are stale then.
  private change(chunk: ItemChunk): void {
    const { items, changed, stale } = this;
    items.take(chunk);
    if (items.layer.length > this.cells.length) {
      this.cells = grown(this.cells, new Int32Array(items.layer.length).fill(-1, this.cells.length));
      this.homes = grown(this.homes, new Uint32Array(items.layer.length));
    }
    const { cells, homes } = this;
    const grid = this.gridOf(chunk.layer);
    for (let k = 0; k < chunk.n; k++) {
      const id = Items.id(chunk, k);
      const was = cells[id]!;
      const now = chunk.gone ? -1 : changed.cell(items.x[id]!, items.y[id]!);
      if (was >= 0) stale[was] = 1;
      if (now >= 0) stale[now] = 1;
      if (was === now && homes[id] === chunk.layer) continue;
      if (was >= 0) this.gridOf(homes[id]!).remove(id);
      if (now >= 0) grid.add(id, now);
      cells[id] = now;
      homes[id] = chunk.layer;
    }
    if (!chunk.gone && (chunk.scale || chunk.kind || chunk.fill)) this.reach(chunk);
  }

  // Finds how far the largest items of a chunk's layer reach.
  private reach(chunk: ItemChunk): void {
    let most = this.reaches.get(chunk.layer) ?? 0;
    for (let k = 0; k < chunk.n; k++) most = Math.max(most, this.reachOf(Items.id(chunk, k)));
    this.reaches.set(chunk.layer, most);
  }

  forget(what: LineKind): void {
    if (this.lines.delete(what)) this.stale.fill(1);
  }

  // How far an item may lie from its centre, um.
  reachOf(id: number): number {
    return (this.kinds.get(this.items.kind[id]!)?.reach ?? 1) * this.items.scale[id]!;
  }

  // The ids of a layer's items that may reach into a rectangle, um.
  within(layer: number, left: number, top: number, right: number, bottom: number, into: { ids: Int32Array }): number {
    const grid = this.grids.get(layer);
    const reach = this.margin(layer);
    return grid ? grid.within(left - reach, top - reach, right + reach, bottom + reach, into) : 0;
  }

  // Whether anything has changed since the last settle() that may reach into a rectangle, um.
  changedWithin(left: number, top: number, right: number, bottom: number): boolean {
    const reach = Math.max(0, ...this.layers.map((layer) => this.margin(layer.id)));
    const { changed, stale } = this;
    for (let row = changed.row(top - reach); row <= changed.row(bottom + reach); row++) {
      const from = row * changed.columns;
      for (let k = from + changed.column(left - reach); k <= from + changed.column(right + reach); k++) if (stale[k]) return true;
    }
    return false;
  }

  settle(): void {
    this.stale.fill(0);
  }

  // Says that a rectangle has changed, um.
  touchWithin(left: number, top: number, right: number, bottom: number): void {
    const { changed, stale } = this;
    for (let row = changed.row(top); row <= changed.row(bottom); row++) {
      stale.fill(1, row * changed.columns + changed.column(left), row * changed.columns + changed.column(right) + 1);
    }
  }

  touchAll(): void {
    this.stale.fill(1);
  }

  private margin(layer: number): number {
    const pen = this.layers.find((one) => one.id === layer)?.pen ?? 0;
    return (this.reaches.get(layer) ?? 0) + 500 * pen;
  }

  private gridOf(layer: number): Grid {
    let grid = this.grids.get(layer);
    if (!grid) this.grids.set(layer, (grid = this.grid()));
    return grid;
  }

  private grid(): Grid {
    return new Grid(this.width, this.height, Math.max(this.width, this.height) / ACROSS);
  }
}

// Lines in a grid by the box of each piece.
export class LineGrid {
  private readonly start: Uint32Array;
  private readonly pieces: Uint32Array; // the index of each piece's first point
  private readonly ends: Uint32Array; // and of its last

  constructor(readonly set: LineSet, private readonly grid: Grid) {
    const [from, to] = pieces(set);
    const count = new Uint32Array(grid.columns * grid.rows + 1);
    this.cells(from, to, (cell) => count[cell + 1]!++);
    for (let k = 1; k < count.length; k++) count[k]! += count[k - 1]!;
    this.start = count.slice();
    this.pieces = new Uint32Array(this.start[this.start.length - 1]!);
    this.ends = new Uint32Array(this.pieces.length);
    const at = count;
    this.cells(from, to, (cell, k) => {
      this.pieces[at[cell]!] = from[k]!;
      this.ends[at[cell]!++] = to[k]!;
    });
  }

  // Calls `draw` for the pieces that may touch a rectangle, um, some more than once; ends in mm.
  within(left: number, top: number, right: number, bottom: number, draw: (ax: number, ay: number, bx: number, by: number) => void): void {
    const { grid, set } = this;
    for (let row = grid.row(top); row <= grid.row(bottom); row++) {
      for (let column = grid.column(left); column <= grid.column(right); column++) {
        const cell = row * grid.columns + column;
        for (let k = this.start[cell]!; k < this.start[cell + 1]!; k++) {
          const [i, j] = [2 * this.pieces[k]!, 2 * this.ends[k]!];
          draw(set.xy[i]!, set.xy[i + 1]!, set.xy[j]!, set.xy[j + 1]!);
        }
      }
    }
  }

  private cells(from: Uint32Array, to: Uint32Array, put: (cell: number, k: number) => void): void {
    const { grid, set } = this;
    for (let k = 0; k < from.length; k++) {
      const [ax, ay] = [1000 * set.xy[2 * from[k]!]!, 1000 * set.xy[2 * from[k]! + 1]!];
      const [bx, by] = [1000 * set.xy[2 * to[k]!]!, 1000 * set.xy[2 * to[k]! + 1]!];
      for (let row = grid.row(Math.min(ay, by)); row <= grid.row(Math.max(ay, by)); row++) {
        for (let column = grid.column(Math.min(ax, bx)); column <= grid.column(Math.max(ax, bx)); column++) put(row * grid.columns + column, k);
      }
    }
  }
}

// The first and last point of every straight piece.
function pieces(set: LineSet): [Uint32Array, Uint32Array] {
  const from: number[] = [];
  const to: number[] = [];
  for (let path = 0; path + 1 < set.start.length; path++) {
    const [first, end] = [set.start[path]!, set.start[path + 1]!];
    for (let k = first; k + 1 < end; k++) {
      from.push(k);
      to.push(k + 1);
    }
    if (set.closed && end - first > 2) {
      from.push(end - 1);
      to.push(first);
    }
  }
  return [Uint32Array.from(from), Uint32Array.from(to)];
}
