// What the page and its painter, which works in a thread of its own, tell each other.

import type { Kind, Layer, LineKind } from "./protocol";
import type { Tints } from "./tile";

// px of the screen to the mm, and where the paper's corner lies on the canvas, px.
export interface View {
  scale: number;
  x: number;
  y: number;
}

export type Under = "none" | "picture" | "tone" | "importance";

export interface Look {
  desk: string;
  paper: string;
  tints: Tints;
  under: Under;
  opacity: number; // of what lies beneath
}

export type ToPainter =
  | { do: "canvas"; canvas: OffscreenCanvas }
  | { do: "begin"; size: [number, number]; art: [number, number, number, number] }
  | { do: "state"; revision: number; frames: number; reset: boolean; layers: Layer[]; kinds: Kind[] }
  | { do: "frame"; buffer: ArrayBuffer }
  | { do: "view"; view: View; width: number; height: number }
  | { do: "look"; look: Look }
  | { do: "image"; name: "picture" | number; bitmap: ImageBitmap | null } // a number: of the still layer with this id
  | { do: "forget"; what: LineKind };

// After each frame of the screen: the revision that is wholly shown, how many frames so far, what the last took in ms, and when it was done
// by the clock that both threads share.
export interface Painted {
  revision: number;
  frames: number;
  cost: number;
  at: number;
}
