// What the page and the server say to each other, as types; and frames taken apart into views, without copying.
// The text of it is PROTOCOL.md beside the server. Lengths are mm, in frames whole um; y runs down.

export const PROTOCOL = 1;

export interface Knob {
  name: string;
  kind: "range" | "numbers" | "choice" | "text" | "flag";
  default: KnobValue;
  help: string;
  low?: number;
  high?: number;
  unit?: string;
  whole?: boolean;
  count?: number | null;
  names?: string[];
  file?: boolean;
}

export type KnobValue = number | number[] | string | boolean | null;
export type Params = Record<string, KnobValue>;

export interface Operation {
  name: string;
  help: string;
  group: "brush" | "select" | "relax" | "layer" | "style" | "map" | "paper";
  knobs: Knob[];
}

export interface Hello {
  say: "hello";
  protocol: number;
  version: string;
  name: string;
  size: [number, number];
  margin: number | null;
  art: [number, number, number, number];
  picture: boolean;
  operations: Operation[];
  formats: Record<string, Knob[]>;
  limits: { marks: number; path: number; frame: number }; // path: points
  notes: string[];
}

export interface Layer {
  id: number;
  name: string;
  kind: "marks" | "objects" | "tiles" | "still";
  ink: string;
  spot: boolean;
  cmyk: [number, number, number, number];
  rgb: [number, number, number];
  pen: number | null;
  hidden: boolean;
  locked: boolean;
  items: number;
}

export interface Kind {
  id: number;
  d: string;
  closed: boolean;
  reach: number;
  name: string;
}

export type Libraries = Record<string, Kind[]>;

export interface Busy {
  n: number;
  op: string;
  paused: boolean;
  single: boolean; // of which nothing stays if it is stopped
}

export interface State {
  say: "state";
  revision: number;
  frames: number;
  reset?: boolean;
  layers: Layer[];
  kinds: Kind[];
  selected: number;
  marks: number;
  undo: string[];
  redo: string[];
  wall: number[][] | null;
  canvas?: number[][]; // with a reset
  busy: Busy | null;
}

export interface Finding {
  rule: string;
  severity: string;
  where: string;
  message: string;
}

export interface Facts {
  files?: string[];
  findings?: Finding[];
  [name: string]: unknown;
}

export interface Step {
  say: "step";
  n: number;
  done: number;
  total: number;
  stage: string; // recover: of a log that is done again
  facts: Record<string, number>;
}

export interface Done {
  say: "done";
  n: number;
  facts: Facts;
  notes: string[];
  stopped?: boolean;
}

export interface Failed {
  say: "error";
  n: number | null;
  text: string;
}

export interface Saved {
  say: "saved";
  ok: boolean;
  waiting: number;
  text: string;
}

export type Said = Hello | State | Step | Done | Failed | Saved | { say: "tabs"; count: number } | { say: "closed"; text: string };

export interface Request {
  do: string;
  [key: string]: unknown;
}

// Columns of items: those of a chunk are views of its frame, in the order of its ids.
export interface ItemChunk {
  layer: number;
  gone: boolean;
  n: number;
  first: number;
  ids?: Uint32Array; // left out: first, first + 1, ...
  x?: Int32Array;
  y?: Int32Array;
  dx?: Int16Array; // in place of x and y: how far from where they were
  dy?: Int16Array;
  scale?: Uint32Array;
  turn?: Uint16Array;
  kind?: Uint32Array;
  fill?: Uint32Array;
  flags?: Uint8Array;
}

export interface Patch {
  map: "tone" | "importance";
  top: number;
  left: number;
  height: number;
  width: number;
  rows: number;
  columns: number;
  values: Uint8Array;
}

export type LineKind = "cells" | "axes" | "flow";

export interface LineSet {
  what: LineKind;
  closed: boolean;
  start: Uint32Array;
  xy: Float32Array;
}

export type Frame = { revision: number } & (
  | { type: "items"; chunks: ItemChunk[] }
  | { type: "raster"; patches: Patch[] }
  | { type: "lines"; lines: LineSet }
);

export const SELECTED = 1;
export const FROZEN = 2;
export const OWN_FILL = 0x01000000;

const XY = 1;
const SCALE = 2;
const TURN = 4;
const KIND = 8;
const FILL = 16;
const FLAGS = 32;
const RANGE = 64;
const STEPS = 128;
const MAPS = ["tone", "importance"] as const;
const LINES = ["cells", "axes", "flow"] as const;

// Reads views one after another; each begins at a multiple of 4 bytes.
class Reader {
  at = 0;
  constructor(readonly buffer: ArrayBuffer) {}

  words(n: number): Uint32Array {
    return this.taken(new Uint32Array(this.buffer, this.at, n));
  }

  whole(n: number): Int32Array {
    return this.taken(new Int32Array(this.buffer, this.at, n));
  }

  shorts(n: number): Uint16Array {
    return this.taken(new Uint16Array(this.buffer, this.at, n));
  }

  steps(n: number): Int16Array {
    return this.taken(new Int16Array(this.buffer, this.at, n));
  }

  bytes(n: number): Uint8Array {
    return this.taken(new Uint8Array(this.buffer, this.at, n));
  }

  floats(n: number): Float32Array {
    return this.taken(new Float32Array(this.buffer, this.at, n));
  }

  private taken<T extends ArrayBufferView>(view: T): T {
    this.at += Math.ceil(view.byteLength / 4) * 4;
    return view;
  }
}

function itemChunk(reader: Reader): ItemChunk {
  const [layer, n, columns, first] = reader.words(4) as unknown as [number, number, number, number];
  const chunk: ItemChunk = { layer, gone: (columns & ~RANGE) === 0, n, first };
  if (!(columns & RANGE)) chunk.ids = reader.words(n);
  if (columns & STEPS) {
    chunk.dx = reader.steps(n);
    chunk.dy = reader.steps(n);
  } else if (columns & XY) {
    chunk.x = reader.whole(n);
    chunk.y = reader.whole(n);
  }
  if (columns & SCALE) chunk.scale = reader.words(n);
  if (columns & TURN) chunk.turn = reader.shorts(n);
  if (columns & KIND) chunk.kind = reader.words(n);
  if (columns & FILL) chunk.fill = reader.words(n);
  if (columns & FLAGS) chunk.flags = reader.bytes(n);
  return chunk;
}

function patch(reader: Reader): Patch {
  const [map, top, left, height, width, rows, columns] = reader.words(8) as unknown as number[];
  const values = reader.bytes(height! * width!);
  return { map: MAPS[map!]!, top: top!, left: left!, height: height!, width: width!, rows: rows!, columns: columns!, values };
}

function lineSet(reader: Reader): LineSet {
  const [what, paths, points, closed] = reader.words(4) as unknown as number[];
  return { what: LINES[what!]!, closed: closed !== 0, start: reader.words(paths! + 1), xy: reader.floats(2 * points!) };
}

// A frame as views of its buffer. Throws RangeError for one that is cut short and Error for one of an unknown type.
export function frame(buffer: ArrayBuffer): Frame {
  const reader = new Reader(buffer);
  const [type, revision, chunks] = reader.words(4) as unknown as [number, number, number];
  const several = <T>(read: (reader: Reader) => T): T[] => Array.from({ length: chunks }, () => read(reader));
  if (type === 1) return { revision, type: "items", chunks: several(itemChunk) };
  if (type === 2) return { revision, type: "raster", patches: several(patch) };
  if (type === 3) return { revision, type: "lines", lines: lineSet(reader) };
  throw new Error(`the server sent a frame of unknown type ${type}`);
}
