// Which part of the paper is seen, and how large: pan, zoom, and places on the screen as places on the paper.

import type { View } from "./painting";
import { Signal } from "./watch";

const LEAST = 20; // px that the paper's longer side is never smaller than
const FINEST = 4000; // px to the mm: a nib's dot fills the screen
const AROUND = 40; // px left free around the whole paper

export class Viewport {
  readonly changed = new Signal();
  scale = 1;
  x = 0;
  y = 0;
  width = 1; // px of the screen
  height = 1;
  ratio = 1; // px of the screen to those of the page
  private paper: [number, number] = [100, 100];

  get view(): View {
    return { scale: this.scale, x: this.x, y: this.y };
  }

  // The place on the paper, mm, of one on the canvas in px of the page.
  mm(x: number, y: number): [number, number] {
    return [(x * this.ratio - this.x) / this.scale, (y * this.ratio - this.y) / this.scale];
  }

  // The place on the canvas in px of the page of one on the paper, mm.
  px(x: number, y: number): [number, number] {
    return [(x * this.scale + this.x) / this.ratio, (y * this.scale + this.y) / this.ratio];
  }

  resize(width: number, height: number, ratio: number): void {
    const zoom = ratio / this.ratio;
    [this.width, this.height, this.ratio] = [width, height, ratio];
    [this.scale, this.x, this.y] = [this.scale * zoom, this.x * zoom, this.y * zoom];
    this.changed.say();
  }

  show(paper: [number, number]): void {
    this.paper = paper;
    this.fit({ left: 0, top: 0, right: paper[0], bottom: paper[1] });
  }

  all(): void {
    this.fit({ left: 0, top: 0, right: this.paper[0], bottom: this.paper[1] });
  }

  // Shows a box of mm, whole and in the middle.
  fit(box: { left: number; top: number; right: number; bottom: number }): void {
    const free = AROUND * this.ratio;
    const [across, down] = [Math.max(box.right - box.left, 1e-3), Math.max(box.bottom - box.top, 1e-3)];
    this.scale = this.bounded(Math.min((this.width - 2 * free) / across, (this.height - 2 * free) / down));
    this.x = this.width / 2 - ((box.left + box.right) / 2) * this.scale;
    this.y = this.height / 2 - ((box.top + box.bottom) / 2) * this.scale;
    this.changed.say();
  }

  // Moves the paper by px of the page.
  pan(dx: number, dy: number): void {
    this.x += dx * this.ratio;
    this.y += dy * this.ratio;
    this.keep();
    this.changed.say();
  }

  // Zooms by a factor; the place at x, y in px of the page stays where it is, the middle where none is given.
  zoom(factor: number, x = this.width / this.ratio / 2, y = this.height / this.ratio / 2): void {
    const [mmX, mmY] = this.mm(x, y);
    this.scale = this.bounded(this.scale * factor);
    this.x = x * this.ratio - mmX * this.scale;
    this.y = y * this.ratio - mmY * this.scale;
    this.keep();
    this.changed.say();
  }

  // px of the screen to the mm.
  set(scale: number): void {
    this.zoom(scale / this.scale);
  }

  private bounded(scale: number): number {
    return Math.min(FINEST * this.ratio, Math.max(LEAST / Math.max(...this.paper), scale));
  }

  // Some of the paper stays in sight.
  private keep(): void {
    const edge = AROUND * this.ratio;
    this.x = Math.min(this.width - edge, Math.max(edge - this.paper[0] * this.scale, this.x));
    this.y = Math.min(this.height - edge, Math.max(edge - this.paper[1] * this.scale, this.y));
  }
}
