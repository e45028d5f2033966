// What lies beneath the items: the paper, the picture or a map of the tone on it, and what is on the sheet but not edited.

import type { Look, Under } from "./painting";
import type { Patch } from "./protocol";
import { SIDE } from "./tile";

type Image = ImageBitmap | OffscreenCanvas;
type Box = [number, number, number, number]; // x, y, width, height

// The colour and opacity that a value of a map is shown in: ink as it is; importance from its neutral middle, finer and coarser.
const SHOWN: Record<Patch["map"], (value: number) => [number, number, number, number]> = {
  tone: (value) => [32, 32, 32, value],
  importance: (value) => (value > 127 ? [120, 30, 170, Math.min(255, (value - 127) * 2)] : [0, 120, 60, (127 - value) * 2]),
};

export class Underlay {
  version = 0; // rises with every change
  private readonly images = new Map<Under | number, Image[]>(); // each half as large as the one before
  private readonly scratch = new OffscreenCanvas(SIDE, SIDE);
  size: [number, number] = [1, 1];
  art: Box = [0, 0, 1, 1];

  show(name: "picture" | number, bitmap: ImageBitmap | null): void {
    this.version++;
    this.images.delete(name);
    if (bitmap) this.images.set(name, halves(bitmap));
  }

  forgetMaps(): void {
    this.version++;
    this.images.delete("tone");
    this.images.delete("importance");
  }

  // Takes a part of a map; the box of it on the paper, um: left, top, right, bottom.
  take(patch: Patch): Box {
    this.version++;
    const kept = this.images.get(patch.map)?.[0];
    const fits = kept instanceof OffscreenCanvas && kept.width === patch.columns && kept.height === patch.rows;
    const canvas = fits ? kept : new OffscreenCanvas(patch.columns, patch.rows);
    const pixels = new ImageData(patch.width, patch.height);
    for (let k = 0; k < patch.values.length; k++) pixels.data.set(SHOWN[patch.map](patch.values[k]!), 4 * k);
    canvas.getContext("2d")!.putImageData(pixels, patch.left, patch.top);
    this.images.set(patch.map, [canvas]);
    const [x, y, width, height] = this.art.map((mm) => mm * 1000) as Box;
    const [across, down] = [width / patch.columns, height / patch.rows];
    const [left, top] = [x + (patch.left - 1) * across, y + (patch.top - 1) * down];
    return [left, top, left + (patch.width + 2) * across, top + (patch.height + 2) * down];
  }

  // The pixels of a tile whose corner is at x, y px, at px to the mm: of the paper and what is shown on it, or of the still layer of an id;
  // null where that has none.
  pixels(which: number | null, scale: number, x: number, y: number, look: Look): Uint32Array | null {
    if (which !== null && !this.images.has(which)) return null;
    const context = this.scratch.getContext("2d", { willReadFrequently: true })!;
    const [width, height] = this.size;
    context.clearRect(0, 0, SIDE, SIDE);
    if (which === null) {
      context.fillStyle = look.paper;
      context.fillRect(-x, -y, width * scale, height * scale);
      this.lay(context, look.under, this.art, scale, x, y, look.opacity);
    } else this.lay(context, which, [0, 0, width, height], scale, x, y, 1);
    return new Uint32Array(context.getImageData(0, 0, SIDE, SIDE).data.buffer);
  }

  private lay(context: OffscreenCanvasRenderingContext2D, name: Under | number, box: Box, scale: number, x: number, y: number, alpha: number): void {
    const levels = this.images.get(name);
    if (!levels || !alpha) return;
    const width = box[2] * scale;
    const image = levels.findLast((level) => level.width >= width) ?? levels[0]!;
    context.globalAlpha = alpha;
    context.imageSmoothingEnabled = width < 8 * image.width; // far in, pixels are shown as they are
    context.drawImage(image, box[0] * scale - x, box[1] * scale - y, width, box[3] * scale);
    context.globalAlpha = 1;
  }
}

function halves(bitmap: ImageBitmap): Image[] {
  const levels: Image[] = [bitmap];
  for (let last: Image = bitmap; Math.min(last.width, last.height) > 128; ) {
    const half = new OffscreenCanvas(Math.ceil(last.width / 2), Math.ceil(last.height / 2));
    half.getContext("2d")!.drawImage(last, 0, 0, half.width, half.height);
    levels.push((last = half));
  }
  return levels;
}
