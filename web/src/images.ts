// Pictures that the server has, as bitmaps for the painter.

import type { Wire } from "./wire";

const WIDEST = 2000; // px of the still layers, which are drawn once

export async function picture(wire: Wire): Promise<ImageBitmap | null> {
  const blob = await wire.get("picture.png");
  return blob && createImageBitmap(blob);
}

// A layer that is not edited, an SVG as large as the paper, drawn once.
export async function still(wire: Wire, layer: number, size: [number, number]): Promise<ImageBitmap | null> {
  const blob = await wire.get(`still-${layer}.svg`);
  if (!blob) return null;
  const image = new Image();
  image.src = URL.createObjectURL(blob);
  await image.decode();
  URL.revokeObjectURL(image.src);
  const px = WIDEST / Math.max(...size);
  const canvas = new OffscreenCanvas(Math.ceil(size[0] * px), Math.ceil(size[1] * px));
  canvas.getContext("2d")!.drawImage(image, 0, 0, canvas.width, canvas.height);
  return canvas.transferToImageBitmap();
}
