// The rail of tools: one tab stop, arrow keys within.

import type { Desk } from "./desk";
import { byId, el, iconButton } from "./dom";
import { ICONS } from "./icons";
import type { Tool } from "./tools";

const FIRST = "insert"; // the tool in hand at first

export function rail(desk: Desk): void {
  const bar = byId("rail");
  let buttons = new Map<string, HTMLButtonElement>();
  desk.tools.on((every) => {
    buttons = new Map(every.map((tool) => [tool.name, made(desk, tool)]));
    const parts = ["look", "select", "brush", "outline"] as const;
    const groups = parts.map((part) => el("div", { class: "rail-part" }, ...every.filter((tool) => tool.part === part).map((tool) => buttons.get(tool.name)!)));
    bar.replaceChildren(...groups.filter((group) => group.children.length));
    desk.tool.value = every.find((tool) => tool.name === (desk.tool.value?.name ?? FIRST)) ?? every[0] ?? null;
  });
  desk.tool.on((tool) => {
    for (const [name, button] of buttons) {
      button.setAttribute("aria-pressed", String(name === tool?.name));
      button.tabIndex = name === tool?.name ? 0 : -1;
    }
  });
  bar.addEventListener("keydown", (event) => walk(event, [...buttons.values()]));
}

function made(desk: Desk, tool: Tool): HTMLButtonElement {
  const tip = `${tool.title}${tool.key ? ` (${tool.key.toUpperCase()})` : ""}: ${tool.help}`;
  const keys = tool.key ? { "aria-keyshortcuts": tool.key } : {};
  const button = iconButton(ICONS[tool.name] ?? ICONS.insert!, tool.title, () => (desk.tool.value = tool), { "data-tool": tool.name, ...keys });
  button.title = tip;
  return button;
}

// Arrow keys, Home and End go from one of several elements to another.
export function walk(event: KeyboardEvent, all: HTMLElement[]): void {
  const at = all.indexOf(document.activeElement as HTMLElement);
  const to = { ArrowDown: at + 1, ArrowRight: at + 1, ArrowUp: at - 1, ArrowLeft: at - 1, Home: 0, End: all.length - 1 }[event.key];
  if (at < 0 || to === undefined) return;
  event.preventDefault();
  event.stopPropagation();
  all[(to + all.length) % all.length]!.focus();
}
