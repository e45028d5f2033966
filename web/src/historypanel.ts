// What was done, and what could be done again; a click goes there.

import type { Desk } from "./desk";
import { button, el } from "./dom";

export function historyPanel(desk: Desk): HTMLElement {
  const list = el("ol", { class: "history", "aria-label": "Changes, the latest first" });
  let told = "";
  desk.drawing.state.on((state) => {
    if (!state) return;
    const text = JSON.stringify([state.undo, state.redo]);
    if (text === told) return;
    told = text;
    const go = (request: "undo" | "redo", count: number): void => void desk.ask({ do: request, count });
    const redo = state.redo.map((name, k) => el("li", { class: "undone" }, button(name, () => go("redo", k + 1), { title: "Do again up to here" })));
    const undo = state.undo.map((name, k) =>
      el("li", {}, button(name, () => k && go("undo", k), { "aria-current": k === 0 ? "step" : null, title: k ? "Undo what came after" : "The latest" })),
    );
    const first = el("li", {}, button(state.undo.length < 50 ? "As it was opened" : "Further back", () => state.undo.length && go("undo", state.undo.length), { "aria-current": state.undo.length ? null : "step" }));
    list.replaceChildren(...redo.reverse(), ...undo, first);
  });
  return el("div", { class: "panel" }, el("h2", {}, "History"), list);
}
