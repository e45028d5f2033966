// Writing the drawing into the folder, and looking it over as a printer would.

import type { Desk } from "./desk";
import { dialog } from "./dialogs";
import { button, el, unique } from "./dom";
import { control } from "./knobs";
import type { Finding, Hello, Knob, KnobValue } from "./protocol";

const CHECKED = /\.(pdf|svg)$/;
const FIRST = ["svg", "pdf"]; // formats that are chosen at first

export function exportDialog(desk: Desk): void {
  const hello = desk.drawing.hello.value;
  if (!hello) return;
  const name = el("input", { type: "text", id: unique("export"), value: `${hello.name.replace(/\.[^.]*$/, "")}-edited`, required: true, spellcheck: "false" });
  const options = new Map<string, KnobValue>();
  const knobs = el("div", { class: "knobs" });
  const formats = Object.keys(hello.formats).map((format) => {
    const box = el("input", { type: "checkbox", id: unique("format"), value: format, checked: FIRST.includes(format), change: () => show() });
    return { format, box, element: el("span", { class: "chip" }, box, el("label", { for: box.id }, format)) };
  });
  const chosen = (): string[] => formats.filter((one) => one.box.checked).map((one) => one.format);
  const show = (): void => knobs.replaceChildren(...shared(hello, chosen()).map((knob) => control(knob, options.get(knob.name) ?? knob.default, (now) => options.set(knob.name, now)).element));
  const over = el("input", { type: "checkbox", id: unique("over") });
  const results = el("div", { "aria-live": "polite" });
  const write = button("Export", () => void run(), { class: "wide primary" });
  const run = async (): Promise<void> => {
    if (!name.reportValidity() || !chosen().length) return;
    const known = new Set(shared(hello, chosen()).map((knob) => knob.name));
    const given = Object.fromEntries([...options].filter(([key, value]) => known.has(key) && value !== null));
    const files = chosen().map((format) => `${name.value}.${format}`);
    const done = await meanwhile(write, "Writing…", ask(desk, results, { do: "export", files, options: given, overwrite: over.checked }));
    if (done) results.replaceChildren(...(done.files ?? []).map((file) => written(desk, file)));
  };
  show();
  dialog(
    "Export",
    el("div", { class: "knob" }, el("label", { for: name.id }, "Name"), el("div", { class: "knob-inputs" }, name)),
    el("div", { class: "row chips", role: "group", "aria-label": "Formats" }, ...formats.map((one) => one.element)),
    el("details", {}, el("summary", {}, "Options of these formats"), knobs),
    el("div", { class: "knob knob-flag" }, over, el("label", { for: over.id }, "Replace files that are there")),
    write,
    results,
  );
}

// The knobs of some formats, each once.
function shared(hello: Hello, formats: string[]): Knob[] {
  const found = new Map<string, Knob>();
  for (const format of formats) for (const knob of hello.formats[format] ?? []) if (!found.has(knob.name)) found.set(knob.name, knob);
  return [...found.values()];
}

// What a promise gives; until then a button says so, and cannot be pressed.
async function meanwhile<T>(one: HTMLButtonElement, words: string, promise: Promise<T>): Promise<T> {
  const name = one.textContent;
  one.disabled = true;
  one.textContent = words;
  const found = await promise;
  one.disabled = false;
  one.textContent = name;
  return found;
}

// A request whose error is said in the dialog, where it is read.
async function ask(desk: Desk, where: HTMLElement, request: { do: string; [key: string]: unknown }) {
  try {
    return (await desk.link.ask(request)).facts;
  } catch (error) {
    where.replaceChildren(el("p", { class: "error" }, (error as Error).message));
    return null;
  }
}

function written(desk: Desk, file: string): HTMLElement {
  const findings = el("div", {});
  const check = async (): Promise<void> => {
    const facts = await meanwhile(checking!, "Checking…", ask(desk, findings, { do: "check", file }));
    if (facts) findings.replaceChildren(list(facts.findings ?? []));
  };
  const checking = CHECKED.test(file) ? button("Preflight", () => void check()) : null;
  return el("div", { class: "written" }, el("p", {}, el("strong", {}, file), " is written"), checking, findings);
}

function list(findings: Finding[]): HTMLElement {
  if (!findings.length) return el("p", {}, "Nothing stands between it and the press.");
  return el("ul", { class: "findings" }, ...findings.map((one) => el("li", { class: one.severity }, el("strong", {}, one.severity), ` ${one.message} `, el("small", {}, one.where))));
}
