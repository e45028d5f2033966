// The paper of the drawing: how large it is now, and what makes it another.

import type { Desk } from "./desk";
import { el } from "./dom";
import { form } from "./form";

export function paperSection(desk: Desk): HTMLElement {
  const now = el("p", { class: "count" });
  const section = el("section", { class: "section stack", "aria-label": "Paper" }, el("h2", {}, "Paper"), now);
  desk.drawing.hello.on((hello) => {
    if (!hello) return;
    const [width, height] = hello.size.map((mm) => Number(mm.toFixed(2)));
    now.textContent = `${width} × ${height} mm${hello.margin === null ? "" : `, margin ${Number(hello.margin.toFixed(2))} mm`}`;
  });
  desk.drawing.begun(() => {
    const operation = desk.operation("paper");
    if (operation) section.append(el("details", {}, el("summary", {}, "Another paper"), form(desk, operation, "Put it on this paper")));
  });
  return section;
}
