// What the page says: a line at the foot of the canvas for a while, and to screen readers.

import { byId, el } from "./dom";

const SHOWN = 6000; // ms; errors twice as long

export class Messages {
  private readonly list = byId("messages");

  note(text: string): void {
    this.show(text, "note", SHOWN);
  }

  error(text: string): void {
    this.show(text, "error", 2 * SHOWN);
  }

  private show(text: string, kind: string, time: number): void {
    for (const other of [...this.list.children]) if (other.textContent === text || this.list.children.length > 3) other.remove();
    const line = el("p", { class: kind }, text);
    line.addEventListener("click", () => line.remove());
    this.list.append(line);
    setTimeout(() => line.remove(), time);
  }
}
