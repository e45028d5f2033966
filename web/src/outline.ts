// Outlines of kinds: SVG path data as rings of straight pieces, as fine as a scale needs.

export interface Ring {
  xy: Float64Array; // x, y, x, y ...
  closed: boolean;
}

type Piece = { to: [number, number] } | { cubic: [number, number, number, number, number, number] };
interface Path {
  from: [number, number];
  pieces: Piece[];
  closed: boolean;
}

const TOKEN = /([a-zA-Z])|(-?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)/g;
const TAKES: Record<string, number> = { M: 2, L: 2, H: 1, V: 1, C: 6, S: 4, Q: 4, T: 2, Z: 0 };
const UNIT = 1000; // path data is written in thousandths
const FINENESS = 0.04; // px that a straight piece may leave its curve
const COARSEST = 0.005; // of scale 1, however small: a disc keeps its area to 1 %

export class Outline {
  private readonly paths: Path[];
  private readonly flats = new Map<number, Ring[]>();

  constructor(d: string, readonly closed: boolean, readonly reach: number) {
    this.paths = parsed(d, closed);
  }

  // The rings for a size of so many px at scale 1, in the outline's own units.
  rings(px: number): Ring[] {
    const level = Math.max(0, Math.ceil(Math.log2(Math.max(px, 1))));
    let rings = this.flats.get(level);
    if (!rings) this.flats.set(level, (rings = this.paths.map((path) => flattened(path, Math.min(COARSEST, FINENESS / 2 ** level)))));
    return rings;
  }
}

// Path data with M, L, H, V, C, S, Q, T and Z, absolute or relative. Throws for others.
function parsed(d: string, closed: boolean): Path[] {
  const tokens = [...d.matchAll(TOKEN)].map((found): string | number => found[1] ?? Number(found[2]) / UNIT);
  const paths: Path[] = [];
  let path: Path | null = null;
  let [x, y] = [0, 0];
  let control: [number, number] | null = null;
  let command = "";
  for (let i = 0; i < tokens.length; ) {
    if (typeof tokens[i] === "string") command = tokens[i++] as string;
    const upper = command.toUpperCase();
    const takes = TAKES[upper];
    if (takes === undefined) throw new Error(`path data with ${command || "no command"}`);
    const relative = command !== upper;
    const v = tokens.slice(i, i + takes) as number[];
    i += takes;
    if (upper === "Z") {
      if (path) [path.closed, [x, y]] = [true, path.from];
      command = relative ? "m" : "M"; // what follows begins anew
      control = null;
      continue;
    }
    if (relative && upper !== "H" && upper !== "V") for (let k = 0; k < takes; k++) v[k]! += k % 2 ? y : x;
    if (upper === "M" || !path) {
      path = { from: [v[0]!, v[1]!], pieces: [], closed };
      paths.push(path);
      [x, y] = path.from;
      command = relative ? "l" : "L";
      continue;
    }
    const straight = (toX: number, toY: number): void => {
      path!.pieces.push({ to: [(x = toX), (y = toY)] });
      control = null;
    };
    const cubic = (a: number, b: number, c: number, e: number, toX: number, toY: number): void => {
      path!.pieces.push({ cubic: [a, b, c, e, toX, toY] });
      [x, y] = [toX, toY];
    };
    const mirrored: [number, number] = control ? [2 * x - control[0], 2 * y - control[1]] : [x, y];
    if (upper === "L") straight(v[0]!, v[1]!);
    else if (upper === "H") straight(relative ? x + v[0]! : v[0]!, y);
    else if (upper === "V") straight(x, relative ? y + v[0]! : v[0]!);
    else if (upper === "C") {
      cubic(v[0]!, v[1]!, v[2]!, v[3]!, v[4]!, v[5]!);
      control = [v[2]!, v[3]!];
    } else if (upper === "S") {
      cubic(mirrored[0], mirrored[1], v[0]!, v[1]!, v[2]!, v[3]!);
      control = [v[0]!, v[1]!];
    } else {
      const [qx, qy] = upper === "Q" ? [v[0]!, v[1]!] : mirrored;
      const [toX, toY] = upper === "Q" ? [v[2]!, v[3]!] : [v[0]!, v[1]!];
      cubic(x + (2 / 3) * (qx - x), y + (2 / 3) * (qy - y), toX + (2 / 3) * (qx - toX), toY + (2 / 3) * (qy - toY), toX, toY);
      control = [qx, qy];
    }
  }
  return paths;
}

function flattened(path: Path, tolerance: number): Ring {
  const xy = [...path.from];
  for (const piece of path.pieces) {
    if ("to" in piece) {
      xy.push(...piece.to);
      continue;
    }
    const [x0, y0] = [xy[xy.length - 2]!, xy[xy.length - 1]!];
    const [x1, y1, x2, y2, x3, y3] = piece.cubic;
    // so many equal pieces keep within the tolerance: the second differences bound how far a cubic bends
    const bend = Math.max(Math.hypot(x0 - 2 * x1 + x2, y0 - 2 * y1 + y2), Math.hypot(x1 - 2 * x2 + x3, y1 - 2 * y2 + y3));
    const n = Math.min(64, Math.max(1, Math.ceil(Math.sqrt((0.75 * bend) / tolerance))));
    for (let k = 1; k <= n; k++) {
      const t = k / n;
      const s = 1 - t;
      const [a, b, c, e] = [s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t];
      xy.push(a * x0 + b * x1 + c * x2 + e * x3, a * y0 + b * y1 + c * y2 + e * y3);
    }
  }
  return { xy: Float64Array.from(xy), closed: path.closed };
}
