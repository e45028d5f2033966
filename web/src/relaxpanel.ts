// Relaxation: a step or many of any variant, play and pause, and how energy and movement go down.

import type { Desk } from "./desk";
import { button, el, icon, set, unique } from "./dom";
import { controls, form } from "./form";
import { ICONS } from "./icons";
import { Plot } from "./plot";
import type { Operation } from "./protocol";

const SHOWN = ["energy", "movement", "turning"];

export function relaxPanel(desk: Desk): HTMLElement {
  const panel = el("div", { class: "panel" });
  desk.drawing.begun((hello) => {
    const relax = desk.operation("relax");
    const others = hello.operations.filter((one) => one.group === "relax" && one !== relax);
    panel.replaceChildren(...(relax ? relaxation(desk, relax) : []), ...others.map((one) => mosaic(desk, one)));
  });
  return panel;
}

// Another operation beside relaxation: laying tiles, cutting them.
function mosaic(desk: Desk, operation: Operation): HTMLElement {
  const region = (): { path?: number[] } => {
    const path = operation.knobs.some((knob) => knob.name === "path") ? desk.region.value : null;
    return path ? { path } : {};
  };
  const inside = form(desk, operation, undefined, () => ({ ...region(), ...desk.ofLayer(operation) }));
  return el("details", { class: "section" }, el("summary", {}, operation.name === "tile" ? "Lay tiles" : operation.name === "cut" ? "Cut stones" : operation.name), inside);
}

function relaxation(desk: Desk, relax: Operation): HTMLElement[] {
  const on = el("select", { id: unique("on") }, ...["all", "selection"].map((name) => el("option", { value: name }, name)));
  const count = el("input", { type: "number", id: unique("steps"), min: 1, max: 10000, step: 1, value: 10 });
  const plots = SHOWN.map((name) => new Plot(name));
  const stage = el("p", { class: "count", role: "status" });
  const begin = (times: number): void => {
    if (times > 1 || !times) for (const plot of plots) plot.clear();
    const params = { ...desk.settings.params(relax), ...desk.ofLayer(relax), on: on.value };
    void desk.apply(relax.name, params, { times }).then((done) => {
      if (done) stage.textContent = done.stopped ? "Stopped" : "";
    });
  };
  const many = (): void => void (count.reportValidity() && begin(count.valueAsNumber));
  const play = iconed("Play", "play", () => {
    const { busy } = desk.drawing.state.value ?? {};
    if (!busy) begin(0);
    else void desk.ask({ do: busy.paused ? "resume" : "pause" });
  });
  const stop = iconed("Stop", "stop", () => void desk.ask({ do: "stop" }));
  const cancel = iconed("Undo it", "cancel", () => void desk.ask({ do: "cancel" }));
  const one = button("1 step", () => begin(1));
  const some = button("steps", many);
  desk.drawing.steps.on((step) => {
    if (step.stage === "recover") return;
    stage.textContent = `${step.stage} ${step.done}${step.total ? ` of ${step.total}` : ""}`;
    for (const plot of plots) {
      const value = step.facts[plot.name];
      if (value !== undefined) plot.add(step.done, value);
      plot.element.hidden = value === undefined && plot.name === "turning";
    }
  });
  desk.drawing.state.on((state) => {
    const busy = state?.busy ?? null;
    const running = busy !== null && !busy.paused;
    const words = running ? "Pause" : busy ? "Go on" : "Play";
    if (play.getAttribute("aria-label") !== words || !play.childNodes.length) {
      set(play, { "aria-label": words });
      play.replaceChildren(icon(running ? ICONS.pause! : ICONS.play!), words);
    }
    stop.disabled = cancel.disabled = !busy;
    one.disabled = some.disabled = busy !== null;
    for (const option of on.options) if (option.value === "selection") option.disabled = !state?.selected;
    if (!state?.selected) on.value = "all";
  });
  return [
    el("h2", {}, "Relaxation"),
    el("p", { class: "help" }, relax.help),
    controls(desk, relax, ["variant"]),
    el("div", { class: "knob" }, el("label", { for: on.id }, "On"), el("div", { class: "knob-inputs" }, on)),
    el("div", { class: "row" }, play, stop, cancel),
    el("div", { class: "row" }, one, el("span", { class: "joined" }, el("label", { for: count.id, class: "unseen" }, "Number of steps"), count, some)),
    stage,
    ...plots.map((plot) => plot.element),
    el("details", {}, el("summary", {}, "Finer settings"), controls(desk, relax, names(relax))),
  ];
}

function names(relax: Operation): string[] {
  return relax.knobs.map((knob) => knob.name).filter((name) => !["variant", "size", "strength", "falloff"].includes(name));
}

function iconed(name: string, which: string, click: () => void): HTMLButtonElement {
  return el("button", { type: "button", click, "aria-label": name }, icon(ICONS[which]!), name);
}
