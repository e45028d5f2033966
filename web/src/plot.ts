// A small plot of one number over the steps of a relaxation.

import { el } from "./dom";

const WIDE = 256;
const HIGH = 56;
const EDGE = 4;

export class Plot {
  readonly element: HTMLElement;
  private readonly line = document.createElementNS("http://www.w3.org/2000/svg", "polyline");
  private readonly now = el("span", { class: "plot-now" });
  private readonly values: [number, number][] = [];

  constructor(readonly name: string) {
    const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    svg.setAttribute("viewBox", `0 0 ${WIDE} ${HIGH}`);
    svg.setAttribute("aria-hidden", "true");
    svg.append(this.line);
    this.element = el("figure", { class: "plot" }, el("figcaption", {}, el("span", {}, name), this.now), svg);
  }

  clear(): void {
    this.values.length = 0;
    this.draw();
  }

  add(step: number, value: number): void {
    if (!Number.isFinite(value)) return;
    this.values.push([step, value]);
    if (this.values.length > 2000) this.values.splice(0, this.values.length, ...this.values.filter((_, k) => k % 2));
    this.draw();
  }

  private draw(): void {
    const { values } = this;
    const [first, last] = [values[0]?.[0] ?? 0, values[values.length - 1]?.[0] ?? 1];
    const low = Math.min(...values.map(([, value]) => value));
    const high = Math.max(...values.map(([, value]) => value));
    const x = (step: number): number => EDGE + ((step - first) / Math.max(last - first, 1)) * (WIDE - 2 * EDGE);
    const y = (value: number): number => HIGH - EDGE - ((value - low) / (high - low || 1)) * (HIGH - 2 * EDGE);
    this.line.setAttribute("points", values.map(([step, value]) => `${x(step).toFixed(1)},${y(value).toFixed(1)}`).join(" "));
    this.now.textContent = values.length ? Number(values[values.length - 1]![1].toPrecision(4)).toString() : "";
  }
}
