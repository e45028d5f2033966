// What every part of the page works with.

import type { Drawing } from "./drawing";
import type { Link } from "./link";
import type { Messages } from "./messages";
import type { Done, Libraries, Operation, Params } from "./protocol";
import type { Settings } from "./settings";
import type { Tool } from "./tools";
import type { Viewport } from "./viewport";
import type { Appearance } from "./appearance";
import { Watched } from "./watch";

export interface How {
  group?: number;
  times?: number;
  seed?: number;
}

export class Desk {
  readonly layer = new Watched<number | null>(null); // the layer worked on; null: all that may change
  readonly tools = new Watched<Tool[]>([]);
  readonly tool = new Watched<Tool | null>(null);
  readonly region = new Watched<number[] | null>(null); // a path drawn for what is to be drawn anew
  libraries: Libraries = {}; // of shapes that can be inserted
  private group = 0;

  constructor(
    readonly link: Link,
    readonly drawing: Drawing,
    readonly settings: Settings,
    readonly viewport: Viewport,
    readonly messages: Messages,
    readonly appearance: Appearance,
  ) {}

  operation(name: string): Operation | undefined {
    return this.drawing.hello.value?.operations.find((one) => one.name === name);
  }

  // A number that no group has had, in this tab or most likely any other.
  newGroup(): number {
    return (this.group = Math.max(this.group + 1, Date.now()));
  }

  // Has an operation done, and says what comes of it; fulfilled with null where it failed.
  async apply(op: string, params: Params, how: How = {}): Promise<Done | null> {
    return this.ask({ do: "apply", op, params, ...how });
  }

  async ask(request: { do: string; [key: string]: unknown }): Promise<Done | null> {
    try {
      const done = await this.link.ask(request);
      for (const note of done.notes ?? []) this.messages.note(note);
      return done;
    } catch (error) {
      this.messages.error((error as Error).message);
      return null;
    }
  }

  // The parameter that says which layer, where one is chosen and the operation takes one.
  ofLayer(operation: Operation): Params {
    const layer = this.layer.value;
    return layer !== null && operation.knobs.some((knob) => knob.name === "layer") ? { layer } : {};
  }
}
