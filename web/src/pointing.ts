// The canvas as what pointers and keys act on: the tool in hand begins where they press.

import type { Desk } from "./desk";
import { byId } from "./dom";
import { Pointers, type Keys, type Point } from "./gestures";
import type { Overlay } from "./overlay";
import type { Status } from "./status";

const ARROWS: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export function pointing(desk: Desk, overlay: Overlay, status: Status): Pointers {
  const { viewport } = desk;
  const surface = byId("surface");
  let place: [number, number] | null = null; // mm, of the pointer that keys move
  const hover = (x: number, y: number, inside: boolean): void => {
    place = null;
    overlay.point(inside ? [x, y] : null);
    status.point(inside ? viewport.mm(x, y) : null);
  };
  const begin = (point: Point, held: Keys) => (desk.link.line.value === "open" ? (desk.tool.value?.begin(point, held) ?? null) : null);
  const pointers = new Pointers(surface, viewport, begin, hover, (gesture) => {
    overlay.gesture = gesture;
    overlay.ask();
  });
  surface.addEventListener("keydown", (event) => {
    const arrow = ARROWS[event.key];
    if (event.ctrlKey || event.metaKey || (!arrow && event.key !== "Enter")) return;
    event.preventDefault();
    const step = event.shiftKey ? 10 : 1;
    place ??= viewport.mm(viewport.width / viewport.ratio / 2, viewport.height / viewport.ratio / 2);
    if (arrow) place = [place[0] + step * arrow[0], place[1] + step * arrow[1]];
    else begin({ x: place[0], y: place[1], pressure: 1 }, { shift: event.shiftKey, alt: event.altKey })?.end();
    overlay.point(viewport.px(...place), true);
    status.point(place);
  });
  surface.addEventListener("blur", () => place && hover(0, 0, false));
  space(surface, pointers);
  desk.tool.on((tool) => (surface.dataset.part = tool?.part ?? ""));
  return pointers;
}

// While the space bar is down, every pointer pans.
function space(surface: HTMLElement, pointers: Pointers): void {
  const hold = (held: boolean): void => {
    pointers.space = held;
    surface.classList.toggle("panning", held);
  };
  window.addEventListener("keydown", (event) => {
    if (event.key !== " " || (event.target !== surface && event.target !== document.body)) return;
    event.preventDefault();
    hold(true);
  });
  window.addEventListener("keyup", (event) => {
    if (event.key === " ") hold(false);
  });
  window.addEventListener("blur", () => hold(false));
}
