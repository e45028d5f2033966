// Layers from the top down: which is worked on, what is seen and may change, inks and pens, and their order.

import type { Desk } from "./desk";
import { button, el, iconButton, unique } from "./dom";
import { ICONS } from "./icons";
import { COMMON } from "./inks";
import { paperSection } from "./paperpanel";
import type { Layer, Params } from "./protocol";

export function layersPanel(desk: Desk): HTMLElement {
  const list = el("ul", { class: "layers", "aria-label": "Layers, the topmost first" });
  const edit = el("section", { class: "section stack", "aria-label": "The layer worked on" });
  const every = el("input", { type: "radio", name: "layer", id: unique("layer"), checked: true, change: () => (desk.layer.value = null) });
  const add = iconButton(ICONS.add!, "Add a layer", () => void desk.apply("layer add", {}));
  let told = "";
  const typing = (): boolean => edit.contains(document.activeElement) && document.activeElement instanceof HTMLInputElement;
  const show = (): void => {
    const state = desk.drawing.state.value;
    if (!state) return;
    if (desk.layer.value !== null && !state.layers.some((layer) => layer.id === desk.layer.value)) desk.layer.value = null;
    const text = JSON.stringify([state.layers, desk.layer.value, state.selected > 0]);
    if (text === told) return;
    told = text;
    const focused = document.activeElement instanceof HTMLElement ? document.activeElement.dataset.focus : undefined;
    every.checked = desk.layer.value === null;
    list.replaceChildren(...state.layers.map((layer, place) => row(desk, layer, place, state.layers.length)).reverse());
    const layer = state.layers.find((one) => one.id === desk.layer.value);
    if (typing()) told = ""; // once that ends
    else refill(edit, layer ? editing(desk, layer, state.selected) : []);
    edit.hidden = !layer;
    if (focused) list.querySelector<HTMLElement>(`[data-focus="${focused}"]`)?.focus();
  };
  edit.addEventListener("focusout", () => setTimeout(() => edit.matches(":active") || show())); // not under a finger: its click would be lost
  desk.drawing.state.on(show);
  desk.layer.on(show);
  const all = el("div", { class: "layer layer-all" }, every, el("label", { for: every.id }, "Work on all layers"), add);
  return el("div", { class: "panel" }, el("h2", {}, "Layers"), all, list, edit, paperSection(desk));
}

// Gives an element other children; the focus stays on the one in its place.
function refill(element: HTMLElement, children: HTMLElement[]): void {
  const all = (): HTMLElement[] => [...element.querySelectorAll<HTMLElement>("input, select, button")];
  const at = all().indexOf(document.activeElement as HTMLElement);
  element.replaceChildren(...children);
  all()[at]?.focus();
}

function change(desk: Desk, layer: Layer, params: Params): void {
  void desk.apply("layer edit", { layer: layer.id, ...params });
}

function row(desk: Desk, layer: Layer, place: number, count: number): HTMLElement {
  const id = unique("layer");
  const focus = (what: string): object => ({ "data-focus": `${layer.id} ${what}` });
  const radio = el("input", { type: "radio", name: "layer", id, checked: desk.layer.value === layer.id, change: () => (desk.layer.value = layer.id), ...focus("radio") });
  const swatch = el("span", { class: "swatch" });
  swatch.style.background = `rgb(${layer.rgb.join(" ")})`;
  const toggle = (what: "hidden" | "locked", on: string, off: string): HTMLElement => {
    const name = `${what === "hidden" ? "Hide" : "Lock"} ${layer.name}`;
    const click = (): void => change(desk, layer, { [what]: !layer[what] });
    return iconButton(ICONS[layer[what] ? on : off]!, name, click, { "aria-pressed": String(layer[what]), ...focus(what) });
  };
  const order = (name: string, icon: string, to: number): HTMLElement =>
    iconButton(ICONS[icon]!, `${name} ${layer.name}`, () => void desk.apply("layer order", { layer: layer.id, to }), { disabled: to < 0 || to >= count, ...focus(icon) });
  return el(
    "li",
    { class: layer.hidden ? "layer layer-hidden" : "layer" },
    radio,
    swatch,
    el("label", { for: id }, layer.name || `Layer ${layer.id}`, el("small", {}, layer.items.toLocaleString("en"))),
    order("Raise", "up", place + 1),
    order("Lower", "down", place - 1),
    toggle("locked", "locked", "open"),
    toggle("hidden", "hidden", "shown"),
  );
}

function editing(desk: Desk, layer: Layer, selected: number): HTMLElement[] {
  const name = field("Name", el("input", { type: "text", value: layer.name, change: (event: Event) => change(desk, layer, { name: value(event) }) }));
  const take = button("Bring the selection here", () => void desk.apply("layer take", { layer: layer.id }), { class: "wide", disabled: !selected });
  const select = button("Select all of it", () => void desk.apply("select", { by: "layer", layer: layer.id }), { class: "wide" });
  return [
    el("h3", {}, layer.name || `Layer ${layer.id}`),
    name,
    ...(layer.kind === "still" ? [] : [...inking(desk, layer), take, select]),
    button("Remove the layer", () => void desk.apply("layer remove", { layer: layer.id }), { class: "wide" }),
  ];
}

// The ink of a layer: of the four process inks or a spot ink by name, as a fill or a pen.
function inking(desk: Desk, layer: Layer): HTMLElement[] {
  const now = (): Layer => desk.drawing.state.value?.layers.find((one) => one.id === layer.id) ?? layer; // fields may be older
  const mix = (cmyk: number[]): void => change(desk, layer, { cmyk, ...(now().spot ? { spot: now().ink } : {}) }); // alone it makes a process ink
  const pen = el("input", { type: "number", min: 0, max: 50, step: "any", value: layer.pen ?? 0, change: (event: Event) => change(desk, layer, { pen: Number(value(event)) }) });
  const kind = el(
    "select",
    { change: () => (kind.value === "spot" ? (spot.hidden = false) : change(desk, layer, { spot: "" })) },
    el("option", { value: "process", selected: !layer.spot }, "process"),
    el("option", { value: "spot", selected: layer.spot }, "spot"),
  );
  const spot = field("Spot name", el("input", {
    type: "text", value: layer.spot ? layer.ink : "", placeholder: "as in the swatch book", spellcheck: "false",
    change: (event: Event) => change(desk, layer, { spot: value(event) }),
  }));
  spot.hidden = !layer.spot;
  const shares = layer.cmyk.map((share, k) =>
    el("input", {
      type: "number", min: 0, max: 100, step: 1, value: Math.round(share * 100), "aria-label": `${["Cyan", "Magenta", "Yellow", "Black"][k]}, per cent`,
      change: (event: Event) => mix(now().cmyk.map((was, j) => (j === k ? Number(value(event)) / 100 : was))),
    }),
  );
  const inks = COMMON.map(([title, cmyk]) => button(title, () => mix(cmyk)));
  return [
    field("Pen", pen, el("span", { class: "unit" }, "mm; 0 fills")),
    field("Ink", kind),
    spot,
    el("div", { class: "knob" }, el("span", {}, layer.spot ? "Looks like" : "C M Y K"), el("div", { class: "knob-inputs cmyk" }, ...shares)),
    el("div", { class: "row chips" }, ...inks),
  ];
}

function field(name: string, input: HTMLInputElement | HTMLSelectElement, ...more: HTMLElement[]): HTMLElement {
  input.id = unique("field");
  return el("div", { class: "knob" }, el("label", { for: input.id }, name), el("div", { class: "knob-inputs" }, input, ...more));
}

function value(event: Event): string {
  return (event.target as HTMLInputElement).value;
}
