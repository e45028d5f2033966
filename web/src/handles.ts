// Handles of the selection: its box drags it, the knob above it turns it. What will be is shown as outlines while the pen is down.

import type { Desk } from "./desk";
import type { Box } from "./drawing";
import type { Gesture, Point } from "./gestures";

const AWAY = 22; // px of the page from the box to the knob
const GRIP = 10; // px around the knob that take hold of it
const SHOWN = 400; // outlines shown while dragging; of more, the box alone

// The box of the selection in px of the page, and its knob.
function places(desk: Desk, box: Box): { left: number; top: number; right: number; bottom: number; knob: [number, number] } {
  const [left, top] = desk.viewport.px(box.left, box.top);
  const [right, bottom] = desk.viewport.px(box.right, box.bottom);
  return { left: left - 4, top: top - 4, right: right + 4, bottom: bottom + 4, knob: [(left + right) / 2, top - 4 - AWAY] };
}

export function drawHandles(desk: Desk, context: CanvasRenderingContext2D, box: Box): void {
  const { left, top, right, bottom, knob } = places(desk, box);
  context.strokeRect(left, top, right - left, bottom - top);
  context.beginPath();
  context.moveTo(knob[0], top);
  context.lineTo(knob[0], knob[1] + 5);
  context.stroke();
  context.beginPath();
  context.arc(...knob, 5, 0, 2 * Math.PI);
  context.save();
  context.fillStyle = "#fff";
  context.fill();
  context.restore();
  context.stroke();
}

// A gesture that moves or turns the selection, where a handle is under the point; else null.
export function handles(desk: Desk, point: Point): Gesture | null {
  const box = desk.drawing.selection();
  if (!box || !desk.operation("move")) return null;
  const { left, top, right, bottom, knob } = places(desk, box);
  const [x, y] = desk.viewport.px(point.x, point.y);
  if (Math.hypot(x - knob[0], y - knob[1]) <= GRIP) return dragged(desk, point, box, true);
  return x >= left && x <= right && y >= top && y <= bottom ? dragged(desk, point, box, false) : null;
}

function dragged(desk: Desk, first: Point, box: Box, turning: boolean): Gesture {
  const middle = centre(desk);
  let [dx, dy, angle] = [0, 0, 0];
  return {
    move: (points) => {
      const last = points[points.length - 1]!;
      if (turning) angle = degrees(last.x - middle[0], last.y - middle[1]) - degrees(first.x - middle[0], first.y - middle[1]);
      else [dx, dy] = [last.x - first.x, last.y - first.y];
    },
    end: () => {
      const round = (value: number): number => Math.round(value * 1000) / 1000;
      const params = turning ? { angle: round(((angle + 540) % 360) - 180) } : { dx: round(dx), dy: round(dy) };
      if (Object.values(params).some((value) => value !== 0)) void desk.apply("move", params);
      else if (!turning) void desk.apply("select", { by: "pick", path: [first.x, first.y, 1] });
    },
    cancel: () => undefined,
    draw: (context) => ghosts(desk, context, box, middle, dx, dy, (angle * Math.PI) / 180),
  };
}

// The middle that the server turns the selection about: of the box of its centres.
function centre(desk: Desk): [number, number] {
  const { items } = desk.drawing;
  let [left, top, right, bottom] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const id of desk.drawing.selected()) {
    [left, right] = [Math.min(left, items.x[id]!), Math.max(right, items.x[id]!)];
    [top, bottom] = [Math.min(top, items.y[id]!), Math.max(bottom, items.y[id]!)];
  }
  return [(left + right) / 2000, (top + bottom) / 2000];
}

function degrees(x: number, y: number): number {
  return (Math.atan2(y, x) * 180) / Math.PI;
}

function ghosts(desk: Desk, context: CanvasRenderingContext2D, box: Box, middle: [number, number], dx: number, dy: number, angle: number): void {
  const { drawing, viewport } = desk;
  const { items } = drawing;
  const px = viewport.scale / viewport.ratio;
  const moved = (x: number, y: number): [number, number] => {
    const [u, v] = [x - middle[0], y - middle[1]];
    return viewport.px(middle[0] + Math.cos(angle) * u - Math.sin(angle) * v + dx, middle[1] + Math.sin(angle) * u + Math.cos(angle) * v + dy);
  };
  context.beginPath();
  if (drawing.state.value!.selected > SHOWN) {
    const { left, top, right, bottom } = box;
    for (const corner of [[left, top], [right, top], [right, bottom], [left, bottom]] as const) context.lineTo(...moved(...corner));
    context.closePath();
    return context.stroke();
  }
  for (const id of drawing.selected()) {
    const outline = drawing.kinds.get(items.kind[id]!);
    if (!outline) continue;
    const [x, y] = moved(items.x[id]! / 1000, items.y[id]! / 1000);
    const size = (items.scale[id]! / 1000) * px;
    const turn = (items.turn[id]! / 65536) * 2 * Math.PI + angle;
    const [cos, sin] = [size * Math.cos(turn), size * Math.sin(turn)];
    for (const { xy, closed } of outline.rings(size)) {
      for (let k = 0; k < xy.length; k += 2) {
        const [u, v] = [x + cos * xy[k]! - sin * xy[k + 1]!, y + sin * xy[k]! + cos * xy[k + 1]!];
        if (k) context.lineTo(u, v);
        else context.moveTo(u, v);
      }
      if (closed) context.closePath();
    }
  }
  context.stroke();
}
