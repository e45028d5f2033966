// The page, put together.

import { Appearance } from "./appearance";
import { commands } from "./commands";
import { Desk } from "./desk";
import { Drawing } from "./drawing";
import { historyPanel } from "./historypanel";
import { layersPanel } from "./layerspanel";
import { Link } from "./link";
import { Messages } from "./messages";
import { Overlay } from "./overlay";
import type { Painted } from "./painting";
import { pointing } from "./pointing";
import type { Libraries } from "./protocol";
import { rail } from "./rail";
import { relaxPanel } from "./relaxpanel";
import { Settings } from "./settings";
import { showing, type Tell } from "./showing";
import { Status } from "./status";
import { stylePanel } from "./stylepanel";
import { tabs } from "./tabs";
import { toolPanel } from "./toolpanel";
import { mapShown, tools } from "./tools";
import { Viewport } from "./viewport";
import { viewPanel } from "./viewpanel";
import { Watched } from "./watch";
import type { Wire } from "./wire";
import { work } from "./work";

// Begins the page, with the address of its own script and its wire to the server.
export function begin(script: string, wire: Wire): void {
  if (!("transferControlToOffscreen" in HTMLCanvasElement.prototype)) {
    document.body.textContent = "The editor needs a browser that paints in a thread of its own: Chromium 69, Firefox 105, Safari 16.4, or newer.";
    return;
  }
  const worker = new Worker(script);
  const tell: Tell = (message, move = []) => worker.postMessage(message, move);
  const painted = new Watched<Painted | null>(null);
  worker.addEventListener("message", (event: MessageEvent<Painted>) => (painted.value = event.data));
  const messages = new Messages();
  worker.addEventListener("error", (event) => messages.error(`The painter has failed: ${event.message}. Load the page again; nothing is lost.`));

  const link = new Link(wire);
  const desk = new Desk(link, new Drawing(link, tell), new Settings(), new Viewport(), messages, new Appearance());
  const overlay = new Overlay(desk);
  rail(desk);
  const show = tabs([
    { name: "Tool", panel: toolPanel(desk) },
    { name: "Layers", panel: layersPanel(desk) },
    { name: "Relax", panel: relaxPanel(desk) },
    { name: "Style", panel: stylePanel(desk) },
    { name: "History", panel: historyPanel(desk) },
    { name: "View", panel: viewPanel(desk, (what) => tell({ do: "forget", what })) },
  ]);
  desk.tool.on(() => show("Tool"));
  mapShown(desk);
  showing(desk, tell);
  work(desk);
  commands(desk, pointing(desk, overlay, new Status(desk)));
  let shown = "";
  desk.drawing.begun((hello) => (desk.tools.value = tools(desk, hello.operations)));
  desk.drawing.hello.on((hello) => {
    if (!hello) return;
    const now = JSON.stringify([hello.name, hello.size, hello.art]);
    if (now !== shown) desk.region.value = null; // of another drawing, or another place
    if (!shown.startsWith(JSON.stringify([hello.name]).slice(0, -1))) desk.layer.value = null;
    if (!shown) hint(desk);
    shown = now;
    for (const note of hello.notes) messages.note(note);
  });
  link.lost.on((text) => messages.error(text));
  Object.assign(window, { crowquill: { desk, painted } }); // for tests and the curious
  void libraries(desk).finally(() => link.connect());
}

// Says what to do with an empty canvas that nothing was done to.
function hint(desk: Desk): void {
  let told = false;
  desk.drawing.changed.on(() => {
    const { marks, undo, redo } = desk.drawing.state.value!;
    if (!told && !marks && !undo.length && !redo.length) desk.messages.note("Draw with a brush, or let a style draw it all: the panel Style.");
    told = true;
  });
}

async function libraries(desk: Desk): Promise<void> {
  const found = await desk.link.wire.get("libraries.json");
  if (found) desk.libraries = JSON.parse(await found.text()) as Libraries;
}
