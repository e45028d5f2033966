// Keeps the painter told: its canvas as large as its place, the view, the look, and the images that lie beneath.

import type { Desk } from "./desk";
import { byId } from "./dom";
import { picture, still } from "./images";
import type { ToPainter } from "./painting";

export type Tell = (message: ToPainter, move?: Transferable[]) => void;

export function showing(desk: Desk, tell: Tell): void {
  const { viewport, appearance, drawing } = desk;
  const stage = byId("stage");
  const canvas = byId<HTMLCanvasElement>("drawing").transferControlToOffscreen();
  tell({ do: "canvas", canvas }, [canvas]);
  let asked = false;
  viewport.changed.on(() => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => {
      asked = false;
      tell({ do: "view", view: viewport.view, width: viewport.width, height: viewport.height });
    });
  });
  const measure = (): void => {
    const [width, height] = [stage.clientWidth, stage.clientHeight].map((px) => Math.round(px * devicePixelRatio)) as [number, number];
    viewport.resize(width, height, devicePixelRatio);
  };
  new ResizeObserver(measure).observe(stage);
  measure();
  const look = (): void => tell({ do: "look", look: appearance.look });
  appearance.changed.on(look);
  look();
  let shown = "";
  drawing.hello.on((hello) => {
    if (!hello) return;
    const now = JSON.stringify([hello.name, hello.size]);
    if (now !== shown) viewport.show(hello.size); // the same paper after a broken line stays where it was
    shown = now;
  });
  images(desk, tell);
}

function images(desk: Desk, tell: Tell): void {
  const { drawing } = desk;
  const { wire } = desk.link;
  const give = (name: "picture" | number, bitmap: ImageBitmap | null): void => tell({ do: "image", name, bitmap }, bitmap ? [bitmap] : []);
  const asked = new Set<number>(); // still layers
  drawing.hello.on((hello) => {
    asked.clear();
    if (!hello) return;
    if (hello.picture) void picture(wire).then((bitmap) => give("picture", bitmap));
    else give("picture", null);
  });
  drawing.state.on((state) => {
    const { size } = drawing.hello.value ?? {};
    for (const { id, kind } of state?.layers ?? []) {
      if (kind !== "still" || asked.has(id) || !size) continue;
      asked.add(id);
      void still(wire, id, size).then((bitmap) => give(id, bitmap));
    }
  });
}
