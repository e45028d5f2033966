// What is seen: what lies beneath, cells, axes and flow over it, guides, and the page light or dark.

import type { Theme } from "./appearance";
import type { Desk } from "./desk";
import { el, unique } from "./dom";
import type { Under } from "./painting";
import type { LineKind } from "./protocol";
import { Watched } from "./watch";

const LINES: [LineKind, string][] = [
  ["cells", "Voronoi cells"],
  ["axes", "Axes"],
  ["flow", "Flow of the picture"],
];
const PAUSE = 300; // ms without a change, after which lines are computed again

export function viewPanel(desk: Desk, forget: (what: LineKind) => void): HTMLElement {
  const { appearance } = desk;
  return el(
    "div",
    { class: "panel" },
    el("h2", {}, "Beneath"),
    choice<Under>("Shown", appearance.under, [["picture", "picture"], ["tone", "tone"], ["importance", "importance"], ["none", "nothing"]]),
    slider("Opacity", appearance.opacity),
    el("h2", {}, "Over it"),
    ...LINES.map(([what, name]) => lines(desk, what, name, forget)),
    check("Edge, margin and canvas", appearance.guides),
    check("Rulers", appearance.rulers),
    el("h2", {}, "Page"),
    choice<Theme>("Colours", appearance.theme, [["system", "as the system"], ["light", "light"], ["dark", "dark"]]),
    check("Shortcuts of one character", appearance.keys),
  );
}

function choice<T extends string>(name: string, value: Watched<T>, options: [T, string][]): HTMLElement {
  const list = el("select", { id: unique("view"), change: () => (value.value = list.value as T) }, ...options.map(([key, text]) => el("option", { value: key }, text)));
  value.on((now) => (list.value = now));
  return el("div", { class: "knob" }, el("label", { for: list.id }, name), el("div", { class: "knob-inputs" }, list));
}

function slider(name: string, value: Watched<number>): HTMLElement {
  const input = el("input", { type: "range", id: unique("view"), min: 0, max: 1, step: 0.01, input: () => (value.value = input.valueAsNumber) });
  value.on((now) => (input.value = String(now)));
  return el("div", { class: "knob" }, el("label", { for: input.id }, name), el("div", { class: "knob-inputs" }, input));
}

function check(name: string, value: Watched<boolean>): HTMLElement {
  const box = el("input", { type: "checkbox", id: unique("view"), change: () => (value.value = box.checked) });
  value.on((now) => (box.checked = now));
  return el("div", { class: "knob knob-flag" }, box, el("label", { for: box.id }, name));
}

// Lines that the server computes when they are asked for, and again some time after each change.
function lines(desk: Desk, what: LineKind, name: string, forget: (what: LineKind) => void): HTMLElement {
  const on = new Watched(false);
  let revision = -1;
  let asking = false;
  let timer: ReturnType<typeof setTimeout> | undefined;
  const ask = async (): Promise<void> => {
    const state = desk.drawing.state.value;
    if (!on.value || asking || !state || state.revision === revision || (state.busy && !state.busy.paused)) return;
    asking = true;
    revision = state.revision;
    if (!(await desk.ask({ do: "show", what, ...(desk.layer.value === null ? {} : { layer: desk.layer.value }) }))) on.value = false;
    asking = false;
    if (!on.value) forget(what); // turned off meanwhile
  };
  const later = (): void => {
    clearTimeout(timer);
    timer = setTimeout(() => void ask(), PAUSE);
  };
  on.on((now) => {
    revision = -1;
    if (now) void ask();
    else forget(what);
  });
  desk.drawing.hello.on(() => (revision = -1)); // the painter has forgotten them
  desk.drawing.changed.on(later);
  return check(name, on);
}
