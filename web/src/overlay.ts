// What is drawn over the drawing: rulers, guides, the wall, the region, handles, and the gesture under way.

import type { Desk } from "./desk";
import { byId } from "./dom";
import type { Gesture } from "./gestures";
import { drawHandles } from "./handles";
import { drawRulers } from "./rulers";

export class Overlay {
  gesture: Gesture | null = null;
  private readonly canvas = byId<HTMLCanvasElement>("overlay");
  private readonly ring = byId("ring");
  private readonly cross = byId("cross");
  private readonly notches = [byId("across"), byId("down")] as const; // where the pointer is, on the rulers
  private pointer: [number, number] | null = null;
  private asked = false;

  constructor(private readonly desk: Desk) {
    const { drawing, viewport, appearance, tool, region, settings } = desk;
    const ask = (): void => this.ask();
    for (const signal of [viewport.changed, appearance.changed]) signal.on(ask);
    let shown = "";
    drawing.changed.on(() => {
      const { wall = null, selected = 0 } = drawing.state.value ?? {};
      const now = JSON.stringify([wall, selected, drawing.canvas]);
      if (selected || now !== shown) ask(); // a selection may have moved
      shown = now;
    });
    for (const watched of [drawing.hello, tool, region]) watched.on(ask);
    settings.changed.on(ask);
  }

  // The pointer is at a place in px of the page; null: it is elsewhere.
  point(place: [number, number] | null, byKeys = false): void {
    this.pointer = place;
    this.cross.hidden = !(place && byKeys);
    if (place) this.cross.style.transform = `translate(${place[0]}px, ${place[1]}px)`;
    this.follow();
  }

  ask(): void {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => this.draw());
  }

  // The rim of the brush and the notches on the rulers, as elements of their own: moving them draws nothing anew.
  private follow(): void {
    const [across, down] = this.notches;
    across.hidden = down.hidden = !(this.pointer && this.desk.appearance.rulers.value);
    if (this.pointer) across.style.transform = `translateX(${this.pointer[0]}px)`;
    if (this.pointer) down.style.transform = `translateY(${this.pointer[1]}px)`;
    const { tool, settings, viewport } = this.desk;
    const one = tool.value;
    const shown = this.pointer && one?.ring && one.operation;
    this.ring.hidden = !shown;
    if (!shown || !this.pointer) return;
    const size = Number(settings.get(one.operation!, "size"));
    const side = Math.max(3, (size * viewport.scale) / viewport.ratio);
    const [x, y] = [this.pointer[0] - side / 2, this.pointer[1] - side / 2];
    this.ring.style.transform = `translate(${x}px, ${y}px)`;
    this.ring.style.width = this.ring.style.height = `${side}px`;
  }

  private draw(): void {
    this.asked = false;
    this.follow();
    const { canvas, desk } = this;
    const { viewport, drawing, appearance } = desk;
    if (canvas.width !== viewport.width || canvas.height !== viewport.height) [canvas.width, canvas.height] = [viewport.width, viewport.height];
    const context = canvas.getContext("2d")!;
    context.setTransform(viewport.ratio, 0, 0, viewport.ratio, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    if (!drawing.hello.value) return;
    if (appearance.guides.value) this.guides(context);
    this.outlines(context);
    const inks = { ground: appearance.colour("panel"), stroke: appearance.colour("ruler"), text: appearance.colour("muted") };
    if (appearance.rulers.value) drawRulers(context, viewport, inks);
  }

  // The wall, the region, the selection's handles and the gesture: each first in white and wider, so that they show on ink too.
  private outlines(context: CanvasRenderingContext2D): void {
    const { drawing, appearance, region, tool } = this.desk;
    const box = tool.value?.part === "select" && !this.gesture?.draw ? drawing.selection() : null;
    const accent = appearance.colour("accent-on-paper");
    for (const halo of [true, false]) {
      const pen = (colour: string, dash: number[]): void => {
        context.strokeStyle = halo ? "#fffd" : colour;
        context.lineWidth = halo ? 4 : 1.5;
        context.setLineDash(halo ? [] : dash);
      };
      pen(appearance.colour("wall"), [6, 3]);
      for (const ring of drawing.state.value?.wall ?? []) this.outline(context, ring, 2);
      pen(accent, [6, 3]);
      if (region.value) this.outline(context, region.value, 3);
      pen(accent, []);
      if (box) drawHandles(this.desk, context, box);
      context.fillStyle = halo ? "transparent" : `color-mix(in srgb, ${accent} 12%, transparent)`;
      this.gesture?.draw?.(context);
    }
  }

  // The paper's edge, its margin, and the outline of the canvas.
  private guides(context: CanvasRenderingContext2D): void {
    const { viewport, drawing, appearance } = this.desk;
    const { size, margin } = drawing.hello.value!;
    const rectangle = (inset: number): void => {
      const [[x0, y0], [x1, y1]] = [viewport.px(inset, inset), viewport.px(size[0] - inset, size[1] - inset)];
      context.strokeRect(Math.round(x0) + 0.5, Math.round(y0) + 0.5, Math.round(x1 - x0) - 1, Math.round(y1 - y0) - 1);
    };
    context.lineWidth = 1;
    context.setLineDash([]);
    context.strokeStyle = appearance.colour("edge");
    rectangle(0);
    context.setLineDash([2, 3]);
    context.strokeStyle = appearance.colour("guide");
    if (margin) rectangle(margin);
    for (const ring of drawing.canvas) this.outline(context, ring, 2);
  }

  // Strokes a ring of places in mm, each of so many numbers.
  private outline(context: CanvasRenderingContext2D, ring: number[], each: number): void {
    context.beginPath();
    for (let k = 0; k + 1 < ring.length; k += each) context.lineTo(...this.desk.viewport.px(ring[k]!, ring[k + 1]!));
    context.closePath();
    context.stroke();
  }
}
