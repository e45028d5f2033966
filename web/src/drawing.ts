// The drawing as the page knows it: what the server said last, and the items with it.

import { Items } from "./items";
import type { Link } from "./link";
import { Outline } from "./outline";
import { PROTOCOL, SELECTED, frame, type Hello, type LineKind, type Saved, type State, type Step } from "./protocol";
import { Signal, Watched } from "./watch";
import type { ToPainter } from "./painting";

export interface Box {
  left: number;
  top: number;
  right: number;
  bottom: number;
}

export class Drawing {
  readonly hello = new Watched<Hello | null>(null);
  readonly state = new Watched<State | null>(null);
  readonly saved = new Watched<Saved | null>(null);
  readonly tabs = new Watched(1);
  readonly steps = new Signal<Step>();
  readonly lines = new Signal<LineKind>();
  readonly changed = new Signal(); // items are as the last state says
  readonly items = new Items();
  readonly kinds = new Map<number, Outline>();
  canvas: number[][] = []; // rings in which the picture is drawn, mm
  private around: { box: Box | null } | null = null; // the selection's box, once it was asked for
  private missing = 0; // what has not come yet of the state that is said: frames

  constructor(link: Link, private readonly painter: (message: ToPainter, move?: Transferable[]) => void) {
    link.said.on((said) => {
      if (said.say === "hello" && said.protocol !== PROTOCOL) link.lost.say(`This page speaks protocol ${PROTOCOL}, the server ${said.protocol}: load the page again.`);
      else if (said.say === "hello") this.begin(said);
      if (said.say === "state") this.take(said);
      if (said.say === "saved") this.saved.value = said;
      if (said.say === "tabs") this.tabs.value = said.count;
      if (said.say === "step") this.steps.say(said);
    });
    link.frames.on((buffer) => {
      try {
        this.receive(buffer);
      } catch (error) {
        link.lost.say(`A part of the drawing could not be read (${(error as Error).message}); it is asked for again.`);
        void link.ask({ do: "refresh" }).catch(() => undefined);
      }
    });
    this.changed.on(() => (this.around = null));
  }

  // Calls a listener once, with the first hello: what the server can do stays the same, while the paper may change.
  begun(listener: (hello: Hello) => void): void {
    let told = false;
    this.hello.on((hello) => {
      if (hello && !told) listener(hello);
      told ||= hello !== null;
    });
  }

  // What lies around the selected items' outlines, mm; null where none are selected.
  selection(): Box | null {
    return (this.around ??= this.found()).box;
  }

  private found(): { box: Box | null } {
    const { items } = this;
    const box = { left: Infinity, top: Infinity, right: -Infinity, bottom: -Infinity };
    for (const id of this.selected()) {
      const [x, y, r] = [items.x[id]! / 1000, items.y[id]! / 1000, this.reach(id)];
      box.left = Math.min(box.left, x - r);
      box.top = Math.min(box.top, y - r);
      box.right = Math.max(box.right, x + r);
      box.bottom = Math.max(box.bottom, y + r);
    }
    return { box: box.left < box.right ? box : null };
  }

  // The selected items' ids.
  *selected(): Generator<number> {
    if (!this.state.value?.selected) return;
    const { items } = this;
    for (let id = 0; id < items.end; id++) if (items.layer[id] && items.flags[id]! & SELECTED) yield id;
  }

  // How far an item reaches from its centre, mm.
  reach(id: number): number {
    return ((this.kinds.get(this.items.kind[id]!)?.reach ?? 1) * this.items.scale[id]!) / 1000;
  }

  private begin(hello: Hello): void {
    this.missing = 1; // the state itself
    this.painter({ do: "begin", size: hello.size, art: hello.art });
    this.hello.value = hello;
  }

  private take(state: State): void {
    if (state.reset) {
      this.items.clear();
      this.kinds.clear();
    }
    if (state.canvas) this.canvas = state.canvas;
    for (const kind of state.kinds) this.kinds.set(kind.id, new Outline(kind.d, kind.closed, kind.reach));
    const { revision, frames, layers, kinds } = state;
    this.painter({ do: "state", revision, frames, reset: state.reset ?? false, layers, kinds });
    this.missing = state.frames;
    this.state.value = state;
    if (!this.missing) this.changed.say();
  }

  private receive(buffer: ArrayBuffer): void {
    const received = frame(buffer);
    if (received.type === "items") for (const chunk of received.chunks) this.items.take(chunk);
    this.painter({ do: "frame", buffer }, [buffer]); // its columns are copied: the buffer may go
    if (received.type === "lines") this.lines.say(received.lines.what);
    else if (--this.missing === 0) this.changed.say();
  }
}
