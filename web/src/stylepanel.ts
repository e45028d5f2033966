// Drawing all of the canvas, or a region of it, anew in any style with the style's own knobs.

import type { Desk } from "./desk";
import { button, el, unique } from "./dom";
import { controls } from "./form";
import type { Operation } from "./protocol";

const FIRST = "redraw stipple"; // the style in hand at first

export function stylePanel(desk: Desk): HTMLElement {
  const panel = el("div", { class: "panel" });
  desk.drawing.begun((hello) => {
    const styles = hello.operations.filter((one) => one.group === "style");
    if (styles.length) panel.replaceChildren(...redrawing(desk, styles));
  });
  return panel;
}

function short(operation: Operation): string {
  return operation.name.replace(/^redraw /, "");
}

function redrawing(desk: Desk, styles: Operation[]): HTMLElement[] {
  const list = el("select", { id: unique("style") }, ...styles.map((one) => el("option", { value: one.name }, short(one))));
  const body = el("div", {});
  const made = new Map<string, HTMLElement>();
  if (styles.some((one) => one.name === FIRST)) list.value = FIRST;
  const chosen = (): Operation => styles.find((one) => one.name === list.value)!;
  const show = (): void => {
    const operation = chosen();
    if (!made.has(operation.name)) made.set(operation.name, el("div", { class: "stack" }, el("p", { class: "help" }, operation.help), controls(desk, operation)));
    body.replaceChildren(made.get(operation.name)!);
  };
  const where = el("p", { class: "help" });
  const send = (path: number[] | null): void => {
    const operation = chosen();
    void desk.apply(operation.name, { ...desk.settings.params(operation), ...(path ? { path } : {}) });
  };
  const region = button("Draw the region anew", () => send(desk.region.value), { class: "wide primary" });
  const all = button("Draw all anew", () => send(null), { class: "wide" });
  desk.region.on((path) => {
    region.hidden = !path;
    all.classList.toggle("primary", !path);
    where.textContent = path ? "The region is outlined on the canvas." : "To draw a part alone, outline it with the region tool (D).";
  });
  desk.drawing.state.on((state) => (region.disabled = all.disabled = Boolean(state?.busy)));
  list.addEventListener("change", show);
  show();
  return [
    el("h2", {}, "Style"),
    el("div", { class: "knob" }, el("label", { for: list.id }, "Style"), el("div", { class: "knob-inputs" }, list)),
    body,
    where,
    region,
    all,
  ];
}
