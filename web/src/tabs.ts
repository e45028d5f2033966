// The inspector's tabs and the panels that belong to them.

import { byId, el, unique } from "./dom";
import { walk } from "./rail";

export interface Tab {
  name: string;
  panel: HTMLElement;
}

// Lays tabs and panels out; gives a function that shows one by its name.
export function tabs(all: Tab[]): (name: string) => void {
  const [list, body] = [byId("tabs"), byId("panels")];
  const buttons = all.map(({ name, panel }) => {
    const [id, panelId] = [unique("tab"), unique("panel")];
    for (const [key, value] of Object.entries({ id: panelId, role: "tabpanel", "aria-labelledby": id })) panel.setAttribute(key, value);
    return el("button", { type: "button", role: "tab", id, "aria-controls": panelId, click: () => show(name) }, name);
  });
  const show = (name: string): void => {
    all.forEach((tab, k) => {
      const chosen = tab.name === name;
      tab.panel.hidden = !chosen;
      buttons[k]!.setAttribute("aria-selected", String(chosen));
      buttons[k]!.tabIndex = chosen ? 0 : -1;
    });
  };
  list.addEventListener("keydown", (event) => {
    walk(event, buttons);
    if (document.activeElement !== event.target) (document.activeElement as HTMLElement).click();
  });
  list.replaceChildren(...buttons);
  body.replaceChildren(...all.map((tab) => tab.panel));
  show(all[0]!.name);
  return show;
}
