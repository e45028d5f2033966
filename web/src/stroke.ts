// A brush stroke: points an even distance apart, sent in pieces while the pen is still down, all in one group.

import type { Gesture, Point } from "./gestures";

const FLYING = 2; // pieces on their way at once; what comes meanwhile goes with the next
const APART = 0.12; // points, in diameters of the brush: a chain of circles this close leaves no notch over 1 % of the radius
const LINGER = 70; // ms after which a pen held still goes on, where the brush does that

export interface Brush {
  size: number; // mm
  lead: boolean; // each piece begins with the last point of the one before, as dragging needs
  least: number; // points in a piece, but the last
  lingers: boolean;
  most: number; // numbers in a piece
  send: (path: number[]) => Promise<unknown>;
}

// The way of a stroke as points an even distance apart.
export class Way {
  private last: Point;
  private left: number; // mm to the next point

  constructor(first: Point, private readonly apart: number) {
    this.last = first;
    this.left = apart;
  }

  // The points that are passed on the way to the next.
  to(next: Point): Point[] {
    const points: Point[] = [];
    const { last } = this;
    const length = Math.hypot(next.x - last.x, next.y - last.y);
    let at = this.left;
    for (; at <= length; at += this.apart) points.push(between(last, next, at / length));
    this.left = at - length;
    this.last = next;
    return points;
  }
}

function between(a: Point, b: Point, part: number): Point {
  const mix = (from: number, to: number): number => from + part * (to - from);
  return { x: mix(a.x, b.x), y: mix(a.y, b.y), pressure: mix(a.pressure, b.pressure) };
}

export function stroke(first: Point, brush: Brush): Gesture {
  const way = new Way(first, Math.max(brush.size * APART, 0.02));
  let waiting: Point[] = [first];
  let before: Point | null = null; // the last that was sent
  let latest = first;
  let flying = 0;
  let over = false;
  let dead = false;

  const ready = (): boolean => waiting.length >= (over ? 1 : brush.least) && (!brush.lead || before !== null || waiting.length > 1);
  const send = (): void => {
    while (!dead && flying < FLYING && ready()) {
      const piece = waiting.splice(0, Math.floor(brush.most / 3) - 1);
      const points = brush.lead && before ? [before, ...piece] : piece;
      before = piece[piece.length - 1]!;
      flying++;
      const path = points.flatMap((point) => [micro(point.x), micro(point.y), Math.round(point.pressure * 1000) / 1000]);
      brush.send(path).then(landed, () => (dead = true));
    }
  };
  const landed = (): void => {
    flying--;
    send();
  };
  const linger = brush.lingers
    ? setInterval(() => {
        if (flying || waiting.length) return;
        waiting.push(latest);
        send();
      }, LINGER)
    : undefined;
  const finish = (): void => {
    over = true;
    clearInterval(linger);
    send();
  };
  send();
  return {
    move(points) {
      for (const point of points) waiting.push(...way.to((latest = point)));
      send();
    },
    end() {
      if (latest !== (waiting[waiting.length - 1] ?? before)) waiting.push(latest); // where the pen went up
      finish();
    },
    cancel() {
      waiting = [];
      finish();
    },
  };
}

// mm to the micrometre: what is sent is what the log keeps.
function micro(mm: number): number {
  return Math.round(mm * 1000) / 1000;
}
