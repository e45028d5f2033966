// Paints the drawing on the page's canvas, in a thread of its own: tiles are kept, panned as they are, and made anew where something changed.

import type { Look, Painted, ToPainter, View } from "./painting";
import { frame } from "./protocol";
import { Scene } from "./scene";
import { SIDE, TilePainter } from "./tile";
import { Underlay } from "./underlay";

const BUDGET = 14; // ms of a frame for new tiles
const STEADY = 24; // where the view stands still
const PATIENCE = 60; // ms in which no half of a change is shown
const STILL = 70; // ms without zooming, after which tiles of the new scale are made
const MOST = 160; // tiles kept: 40 MB, and as much for what lies beneath them
const SPARE = 40; // canvases of tiles kept for others

interface Tile {
  column: number;
  row: number;
  canvas: OffscreenCanvas | null;
  fresh: boolean;
  grounds: Map<number | null, Uint32Array | null>; // what lies beneath and between its marks, as the underlay was at `version`
  version: number;
}

interface Tiles {
  scale: number;
  all: Map<number, Tile>;
}

class Painter {
  private readonly scene = new Scene();
  private readonly underlay = new Underlay();
  private readonly tilePainter = new TilePainter();
  private readonly spare: OffscreenCanvas[] = [];
  private canvas: OffscreenCanvas | null = null;
  private look: Look | null = null;
  private view: View = { scale: 1, x: 0, y: 0 };
  private tiles: Tiles = { scale: 0, all: new Map() };
  private before: Tiles | null = null; // those of the last scale, shown until the new are there
  private zoomed = 0; // when the scale last changed
  private asked = false;
  private moved = true; // the view, since it was drawn last
  private drawn = 0; // when the canvas was
  private frames = 0;
  private coming = 0; // the revision that the scene is on its way to, and how many frames it wants yet
  private missing = 0;
  private revision = 0; // of the scene
  private shown = 0; // wholly on the screen

  take(message: ToPainter): void {
    switch (message.do) {
      case "canvas":
        this.canvas = message.canvas;
        break;
      case "begin":
        this.scene.begin(...message.size);
        [this.underlay.size, this.underlay.art] = [message.size, message.art];
        break;
      case "state":
        if (message.reset) {
          this.scene.reset();
          this.underlay.forgetMaps();
        }
        this.scene.know(message.kinds);
        this.scene.list(message.layers);
        this.coming = message.revision;
        this.missing = message.frames;
        this.arrive();
        break;
      case "frame":
        this.receive(message.buffer);
        break;
      case "view":
        this.see(message.view, message.width, message.height);
        break;
      case "look":
        this.look = message.look;
        this.moved = true;
        this.underlay.version++;
        this.scene.touchAll();
        break;
      case "image":
        this.underlay.show(message.name, message.bitmap);
        this.scene.touchAll();
        break;
      case "forget":
        this.scene.forget(message.what);
    }
    this.ask();
  }

  private receive(buffer: ArrayBuffer): void {
    const received = frame(buffer);
    if (received.type === "raster") for (const patch of received.patches) this.scene.touchWithin(...this.underlay.take(patch));
    else this.scene.take(received);
    if (received.type === "lines") return;
    this.missing--;
    this.arrive();
  }

  private arrive(): void {
    if (this.missing <= 0) this.revision = this.coming;
  }

  private see(view: View, width: number, height: number): void {
    if (this.canvas && (this.canvas.width !== width || this.canvas.height !== height)) [this.canvas.width, this.canvas.height] = [width, height];
    if (view.scale !== this.view.scale) this.zoomed = performance.now();
    this.view = view;
    this.moved = true;
  }

  private ask(): void {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => this.frame());
  }

  private frame(): void {
    this.asked = false;
    const context = this.canvas?.getContext("2d", { alpha: false });
    if (!context || !this.look) return;
    const began = performance.now();
    const settled = began - this.zoomed > STILL || !this.tiles.all.size;
    if (settled && this.tiles.scale !== this.view.scale) this.change();
    this.mark();
    const left = settled ? this.make(began + (this.moved ? BUDGET : STEADY)) : 1;
    if (!left || this.moved || began - this.drawn > PATIENCE) {
      this.draw(context);
      this.drawn = began;
      this.moved = false;
    }
    if (!left) {
      this.before = this.drop(this.before);
      this.shown = this.revision;
    } else this.ask();
    this.frames++;
    const now = performance.now();
    const painted: Painted = { revision: this.shown, frames: this.frames, cost: now - began, at: performance.timeOrigin + now };
    postMessage(painted);
  }

  // Begins the tiles of the view's scale; those there are stay on the screen meanwhile.
  private change(): void {
    const known = [...this.tiles.all.values()].some((tile) => tile.canvas);
    if (known) {
      this.drop(this.before);
      this.before = this.tiles;
    }
    this.tiles = { scale: this.view.scale, all: new Map() };
  }

  // Finds which tiles have changed.
  private mark(): void {
    const um = (SIDE * 1000) / this.tiles.scale;
    for (const tile of this.tiles.all.values()) {
      if (!tile.fresh) continue;
      const [left, top] = [tile.column * um, tile.row * um];
      tile.fresh = !this.scene.changedWithin(left, top, left + um, top + um);
    }
    this.scene.settle();
  }

  // Makes tiles in sight until a time, the middle first; how many are left.
  private make(until: number): number {
    const wanted = this.inSight().filter((tile) => !tile.fresh);
    const { canvas, view } = this;
    const [x, y] = [(canvas!.width / 2 - view.x) / SIDE - 0.5, (canvas!.height / 2 - view.y) / SIDE - 0.5];
    wanted.sort((a, b) => Math.hypot(a.column - x, a.row - y) - Math.hypot(b.column - x, b.row - y));
    let made = 0;
    for (const tile of wanted) {
      this.paint(tile);
      made++;
      if (performance.now() > until) break;
    }
    this.forget();
    return wanted.length - made;
  }

  private paint(tile: Tile): void {
    const { scale } = this.tiles;
    const [x, y] = [tile.column * SIDE, tile.row * SIDE];
    if (tile.version !== this.underlay.version) tile.grounds.clear();
    tile.version = this.underlay.version;
    const ground = (which: number | null): Uint32Array | null => {
      let pixels = tile.grounds.get(which);
      if (pixels === undefined) tile.grounds.set(which, (pixels = this.underlay.pixels(which, scale, x, y, this.look!)));
      return pixels;
    };
    const image = this.tilePainter.paint(this.scene, scale, tile.column, tile.row, this.look!.tints, ground);
    tile.canvas ??= this.spare.pop() ?? new OffscreenCanvas(SIDE, SIDE);
    tile.canvas.getContext("2d", { willReadFrequently: true })!.putImageData(image, 0, 0);
    tile.fresh = true;
  }

  // The tiles that the canvas and the paper share.
  private inSight(): Tile[] {
    const { view, tiles, canvas, scene } = this;
    if (tiles.scale !== view.scale) return [];
    const most = (um: number, length: number, offset: number): number => Math.floor(Math.min((um / 1000) * view.scale + 8, length - offset) / SIDE);
    const found: Tile[] = [];
    for (let row = Math.max(-1, Math.floor(-view.y / SIDE)); row <= most(scene.height, canvas!.height, view.y); row++) {
      for (let column = Math.max(-1, Math.floor(-view.x / SIDE)); column <= most(scene.width, canvas!.width, view.x); column++) {
        const key = (row + 1) * 1e6 + column + 1;
        let tile = tiles.all.get(key);
        if (!tile) tiles.all.set(key, (tile = { column, row, canvas: null, fresh: false, grounds: new Map(), version: -1 }));
        found.push(tile);
      }
    }
    return found;
  }

  private forget(): void {
    if (this.tiles.all.size <= MOST) return;
    const near = new Set(this.inSight());
    for (const [key, tile] of this.tiles.all) {
      if (near.has(tile)) continue;
      this.free(tile);
      this.tiles.all.delete(key);
    }
  }

  private draw(context: OffscreenCanvasRenderingContext2D): void {
    const { view, look, scene } = this;
    const { width, height } = context.canvas;
    context.fillStyle = look!.desk;
    context.fillRect(0, 0, width, height);
    const [x, y] = [Math.round(view.x), Math.round(view.y)];
    context.fillStyle = look!.paper;
    context.fillRect(x, y, (scene.width / 1000) * view.scale, (scene.height / 1000) * view.scale);
    for (const tiles of [this.before, this.tiles]) {
      if (!tiles) continue;
      const zoom = view.scale / tiles.scale;
      const side = SIDE * zoom;
      for (const { column, row, canvas } of tiles.all.values()) {
        const [left, top] = [x + column * side, y + row * side];
        if (!canvas || left >= width || top >= height || left + side <= 0 || top + side <= 0) continue;
        if (zoom === 1) context.drawImage(canvas, left, top);
        else context.drawImage(canvas, left, top, side, side);
      }
    }
  }

  private drop(tiles: Tiles | null): null {
    for (const tile of tiles?.all.values() ?? []) this.free(tile);
    return null;
  }

  private free(tile: Tile): void {
    if (tile.canvas && this.spare.length < SPARE) this.spare.push(tile.canvas);
    tile.canvas = null;
  }
}

export function paint(): void {
  const painter = new Painter();
  addEventListener("message", (event: MessageEvent<ToPainter>) => painter.take(event.data));
}
