// What a tool does between the pen coming down and going up, and how pointers, fingers, the wheel and the keyboard become that.

import type { Viewport } from "./viewport";

// A place on the paper, mm, with the pen's pressure, 0 to 1.
export interface Point {
  x: number;
  y: number;
  pressure: number;
}

export interface Gesture {
  move: (points: Point[]) => void;
  end: () => void;
  cancel: () => void;
  draw?: (context: CanvasRenderingContext2D) => void; // in px of the page
}

export interface Keys {
  shift: boolean;
  alt: boolean;
}

export type Begin = (point: Point, keys: Keys) => Gesture | null;

const HOLD = 80; // ms that a finger waits for a second one before it draws
const SLIP = 5; // px of the page that it may move meanwhile
const MOUSE = 1; // a mouse presses wholly: what it says itself, one half, would halve every brush

interface Finger {
  x: number;
  y: number;
}

// Turns the events of the canvas into gestures and into pan and zoom.
export class Pointers {
  private gesture: Gesture | null = null;
  private owner = -1;
  private panning = false;
  private waiting: { start: () => void; timer: ReturnType<typeof setTimeout>; x: number; y: number } | null = null;
  private readonly fingers = new Map<number, Finger>();
  space = false; // held down: every pointer pans

  constructor(
    private readonly surface: HTMLElement,
    private readonly viewport: Viewport,
    private readonly begin: Begin,
    private readonly hover: (x: number, y: number, inside: boolean) => void,
    private readonly drawn: (gesture: Gesture | null) => void,
  ) {
    surface.addEventListener("pointerdown", (event) => this.down(event));
    surface.addEventListener("pointermove", (event) => this.move(event));
    surface.addEventListener("pointerup", (event) => this.up(event, false));
    surface.addEventListener("pointercancel", (event) => this.up(event, true));
    surface.addEventListener("pointerleave", (event) => this.hover(event.offsetX, event.offsetY, false));
    surface.addEventListener("contextmenu", (event) => event.preventDefault());
    surface.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
  }

  get busy(): boolean {
    return this.gesture !== null;
  }

  // Gives up the gesture under way.
  cancel(): void {
    this.drop();
    this.finish((gesture) => gesture.cancel());
  }

  private place(event: PointerEvent | WheelEvent): Finger {
    const box = this.surface.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }

  private point(event: PointerEvent): Point {
    const { x, y } = this.place(event);
    const [mmX, mmY] = this.viewport.mm(x, y);
    return { x: mmX, y: mmY, pressure: event.pointerType === "pen" ? event.pressure : MOUSE };
  }

  private down(event: PointerEvent): void {
    this.surface.focus({ preventScroll: true });
    this.surface.setPointerCapture(event.pointerId);
    if (event.pointerType === "touch") {
      this.fingers.set(event.pointerId, this.place(event));
      if (this.fingers.size > 1) return this.cancel();
    }
    if (this.gesture || this.panning) return;
    if (event.button === 1 || this.space) {
      this.panning = true;
      this.owner = event.pointerId;
      this.fingers.set(event.pointerId, this.place(event));
      return;
    }
    if (event.button !== 0) return;
    this.owner = event.pointerId;
    const [point, keys] = [this.point(event), { shift: event.shiftKey, alt: event.altKey }];
    const start = (): void => {
      this.drop();
      this.gesture = this.begin(point, keys);
      this.drawn(this.gesture);
    };
    if (event.pointerType === "touch") this.waiting = { start, timer: setTimeout(start, HOLD), ...this.place(event) };
    else start();
  }

  private drop(): void {
    clearTimeout(this.waiting?.timer);
    this.waiting = null;
  }

  private move(event: PointerEvent): void {
    const { x, y } = this.place(event);
    this.hover(x, y, event.pointerType !== "touch" || this.gesture !== null);
    const finger = this.fingers.get(event.pointerId);
    if (finger && (this.fingers.size > 1 || this.panning)) return this.pinch(event.pointerId, finger, { x, y });
    if (finger) this.fingers.set(event.pointerId, { x, y });
    if (this.waiting && Math.hypot(x - this.waiting.x, y - this.waiting.y) > SLIP) this.waiting.start();
    if (!this.gesture || event.pointerId !== this.owner) return;
    const events = event.getCoalescedEvents?.() ?? [];
    this.gesture.move((events.length ? events : [event]).map((one) => this.point(one)));
    this.drawn(this.gesture);
  }

  // One of two fingers, or the panning pointer, has moved: the paper follows both.
  private pinch(id: number, from: Finger, to: Finger): void {
    const other = [...this.fingers].find(([key]) => key !== id)?.[1];
    this.fingers.set(id, to);
    if (!other) return this.viewport.pan(to.x - from.x, to.y - from.y);
    const [was, now] = [Math.hypot(from.x - other.x, from.y - other.y), Math.hypot(to.x - other.x, to.y - other.y)];
    this.viewport.pan((to.x - from.x) / 2, (to.y - from.y) / 2);
    if (was > 10 && now > 10) this.viewport.zoom(now / was, (to.x + other.x) / 2, (to.y + other.y) / 2);
  }

  private up(event: PointerEvent, cancelled: boolean): void {
    this.fingers.delete(event.pointerId);
    if (event.pointerId !== this.owner) return;
    this.panning = false;
    if (!cancelled) this.waiting?.start();
    this.finish((gesture) => (cancelled ? gesture.cancel() : gesture.end()));
  }

  private finish(how: (gesture: Gesture) => void): void {
    const { gesture } = this;
    this.gesture = null;
    if (gesture) how(gesture);
    this.drawn(null);
  }

  // Pans, or with Ctrl, as two fingers on a trackpad also say it, zooms.
  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const unit = event.deltaMode === 1 ? 16 : event.deltaMode === 2 ? 400 : 1; // px of a line and of a page
    const [dx, dy] = [event.deltaX * unit, event.deltaY * unit];
    const { x, y } = this.place(event);
    if (event.ctrlKey || event.metaKey) this.viewport.zoom(Math.exp(-Math.max(-60, Math.min(60, dy)) * 0.006), x, y);
    else if (event.shiftKey && !dx) this.viewport.pan(-dy, 0);
    else this.viewport.pan(-dx, -dy);
  }
}
