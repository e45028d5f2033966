// Keyboard shortcuts, and the sheet that lists them.

import type { Desk } from "./desk";
import { dialog } from "./dialogs";
import { el } from "./dom";
import type { Watched } from "./watch";

export interface Shortcut {
  keys: string[]; // as pressed() says them
  about: string;
  run: (keys: string) => void;
  shown?: string; // how the sheet writes the keys
}

// What is pressed: modifiers in the order Ctrl, Alt, Shift, then the key. Cmd counts as Ctrl, and Shift only with letters and named keys.
export function pressed(event: KeyboardEvent): string {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const letter = /^[a-z]$/.test(key) || event.key.length > 1;
  const held = [(event.ctrlKey || event.metaKey) && "Ctrl", event.altKey && "Alt", event.shiftKey && letter && "Shift"];
  return [...held.filter(Boolean), key].join("+");
}

const TYPED = "input:not([type=checkbox]):not([type=radio]):not([type=range]), select, textarea";
let known = new Map<string, Shortcut>();
let single: Watched<boolean>;

// Listens for these shortcuts and no others, but not where something is being typed or a dialog is open, and for those that are one
// character alone only while that is wished for.
export function listen(shortcuts: Shortcut[], characters: Watched<boolean>): void {
  if (!known.size) window.addEventListener("keydown", hear);
  single = characters;
  known = new Map(shortcuts.flatMap((one) => one.keys.map((keys) => [keys, one] as const)));
}

function hear(event: KeyboardEvent): void {
  const keys = pressed(event);
  const found = known.get(keys);
  if (!found || (keys.length === 1 && !single.value) || event.defaultPrevented || document.querySelector("dialog[open]")) return;
  if (event.target instanceof Element && event.target.matches(TYPED)) return;
  event.preventDefault();
  found.run(keys);
}

const POINTERS: [string, string][] = [
  ["Wheel", "Pan; with Ctrl, or two fingers, zoom"],
  ["Space and drag", "Pan; so does the middle button"],
  ["Alt and a brush", "The other way round: smaller, turned back, thawed"],
  ["Shift, Alt and a selection", "Add to it, take from it"],
  ["Arrows on the canvas", "Move the pointer by 1 mm, with Shift by 10"],
  ["Enter on the canvas", "Press the tool where the pointer is"],
];

export function helpDialog(desk: Desk, shortcuts: Shortcut[]): void {
  const keys = shortcuts.map((one) => [one.shown ?? one.keys.slice(0, 2).map(written).join(" or "), one.about] as const);
  const half = Math.ceil(keys.length / 2 + POINTERS.length / 2);
  const version = el("p", { class: "help" }, `crowquill ${desk.drawing.hello.value?.version ?? ""}`);
  const second = el("div", { class: "stack" }, table("More keys", keys.slice(half)), table("Pointer and pen", POINTERS), version);
  dialog("Keys", el("div", { class: "help-sheet" }, table("Keys", keys.slice(0, half)), second)).classList.add("wide-dialog");
}

function table(name: string, rows: readonly (readonly [string, string])[]): HTMLElement {
  const lines = rows.map(([keys, about]) => el("tr", {}, el("th", { scope: "row" }, el("kbd", {}, keys)), el("td", {}, about)));
  return el("table", {}, el("caption", {}, name), el("tbody", {}, ...lines));
}

function written(keys: string): string {
  return keys.split(/\+(?=.)/).map((key) => (key.length === 1 ? key.toUpperCase() : key)).join(" ");
}
