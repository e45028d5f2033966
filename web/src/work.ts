// What is under way, over the canvas: how far it is, and how to end it. Work that is done in a moment is not shown.

import type { Desk } from "./desk";
import { button, byId, el } from "./dom";
import { title } from "./knobs";

const SOON = 400; // ms of work after which it is shown

export function work(desk: Desk): void {
  const bar = byId("work");
  const text = el("span", {});
  const progress = el("progress", { "aria-label": "Progress" });
  const pause = button("Pause", () => void desk.ask({ do: desk.drawing.state.value?.busy?.paused ? "resume" : "pause" }));
  const end = button("Cancel", () => void desk.ask({ do: desk.drawing.state.value?.busy?.single ? "cancel" : "stop" }));
  const wait = el("small", {}, "Brushes wait until it is done.");
  bar.append(el("div", {}, text, wait), progress, pause, end);
  let timer: ReturnType<typeof setTimeout> | undefined;
  let shown: number | null = null; // the work's number
  const name = (op: string): string => title(op.replace(/^redraw /, ""));
  desk.drawing.state.on((state) => {
    const busy = state?.busy ?? null;
    if ((busy?.n ?? null) !== shown) {
      clearTimeout(timer);
      bar.hidden = true;
      shown = busy?.n ?? null;
      progress.removeAttribute("value");
      if (busy) {
        text.textContent = name(busy.op);
        timer = setTimeout(() => (bar.hidden = false), SOON);
      }
    }
    if (!busy) return;
    pause.textContent = busy.paused ? "Go on" : "Pause";
    end.textContent = busy.single ? "Cancel" : "Stop";
    wait.hidden = !busy.single;
  });
  desk.drawing.steps.on((step) => {
    const busy = desk.drawing.state.value?.busy;
    if (!busy || step.n !== busy.n) return;
    const count = step.total ? `${step.done} of ${step.total}` : `${step.done}`;
    text.textContent = `${name(busy.op)}${step.stage === busy.op ? "" : `: ${step.stage}`} ${count}`;
    if (step.total) progress.value = step.done / step.total;
    else progress.removeAttribute("value");
  });
}
