// Small shapes as ready-made patches of coverage, so that a hundred thousand of them are copied and not drawn.

import { Coverage } from "./coverage";
import type { Outline } from "./outline";

// Pixels of coverage about a centre: `left` and `top` are where the first lies from the pixel that holds it.
export interface Sprite {
  left: number;
  top: number;
  width: number;
  height: number;
  values: Uint8Array;
}

export const LARGEST = 6; // px of reach: larger shapes are drawn each by itself, exactly
const SIZES = 48; // steps while a size doubles: areas are right to 1.5 %
const LEAST = 1 / 64; // px of reach
const PENS = 16; // steps to the px of pen
const PLACES = 4; // steps to the px of place, across and down
const MOST = 24e6; // bytes kept

const coverage = new Coverage();

// The sprites of one outline in one size and pen, by turn and place.
export class Family {
  private readonly turns: number; // so many that a rim of this size steps by half a pixel
  private readonly kept: (Sprite | undefined)[] = [];

  constructor(private readonly outline: Outline, private readonly reach: number, private readonly pen: number, private readonly weigh: (bytes: number) => void) {
    this.turns = Math.max(1, Math.ceil(reach * 13));
  }

  // The sprite at a place within its pixel (0 to 1 each) and a turn in radians.
  at(x: number, y: number, turn: number): Sprite {
    const { turns } = this;
    const heading = Math.round((turn / (2 * Math.PI)) * turns) % turns;
    const column = Math.min(PLACES - 1, (x * PLACES) | 0);
    const row = Math.min(PLACES - 1, (y * PLACES) | 0);
    const key = (heading * PLACES + row) * PLACES + column;
    return this.kept[key] ?? (this.kept[key] = this.made(column, row, (heading / turns) * 2 * Math.PI));
  }

  private made(column: number, row: number, turn: number): Sprite {
    const sprite = drawn(this.outline, (column + 0.5) / PLACES, (row + 0.5) / PLACES, this.reach / this.outline.reach, turn, this.pen);
    this.weigh(sprite.values.length + 100);
    return sprite;
  }
}

export class Sprites {
  private readonly kept = new Map<number, Map<Outline, Map<number, Family>>>(); // by pen, by outline, by size
  private bytes = 0;

  // The sprites of an outline at a scale in px and a pen in px (0: filled).
  of(outline: Outline, scale: number, pen: number): Family {
    if (this.bytes > MOST) {
      this.kept.clear();
      this.bytes = 0;
    }
    const size = Math.round(Math.log2(Math.max(LEAST, scale * outline.reach) / LEAST) * SIZES);
    const width = Math.round(pen * PENS);
    const outlines = entry(this.kept, width, () => new Map<Outline, Map<number, Family>>());
    const sizes = entry(outlines, outline, () => new Map<number, Family>());
    return entry(sizes, size, () => new Family(outline, LEAST * 2 ** (size / SIZES), width / PENS, (bytes) => (this.bytes += bytes)));
  }
}

function drawn(outline: Outline, x: number, y: number, scale: number, turn: number, pen: number): Sprite {
  const reach = Math.ceil(outline.reach * scale + pen / 2 + 1);
  const side = 2 * reach + 1;
  coverage.over(-reach, -reach, side, side);
  const pose = { x, y, cos: scale * Math.cos(turn), sin: scale * Math.sin(turn) };
  if (pen > 0) coverage.stroke(outline.rings(scale), pose, pen);
  else coverage.fill(outline.rings(scale), pose);
  return cropped(coverage.bytes(), side, -reach);
}

// The part of a square of pixels that has any coverage; its first pixel lies at `first`, across and down.
function cropped(values: Uint8Array, side: number, first: number): Sprite {
  let [left, top, right, bottom] = [side, side, 0, 0];
  for (let y = 0; y < side; y++) {
    for (let x = 0; x < side; x++) {
      if (!values[y * side + x]) continue;
      [left, top, right, bottom] = [Math.min(left, x), Math.min(top, y), Math.max(right, x + 1), y + 1];
    }
  }
  const [width, height] = [Math.max(0, right - left), Math.max(0, bottom - top)];
  const part = new Uint8Array(width * height);
  for (let y = 0; y < height; y++) part.set(values.subarray((top + y) * side + left, (top + y) * side + right), y * width);
  return { left: first + left, top: first + top, width, height, values: part };
}

function entry<K, V>(map: Map<K, V>, key: K, made: () => V): V {
  let value = map.get(key);
  if (value === undefined) map.set(key, (value = made()));
  return value;
}
