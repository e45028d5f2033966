// Controls made from knobs, the same for brushes, styles, formats and all else that the server can do.

import { el, unique } from "./dom";
import type { Kind, Knob, KnobValue, Libraries } from "./protocol";

export interface Control {
  element: HTMLElement;
  show: (value: KnobValue) => void;
}

const STEPS = 1000; // of a slider
const WIDE = 15; // a range over its usual number from which a slider is finer about 0
const LARGE = 1e5; // numbers up to this fit into a short field
const LONG = 100; // mm at a slider's end; longer ones are typed in

// A labelled control for a knob; `change` is called with every value that is right. Nothing typed in means the knob's own default.
export function control(knob: Knob, value: KnobValue, change: (value: KnobValue) => void, libraries: Libraries = {}): Control {
  if (knob.name === "glyph") return glyphControl(knob, value, change, libraries);
  if (knob.kind === "flag") return flag(knob, value, change);
  if (knob.kind === "choice") return choice(knob, value, change);
  if (knob.kind === "range") return range(knob, value, change);
  return words(knob, value, change);
}

const WRITTEN: Record<string, string> = { pdfx: "PDF/X", pdfa: "PDF/A", icc: "ICC profile", dpi: "DPI" };

const KNOWN: Record<string, string[]> = { paper: ["a4", "a5", "letter"] }; // names that are proposed, beside which others are right

export function title(name: string): string {
  if (WRITTEN[name]) return WRITTEN[name];
  const words = name.replace(/_/g, " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

function labelled(knob: Knob, id: string, ...inputs: (HTMLElement | null)[]): HTMLElement {
  const name = el("label", { for: id, title: knob.help }, title(knob.name));
  return el("div", { class: "knob" }, name, el("div", { class: "knob-inputs" }, ...inputs));
}

function flag(knob: Knob, value: KnobValue, change: (value: KnobValue) => void): Control {
  const id = unique("knob");
  const box = el("input", { type: "checkbox", id, change: () => change(box.checked) });
  const element = el("div", { class: "knob knob-flag" }, box, el("label", { for: id, title: knob.help }, title(knob.name)));
  return shown(element, value, (now) => (box.checked = now === true));
}

function choice(knob: Knob, value: KnobValue, change: (value: KnobValue) => void): Control {
  const id = unique("knob");
  const names = knob.names ?? [];
  const open = knob.default === null ? [el("option", { value: "" }, "automatic")] : [];
  const list = el("select", { id, title: knob.help, change: () => change(list.value || null) }, ...open, ...names.map((name) => el("option", { value: name }, name)));
  return shown(labelled(knob, id, list), value, (now) => (list.value = now === null ? "" : String(now)));
}

function range(knob: Knob, value: KnobValue, change: (value: KnobValue) => void): Control {
  const id = unique("knob");
  const [low, high] = [knob.low ?? 0, knob.high ?? 1];
  const scale = sliding(low, high, typeof knob.default === "number" ? knob.default : null, knob.unit);
  const step = knob.whole ? 1 : "any";
  const number = el("input", { type: "number", id, class: high >= LARGE ? "long" : null, min: low, max: high, step, title: knob.help, placeholder: knob.default === null ? "auto" : null });
  const slider = el("input", { type: "range", min: 0, max: STEPS, tabindex: -1, "aria-hidden": "true", title: knob.help });
  const say = (now: number): void => {
    number.setCustomValidity("");
    change(now);
  };
  number.addEventListener("input", () => {
    if (number.value === "" && !number.validity.badInput) return change(knob.default);
    if (!number.validity.valid) return;
    slider.value = String(scale.to(number.valueAsNumber) * STEPS);
    say(number.valueAsNumber);
  });
  slider.addEventListener("input", () => {
    const now = neat(scale.from(Number(slider.value) / STEPS), knob.whole ?? false);
    number.value = String(now);
    say(now);
  });
  const unit = knob.unit ? el("span", { class: "unit" }, knob.unit === "deg" ? "°" : knob.unit) : null;
  return shown(labelled(knob, id, slider, number, unit), value, (now) => {
    if (document.activeElement !== number) number.value = typeof now === "number" ? String(now) : "";
    slider.value = String(scale.to(typeof now === "number" ? now : low) * STEPS);
  });
}

// How a slider runs: evenly, or where the range is wide beside what is usual in it, finer about 0.
function sliding(low: number, high: number, first: number | null, unit?: string): { to: (value: number) => number; from: (part: number) => number } {
  const usual = Math.max(Math.abs(first ?? 0), low, 1e-6);
  if (high <= 1 || (high - low) / usual < WIDE) return { to: (value) => (value - low) / (high - low), from: (part) => low + part * (high - low) };
  const top = unit === "mm" ? Math.min(high, LONG) : high;
  const bend = Math.max(1e-3, Math.min(first ? Math.abs(first) : top, top / 5) / 3);
  const [start, end] = [Math.asinh(low / bend), Math.asinh(top / bend)];
  return {
    to: (value) => Math.min(1, (Math.asinh(value / bend) - start) / (end - start)),
    from: (part) => bend * Math.sinh(start + part * (end - start)),
  };
}

function neat(value: number, whole: boolean): number {
  return whole ? Math.round(value) : Math.abs(value) < 1e-3 ? 0 : Number(value.toPrecision(2));
}

function words(knob: Knob, value: KnobValue, change: (value: KnobValue) => void): Control {
  const id = unique("knob");
  const several = knob.kind === "numbers";
  const known = KNOWN[knob.name]?.map((text) => el("option", { value: text })) ?? [];
  const list = known.length ? el("datalist", { id: unique("known") }, ...known) : null;
  const field = el("input", { type: "text", id, title: knob.help, spellcheck: "false", placeholder: knob.default === null ? "auto" : null, list: list?.id });
  field.addEventListener("change", () => {
    const text = field.value.trim();
    const numbers = text.split(/[\s,;]+/).map(Number);
    const wrong = several && text !== "" && (numbers.some(Number.isNaN) || (knob.count != null && numbers.length !== knob.count));
    field.setCustomValidity(wrong ? `${knob.count ?? "Some"} numbers, parted by commas` : "");
    if (wrong) field.reportValidity();
    else change(text === "" ? knob.default : several ? numbers : text);
  });
  return shown(labelled(knob, id, field, list), value, (now) => (field.value = now === null ? "" : Array.isArray(now) ? now.join(", ") : String(now)));
}

// A choice among libraries with their shapes beneath, to take one of them alone.
function glyphControl(knob: Knob, value: KnobValue, change: (value: KnobValue) => void, libraries: Libraries): Control {
  const id = unique("knob");
  const open = knob.default === null ? [el("option", { value: "" }, "as the layer has")] : [];
  const list = el("select", { id, title: knob.help }, ...open, ...Object.keys(libraries).map((name) => el("option", { value: name }, name)));
  const shapes = el("div", { class: "shapes", role: "group", "aria-label": "Shapes of the library" });
  const show = (now: KnobValue): void => {
    const [book = "", number] = typeof now === "string" ? now.split("/") : [];
    list.value = book;
    shapes.replaceChildren(...(libraries[book] ?? []).map((kind, k) => shape(book, k, kind, String(k) === number)));
    shapes.hidden = !book;
  };
  const shape = (book: string, k: number, kind: Kind, pressed: boolean): HTMLElement => {
    const click = (): void => {
      const now = pressed ? book : `${book}/${k}`;
      change(now);
      show(now);
      (shapes.children[k] as HTMLElement | undefined)?.focus();
    };
    return el("button", { type: "button", "aria-pressed": String(pressed), "aria-label": `${book} ${k}`, click }, picture(kind));
  };
  list.addEventListener("change", () => {
    change(list.value || null);
    show(list.value || null);
  });
  const element = el("div", {}, labelled(knob, id, list), shapes);
  return shown(element, value, show);
}

function picture(kind: Kind): SVGSVGElement {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  svg.setAttribute("viewBox", [-1, -1, 2, 2].map((k) => 1000 * k * kind.reach).join(" "));
  svg.classList.toggle("lines", !kind.closed);
  svg.setAttribute("aria-hidden", "true");
  path.setAttribute("d", kind.d);
  svg.append(path);
  return svg;
}

function shown(element: HTMLElement, value: KnobValue, show: (value: KnobValue) => void): Control {
  show(value);
  return { element, show };
}
