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

export class Sprites {
  private readonly kept = new Map<number, Map<Outline, Map<number, Sprite>>>(); // by pen, by outline, by pose
  private bytes = 0;

  // The sprite of an outline at a place within its pixel (0 to 1 each), a scale in px, a turn in radians and a pen in px (0: filled).
  of(outline: Outline, x: number, y: number, scale: number, turn: number, pen: number): Sprite {
    const size = Math.round(Math.log2(Math.max(LEAST, scale * outline.reach) / LEAST) * SIZES);
    const reach = LEAST * 2 ** (size / SIZES);
    const turns = Math.max(1, Math.ceil(reach * 13)); // so many that a rim of this size steps by half a pixel
    const heading = Math.round((turn / (2 * Math.PI)) * turns) % turns;
    const [column, row] = [Math.min(PLACES - 1, Math.floor(x * PLACES)), Math.min(PLACES - 1, Math.floor(y * PLACES))];
    const width = Math.round(pen * PENS);
    const outlines = entry(this.kept, width, () => new Map<Outline, Map<number, Sprite>>());
    const poses = entry(outlines, outline, () => new Map<number, Sprite>());
    const key = (size * 256 + heading) * PLACES * PLACES + row * PLACES + column;
    const found = poses.get(key);
    if (found) return found;
    const at = { x: (column + 0.5) / PLACES, y: (row + 0.5) / PLACES };
    const made = drawn(outline, at.x, at.y, reach / outline.reach, (heading / turns) * 2 * Math.PI, width / PENS);
    this.bytes += made.values.length + 100;
    if (this.bytes > MOST) this.clear();
    else poses.set(key, made);
    return made;
  }

  clear(): void {
    this.kept.clear();
    this.bytes = 0;
  }
}

function drawn(outline: Outline, x: number, y: number, scale: number, turn: number, pen: number): Sprite {
  const reach = Math.ceil(outline.reach * scale + pen / 2 + 1);
  const side = 2 * reach + 1;
  coverage.over(-reach, -reach, side, side);
  const pose = { x, y, cos: scale * Math.cos(turn), sin: scale * Math.sin(turn) };
  if (pen > 0) coverage.stroke(outline.rings(scale), pose, pen);
  else coverage.fill(outline.rings(scale), pose);
  return { left: -reach, top: -reach, width: side, height: side, values: coverage.bytes() };
}

function entry<K, V>(map: Map<K, V>, key: K, made: () => V): V {
  let value = map.get(key);
  if (value === undefined) map.set(key, (value = made()));
  return value;
}
