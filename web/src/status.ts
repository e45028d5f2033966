// The line at the foot of the canvas, the state of saving, and the banner when the line is broken.

import type { Desk } from "./desk";
import { byId, put, set } from "./dom";
import type { Line } from "./link";

const LINES: Record<Exclude<Line, "ended">, string> = {
  connecting: "",
  open: "",
  broken: "The connection broke. Nothing is lost; connecting again…",
};

export class Status {
  private readonly zoom = byId<HTMLButtonElement>("zoom");
  private readonly place = byId("place");

  constructor(private readonly desk: Desk) {
    const { drawing, viewport, link } = desk;
    viewport.changed.on(() => this.scale());
    drawing.changed.on(() => {
      const { marks = 0, selected = 0 } = drawing.state.value ?? {};
      put(byId("count"), `${marks.toLocaleString("en")} marks${selected ? `, ${selected.toLocaleString("en")} selected` : ""}`);
    });
    drawing.hello.on((hello) => {
      if (!hello) return;
      byId("name").textContent = hello.name;
      document.title = `${hello.name} · crowquill`;
    });
    const saved = byId("saved");
    drawing.saved.on((now) => {
      saved.textContent = !now || now.ok ? "Every change is saved" : now.text || `${now.waiting} changes are not saved yet`;
      set(saved, { "data-ok": String(now?.ok ?? true), role: now?.ok === false ? "alert" : "status" });
    });
    drawing.tabs.on((count) => {
      byId("tab-count").textContent = count > 1 ? `Open in ${count} tabs` : "";
    });
    link.line.on((line) => {
      this.banner(this.lineText(line));
      set(byId("app"), { "data-line": line });
    });
    drawing.steps.on((step) => {
      if (step.stage === "recover") this.banner(`Doing again what was done: ${step.done} of ${step.total} changes`);
    });
    drawing.state.on((state) => state && this.banner(this.lineText(link.line.value)));
  }

  // Says where the pointer is, mm; null: it is elsewhere.
  point(place: [number, number] | null): void {
    const px = this.desk.viewport.scale;
    const digits = Math.max(1, Math.min(3, Math.ceil(Math.log10(px))));
    this.place.textContent = place ? `${place[0].toFixed(digits)}, ${place[1].toFixed(digits)} mm` : "";
  }

  private lineText(line: Line): string {
    return line === "ended" ? this.desk.link.wire.ended : LINES[line];
  }

  private banner(text: string): void {
    const banner = byId("banner");
    if (banner.textContent !== text) banner.textContent = text;
    banner.hidden = !text;
  }

  private scale(): void {
    const { scale, ratio } = this.desk.viewport;
    const percent = ((scale / ratio) * 25.4 * 100) / 96; // 96 px of the page are an inch
    this.zoom.textContent = `${percent < 10 ? percent.toPrecision(2) : Math.round(percent).toLocaleString("en")} %`;
  }
}
