// What keys and buttons do beside the tools.

import type { Desk } from "./desk";
import { byId, icon } from "./dom";
import { exportDialog } from "./exporting";
import type { Pointers } from "./gestures";
import { ICONS } from "./icons";
import { helpDialog, listen, type Shortcut } from "./keys";
import { openDialog } from "./opening";

const TRUE_SIZE = 96 / 25.4; // px of the page to the mm, as browsers count

export function commands(desk: Desk, pointers: Pointers): void {
  const all = (): Shortcut[] => [...choosing(desk), ...editing(desk), ...brush(desk), ...looking(desk), ...page(desk, pointers, sheet)];
  const sheet = (): void => helpDialog(desk, all());
  desk.tools.on((tools) => {
    if (tools.length) listen(all(), desk.appearance.keys);
  });
  const clicks: [string, () => void][] = [
    ["undo", () => void desk.ask({ do: "undo" })],
    ["redo", () => void desk.ask({ do: "redo" })],
    ["open", () => void openDialog(desk)],
    ["export", () => exportDialog(desk)],
    ["theme", () => desk.appearance.flip()],
    ["help", sheet],
    ["fit", () => desk.viewport.all()],
    ["zoom", () => desk.viewport.set(TRUE_SIZE * desk.viewport.ratio)],
  ];
  for (const [id, run] of clicks) {
    byId(id).addEventListener("click", run);
    if (byId(id).classList.contains("icon-button")) byId(id).replaceChildren(icon(ICONS[id]!));
  }
  desk.drawing.state.on((state) => {
    for (const [id, names, verb, keys] of [["undo", state?.undo, "Undo", "Ctrl Z"], ["redo", state?.redo, "Do again", "Ctrl Shift Z"]] as const) {
      byId<HTMLButtonElement>(id).disabled = !names?.length;
      const title = `${verb}${names?.[0] ? `: ${names[0]}` : ""} (${keys})`;
      if (byId(id).title !== title) byId(id).title = title;
    }
  });
}

function choosing(desk: Desk): Shortcut[] {
  const keyed = desk.tools.value.filter((tool) => tool.key);
  return keyed.map((tool) => ({ keys: [tool.key], about: tool.title, run: () => (desk.tool.value = tool) }));
}

function editing(desk: Desk): Shortcut[] {
  const selected = (): boolean => Boolean(desk.drawing.state.value?.selected);
  const select = (by: string) => (): void => void desk.apply("select", { by });
  const relax = (times: number) => (): void => {
    const operation = desk.operation("relax");
    if (operation) void desk.apply("relax", { ...desk.settings.params(operation), ...desk.ofLayer(operation) }, { times });
  };
  return [
    { keys: ["Ctrl+z"], about: "Undo", run: () => void desk.ask({ do: "undo" }) },
    { keys: ["Ctrl+Shift+z", "Ctrl+y"], about: "Do again", run: () => void desk.ask({ do: "redo" }) },
    { keys: ["Ctrl+a"], about: "Select all", run: select("all") },
    { keys: ["Ctrl+i"], about: "Invert the selection", run: select("invert") },
    { keys: ["Ctrl+d"], about: "Duplicate the selection", run: () => void (selected() && desk.apply("duplicate", {})) },
    { keys: ["Delete", "Backspace"], about: "Erase the selection", run: () => void (selected() && desk.apply("erase", { on: "selection" })) },
    { keys: ["x"], about: "One step of relaxation", run: relax(1) },
    { keys: ["Shift+x"], about: "Ten steps of relaxation", run: relax(10) },
  ];
}

function brush(desk: Desk): Shortcut[] {
  const { settings } = desk;
  const size = (factor: number) => (): void => {
    const operation = desk.tool.value?.operation;
    if (operation) settings.scale(operation, "size", factor);
  };
  const strength = (digit: string): void => {
    const operation = desk.tool.value?.operation;
    if (operation) settings.set(operation, "strength", digit === "0" ? 1 : Number(digit) / 10);
  };
  return [
    { keys: ["["], about: "Smaller brush", run: size(1 / 1.2) },
    { keys: ["]"], about: "Larger brush", run: size(1.2) },
    { keys: [..."1234567890"], shown: "1 … 9, 0", about: "Strength 10 … 90, 100 %", run: strength },
  ];
}

function looking(desk: Desk): Shortcut[] {
  const { viewport } = desk;
  const selection = (): void => {
    const box = desk.drawing.selection();
    if (box) viewport.fit(box);
  };
  return [
    { keys: ["+", "="], about: "Closer", run: () => viewport.zoom(1.25) },
    { keys: ["-"], about: "Farther", run: () => viewport.zoom(1 / 1.25) },
    { keys: ["Home"], about: "The whole paper", run: () => viewport.all() },
    { keys: ["z"], about: "What is selected, as large as it goes", run: selection },
  ];
}

function page(desk: Desk, pointers: Pointers, sheet: () => void): Shortcut[] {
  const escape = (): void => {
    const { busy, selected } = desk.drawing.state.value ?? {};
    if (pointers.busy) pointers.cancel();
    else if (busy) void desk.ask({ do: "stop" });
    else if (desk.region.value) desk.region.value = null;
    else if (selected) void desk.apply("select", { by: "none" });
  };
  return [
    { keys: ["Escape"], about: "Give up the stroke, stop the work, or select nothing", run: escape },
    { keys: ["Ctrl+o"], about: "Open", run: () => void openDialog(desk) },
    { keys: ["Ctrl+s"], about: "Export", run: () => exportDialog(desk) },
    { keys: ["Shift+d"], about: "Light or dark", run: () => desk.appearance.flip() },
    { keys: ["?"], about: "This sheet", run: sheet },
  ];
}
