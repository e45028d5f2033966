// The panel of the tool in hand: what it does, its knobs, and what can be done with the selection.

import type { Desk } from "./desk";
import { button, el, put } from "./dom";
import { controls, form } from "./form";
import type { Operation, Params } from "./protocol";
import type { Tool } from "./tools";

export function toolPanel(desk: Desk): HTMLElement {
  const head = el("div", {});
  const chosen = el("section", { class: "section stack", "aria-label": "Selection" });
  const made = new Map<Tool, HTMLElement>();
  desk.tool.on((tool) => {
    if (!tool) return;
    if (!made.has(tool)) made.set(tool, about(desk, tool));
    head.replaceChildren(made.get(tool)!);
  });
  desk.drawing.begun(() => chosen.replaceChildren(...selection(desk)));
  return el("div", { class: "panel" }, head, chosen);
}

function about(desk: Desk, tool: Tool): HTMLElement {
  const { operation, part, name } = tool;
  return el(
    "div",
    { class: "stack" },
    el("h2", {}, tool.title),
    el("p", { class: "help" }, tool.help),
    operation && tool.ring && controls(desk, operation, part === "select" ? ["size"] : undefined),
    operation && part === "brush" && elsewhere(desk, operation),
    name === "wall" && button("Take the wall away", () => void desk.apply("wall", {}), { class: "wide" }),
    name === "region" && button("Forget the region", () => (desk.region.value = null), { class: "wide" }),
  );
}

// Buttons that do what the brush does to the selection or to everything.
function elsewhere(desk: Desk, operation: Operation): HTMLElement | null {
  if (!operation.knobs.some((knob) => knob.name === "on")) return null;
  const send = (on: string) => (): void => void desk.apply(operation.name, { ...desk.settings.params(operation), ...desk.ofLayer(operation), on });
  const onSelection = button("On the selection", send("selection"));
  desk.drawing.changed.on(() => (onSelection.disabled = !desk.drawing.state.value?.selected));
  onSelection.disabled = !desk.drawing.state.value?.selected;
  return el("div", { class: "row" }, onSelection, button("On all", send("all")));
}

function selection(desk: Desk): HTMLElement[] {
  const select = desk.operation("select");
  if (!select) return [];
  const count = el("p", { class: "count" });
  const needs: HTMLButtonElement[] = [];
  const act = (name: string, op: string, params: Params): HTMLButtonElement | null => {
    if (!desk.operation(op)) return null;
    const one = button(name, () => void desk.apply(op, params));
    needs.push(one);
    return one;
  };
  const by = (name: string, params: Params): HTMLButtonElement =>
    button(name, () => void desk.apply("select", { ...params, ...desk.ofLayer(select) }));
  const tone = el("details", {}, el("summary", {}, "By the tone beneath"), controls(desk, select, ["low", "high"]), button("Select", () => byTone(desk, select), { class: "wide" }));
  const all = [
    el("h2", {}, "Selection"),
    count,
    el("div", { class: "row" }, by("All", { by: "all" }), by("None", { by: "none" }), by("Invert", { by: "invert" })),
    tone,
    el("div", { class: "row" }, act("Erase", "erase", { on: "selection" }), act("Duplicate", "duplicate", {})),
    el("div", { class: "row" }, act("Freeze", "freeze", { on: "selection" }), act("Thaw", "freeze", { on: "selection", frozen: false })),
    el("div", { class: "row" }, act("Align to the flow", "turn", { on: "selection", by: "flow" })),
    exactly(desk),
  ];
  desk.drawing.changed.on(() => {
    const { selected = 0, marks = 0 } = desk.drawing.state.value ?? {};
    put(count, `${selected.toLocaleString("en")} of ${marks.toLocaleString("en")} selected`);
    for (const one of needs) one.disabled = !selected;
  });
  return all.filter((one): one is HTMLElement => one !== null);
}

function byTone(desk: Desk, select: Operation): void {
  const { low, high } = { low: desk.settings.get(select, "low"), high: desk.settings.get(select, "high") };
  void desk.apply("select", { by: "tone", low, high, ...desk.ofLayer(select) });
}

// Moving and turning by numbers.
function exactly(desk: Desk): HTMLElement | null {
  const move = desk.operation("move");
  return move ? el("details", {}, el("summary", {}, "Move and turn by numbers"), form(desk, move, "Move")) : null;
}
