// Dialogs: a heading, a way out, and the focus back where it was.

import { el, iconButton, unique } from "./dom";
import { ICONS } from "./icons";

// An open dialog with this heading and content; it is gone once it is closed.
export function dialog(heading: string, ...content: HTMLElement[]): HTMLDialogElement {
  const id = unique("dialog");
  const close = (): void => element.close();
  const head = el("header", {}, el("h2", { id }, heading), iconButton(ICONS.cancel!, "Close", close));
  const element = el("dialog", { "aria-labelledby": id }, head, el("div", { class: "dialog-body" }, ...content));
  const before = document.activeElement;
  element.addEventListener("close", () => {
    element.remove();
    if (before instanceof HTMLElement) before.focus();
  });
  element.addEventListener("click", (event) => event.target === element && close()); // beside it
  document.body.append(element);
  element.showModal();
  return element;
}
