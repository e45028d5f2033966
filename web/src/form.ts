// The knobs of an operation as a form, and a button that has it done.

import type { Desk } from "./desk";
import { button, el } from "./dom";
import { control, title } from "./knobs";
import type { Operation, Params } from "./protocol";
import { Settings } from "./settings";

// Controls for an operation's knobs, kept in step with the settings; `only` names those that are shown.
export function controls(desk: Desk, operation: Operation, only?: string[]): HTMLElement {
    const knobs = Settings.shown(operation).filter((knob) => !only || only.includes(knob.name));
  const made = knobs.map((knob) => {
    const value = desk.settings.get(operation, knob.name);
    return { name: knob.name, ...control(knob, value, (now) => desk.settings.set(operation, knob.name, now), desk.libraries) };
  });
  const element = el("div", { class: "knobs" }, ...made.map((one) => one.element));
  desk.settings.changed.on((name) => {
    if (!element.isConnected) return;
    for (const one of made) if (one.name === name && !one.element.contains(document.activeElement)) one.show(desk.settings.get(operation, name));
  });
  return element;
}

// A whole operation as a form: what it does, its knobs, and a button. `more` adds what is sent beside them.
export function form(desk: Desk, operation: Operation, verb = title(operation.name), more: () => Params = () => ({})): HTMLElement {
  const send = (): void => void desk.apply(operation.name, { ...desk.settings.params(operation), ...more() });
  return el("div", { class: "stack" }, el("p", { class: "help" }, operation.help), controls(desk, operation), button(verb, send, { class: "wide" }));
}
