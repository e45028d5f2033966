// Rulers in millimetres along the upper and left sides.

import type { Viewport } from "./viewport";

export const WIDE = 18; // px of the page
const APART = 56; // px between numbers at least
const FIRST = 5; // px between strokes at least

export interface Inks {
  ground: string;
  stroke: string;
  text: string;
}

// A step of 1, 2 or 5 times a power of ten that is no less than so many mm.
export function step(least: number): number {
  const ten = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((k) => k * ten).find((mm) => mm >= least * 0.999)!;
}

export function drawRulers(context: CanvasRenderingContext2D, viewport: Viewport, inks: Inks): void {
  const [width, height] = [viewport.width / viewport.ratio, viewport.height / viewport.ratio];
  context.fillStyle = inks.ground;
  context.fillRect(0, 0, width, WIDE);
  context.fillRect(0, 0, WIDE, height);
  context.font = "10px ui-sans-serif, system-ui, sans-serif";
  context.textBaseline = "alphabetic";
  context.lineWidth = 1;
  context.setLineDash([]);
  context.strokeStyle = inks.stroke;
  ruler(context, viewport, width, inks, false);
  context.save();
  context.transform(0, 1, 1, 0, 0, 0); // x and y exchanged
  ruler(context, viewport, height, inks, true);
  context.restore();
  context.fillStyle = inks.ground;
  context.fillRect(0, 0, WIDE, WIDE);
  context.fillStyle = inks.text;
  context.fillText("mm", 2, 12);
}

function ruler(context: CanvasRenderingContext2D, viewport: Viewport, length: number, inks: Inks, down: boolean): void {
  const px = viewport.scale / viewport.ratio;
  const offset = (down ? viewport.y : viewport.x) / viewport.ratio;
  const apart = step(APART / px);
  const strokes = [10, 5, 2].map((n) => apart / n).find((mm) => mm * px >= FIRST && isRound(mm)) ?? apart;
  const each = Math.round(apart / strokes);
  context.beginPath();
  for (let k = Math.floor((WIDE - offset) / px / strokes); k * strokes * px + offset < length; k++) {
    const at = Math.round(k * strokes * px + offset) + 0.5;
    const long = k % each === 0;
    context.moveTo(at, WIDE);
    context.lineTo(at, long ? 4 : WIDE - 4);
    if (long) number(context, Number((k * strokes).toPrecision(9)), at, inks, down);
  }
  context.stroke();
  context.beginPath();
  context.moveTo(0, WIDE - 0.5);
  context.lineTo(length, WIDE - 0.5);
  context.stroke();
}

function isRound(mm: number): boolean {
  return Math.abs(step(mm) - mm) < 1e-6 * mm;
}

function number(context: CanvasRenderingContext2D, value: number, at: number, inks: Inks, down: boolean): void {
  context.fillStyle = inks.text;
  if (!down) return context.fillText(String(value), at + 3, 11);
  context.save();
  context.transform(0, 1, 1, 0, 0, 0); // upright again
  context.translate(3, at + 3); // turned, letters rise to the right
  context.rotate(Math.PI / 2);
  context.fillText(String(value), 0, 0);
  context.restore();
}
