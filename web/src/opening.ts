// Opening another picture or drawing of the folder.

import type { Desk } from "./desk";
import { dialog } from "./dialogs";
import { button, el } from "./dom";

export async function openDialog(desk: Desk): Promise<void> {
  const done = await desk.ask({ do: "files" });
  if (!done) return;
  const files = done.facts.files ?? [];
  const open = async (file: string): Promise<void> => {
    shown.close();
    if (await desk.ask({ do: "open", file })) desk.messages.note(`${file} is open; every tab shows it.`);
  };
  const list = el("ul", { class: "files" }, ...files.map((file) => el("li", {}, button(file, () => void open(file)))));
  const shown = dialog("Open", files.length ? list : el("p", {}, "There is nothing else in the folder that can be opened."));
}
