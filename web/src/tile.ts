// One tile of the drawing as pixels: the coverage of each layer's items, laid over one another in their colours.

import { Coverage } from "./coverage";
import type { Outline } from "./outline";
import { FROZEN, OWN_FILL, SELECTED, type Layer } from "./protocol";
import type { Scene } from "./scene";
import { LARGEST, Sprites, type Family } from "./sprites";

export const SIDE = 256; // px
const QUARTER = (2 * Math.PI) / 65536; // rad of a step of a turn

const LITTLE = new Uint8Array(new Uint32Array([1]).buffer)[0] === 1; // the order of a pixel's bytes in a word

export type Colour = [number, number, number];

export interface Tints {
  selected: Colour;
  frozen: Colour;
  lines: Colour;
}

// Coverage of a tile, 0 to 255, and the rectangle of it that may have some.
class Plane {
  readonly values = new Uint8Array(SIDE * SIDE);
  left = SIDE;
  top = SIDE;
  right = 0;
  bottom = 0;

  get touched(): boolean {
    return this.left < this.right;
  }

  clear(): void {
    for (let y = this.top; y < this.bottom; y++) this.values.fill(0, y * SIDE + this.left, y * SIDE + this.right);
    this.left = this.top = SIDE;
    this.right = this.bottom = 0;
  }

  // Lays a patch over what is there: what is covered by both is covered once more than by chance alone.
  blend(patch: Uint8Array, left: number, top: number, width: number, height: number): void {
    const x0 = Math.max(0, -left);
    const x1 = Math.min(width, SIDE - left);
    const y0 = Math.max(0, -top);
    const y1 = Math.min(height, SIDE - top);
    if (x0 >= x1 || y0 >= y1) return;
    if (left + x0 < this.left) this.left = left + x0;
    if (top + y0 < this.top) this.top = top + y0;
    if (left + x1 > this.right) this.right = left + x1;
    if (top + y1 > this.bottom) this.bottom = top + y1;
    const { values } = this;
    for (let y = y0; y < y1; y++) {
      let at = (top + y) * SIDE + left + x0;
      const end = y * width + x1;
      for (let k = y * width + x0; k < end; k++, at++) {
        const more = patch[k]!;
        if (more) {
          const was = values[at]!;
          values[at] = was + (((255 - was) * more * 257 + 32896) >> 16);
        }
      }
    }
  }

  // A line one pixel wide; a line drawn twice is drawn once.
  line(ax: number, ay: number, bx: number, by: number): void {
    const steep = Math.abs(by - ay) > Math.abs(bx - ax);
    if (steep) [ax, ay, bx, by] = [ay, ax, by, bx];
    if (ax > bx) [ax, ay, bx, by] = [bx, by, ax, ay];
    const slope = bx > ax ? (by - ay) / (bx - ax) : 0;
    const [first, last] = [Math.max(0, Math.floor(ax)), Math.min(SIDE - 1, Math.floor(bx))];
    for (let x = first; x <= last; x++) {
      const y = ay + slope * (Math.min(bx, Math.max(ax, x + 0.5)) - ax) - 0.5;
      const row = Math.floor(y);
      const part = y - row;
      this.most(steep ? row : x, steep ? x : row, 255 * (1 - part));
      this.most(steep ? row + 1 : x, steep ? x : row + 1, 255 * part);
    }
    this.left = this.top = 0;
    this.right = this.bottom = SIDE;
  }

  private most(x: number, y: number, value: number): void {
    if (x < 0 || y < 0 || x >= SIDE || y >= SIDE) return;
    const at = y * SIDE + x;
    if (value > this.values[at]!) this.values[at] = value;
  }
}

// How items of one kind and scale are drawn, px: small ones as sprites of a family.
interface Look {
  outline: Outline;
  scale: number; // um
  size: number;
  pen: number;
  far: number;
  family: Family | null;
}

export class TilePainter {
  readonly image = new ImageData(SIDE, SIDE);
  private readonly data = this.image.data;
  private readonly words = new Uint32Array(this.data.buffer); // a pixel each
  private readonly ink = new Plane();
  private readonly selected = new Plane();
  private readonly frozen = new Plane();
  private readonly sprites = new Sprites();
  private readonly coverage = new Coverage();
  private patch = new Uint8Array(4096);
  private readonly found = { ids: new Int32Array(4096) };

  // The tile of a column and row at a scale of px to the mm, in `image`. `ground` gives the pixels of what lies beneath all layers, for null,
  // and of the still layer of an id.
  paint(scene: Scene, scale: number, column: number, row: number, tints: Tints, ground: (which: number | null) => Uint32Array | null): ImageData {
    this.words.set(ground(null)!);
    const um = 1000 / scale;
    const [left, top] = [column * SIDE * um, row * SIDE * um];
    for (const layer of scene.layers) {
      if (layer.hidden) continue;
      if (layer.kind === "still") {
        this.cover(ground(layer.id));
        continue;
      }
      const n = scene.within(layer.id, left, top, left + SIDE * um, top + SIDE * um, this.found);
      if (n) this.layer(scene, layer, n, scale, column * SIDE, row * SIDE);
      this.lay(this.ink, layer.rgb);
      this.lay(this.frozen, tints.frozen);
      this.lay(this.selected, tints.selected);
    }
    for (const lines of scene.lines.values()) {
      lines.within(left, top, left + SIDE * um, top + SIDE * um, (ax, ay, bx, by) =>
        this.ink.line(ax * scale - column * SIDE, ay * scale - row * SIDE, bx * scale - column * SIDE, by * scale - row * SIDE),
      );
      this.lay(this.ink, tints.lines);
    }
    return this.image;
  }

  private layer(scene: Scene, layer: Layer, n: number, scale: number, originX: number, originY: number): void {
    const { items } = scene;
    const px = scale / 1000;
    const looks: Look[] = []; // of each kind, the last
    for (let k = 0; k < n; k++) {
      const id = this.found.ids[k]!;
      const kind = items.kind[id]!;
      let look = looks[kind];
      if (!look || look.scale !== items.scale[id]!) {
        const outline = scene.kinds.get(kind);
        if (!outline) continue;
        look = looks[kind] = this.look(outline, items.scale[id]!, px, layer);
      }
      const { outline, size, pen, far, family } = look;
      const x = items.x[id]! * px - originX;
      const y = items.y[id]! * px - originY;
      if (x + far < 0 || y + far < 0 || x - far >= SIDE || y - far >= SIDE) continue;
      const flags = items.flags[id]!;
      const own = items.fill[id]!;
      const plane = flags & SELECTED ? this.selected : flags & FROZEN ? this.frozen : this.ink;
      const single = own >= OWN_FILL && plane === this.ink;
      if (single) this.lay(this.ink, layer.rgb); // what lies below it comes first
      const turn = items.turn[id]! * QUARTER;
      if (family) {
        const column = Math.floor(x);
        const row = Math.floor(y);
        const sprite = family.at(x - column, y - row, turn);
        plane.blend(sprite.values, column + sprite.left, row + sprite.top, sprite.width, sprite.height);
      } else {
        const [x0, y0] = [Math.max(0, Math.floor(x - far)), Math.max(0, Math.floor(y - far))];
        const [x1, y1] = [Math.min(SIDE, Math.ceil(x + far)), Math.min(SIDE, Math.ceil(y + far))];
        this.coverage.over(x0, y0, x1 - x0, y1 - y0);
        const pose = { x, y, cos: size * Math.cos(turn), sin: size * Math.sin(turn) };
        if (pen > 0) this.coverage.stroke(outline.rings(size), pose, pen);
        else this.coverage.fill(outline.rings(size), pose);
        this.patch = this.coverage.bytes(this.patch);
        plane.blend(this.patch, x0, y0, x1 - x0, y1 - y0);
      }
      if (single) this.lay(this.ink, [(own >> 16) & 255, (own >> 8) & 255, own & 255]);
    }
  }

  // How items of an outline and a scale look, at so many px to the um.
  private look(outline: Outline, scale: number, px: number, layer: Layer): Look {
    const size = scale * px;
    const pen = layer.pen === null ? (outline.closed ? 0 : 1) : Math.max(layer.pen * px * 1000, 0.1);
    const reach = outline.reach * size;
    return { outline, scale, size, pen, far: reach + pen / 2 + 1, family: reach <= LARGEST ? this.sprites.of(outline, size, pen) : null };
  }

  // Lays pixels over the image.
  private cover(pixels: Uint32Array | null): void {
    if (!pixels) return;
    const { words } = this;
    const over = new Uint8ClampedArray(pixels.buffer);
    for (let k = 0; k < pixels.length; k++) {
      const more = pixels[k] && over[4 * k + 3]!;
      if (more === 255 || (more && !words[k])) words[k] = pixels[k]!;
      else if (more) this.mix(4 * k, over[4 * k]!, over[4 * k + 1]!, over[4 * k + 2]!, more);
    }
  }

  // Lays a colour over the pixel at a place of the data, `more` of 255 of it.
  private mix(at: number, red: number, green: number, blue: number, more: number): void {
    const { data } = this;
    const was = data[at + 3]!;
    const left = (was * (255 - more)) / 255;
    const all = more + left;
    data[at] = (red * more + data[at]! * left) / all;
    data[at + 1] = (green * more + data[at + 1]! * left) / all;
    data[at + 2] = (blue * more + data[at + 2]! * left) / all;
    data[at + 3] = all;
  }

  // Lays a plane over the image in a colour, and clears it.
  private lay(plane: Plane, colour: Colour): void {
    if (!plane.touched) return;
    const { words } = this;
    const [red, green, blue] = colour;
    const bare = LITTLE ? red | (green << 8) | (blue << 16) : (red << 24) | (green << 16) | (blue << 8);
    const { values } = plane;
    for (let y = plane.top; y < plane.bottom; y++) {
      for (let k = y * SIDE + plane.left; k < y * SIDE + plane.right; k++) {
        const more = values[k]!;
        if (!more) continue;
        const was = words[k]!;
        if (more === 255 || !was) words[k] = LITTLE ? bare | (more << 24) : bare | more;
        else if (LITTLE && was >= 0xff000000) {
          const [r, g, b] = [was & 255, (was >> 8) & 255, (was >> 16) & 255];
          const part = more * 257;
          const mixed = (r + (((red - r) * part + 32896) >> 16)) | ((g + (((green - g) * part + 32896) >> 16)) << 8);
          words[k] = mixed | ((b + (((blue - b) * part + 32896) >> 16)) << 16) | 0xff000000;
        } else this.mix(4 * k, red, green, blue, more);
      }
    }
    plane.clear();
  }
}

