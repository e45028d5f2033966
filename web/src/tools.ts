// The tools of the rail: to look, to select, and a brush for every operation that takes a way and a size.

import type { Desk } from "./desk";
import type { Begin, Gesture, Keys, Point } from "./gestures";
import { handles } from "./handles";
import type { Operation } from "./protocol";
import { stroke } from "./stroke";
import { title } from "./knobs";

export interface Tool {
  name: string;
  title: string;
  help: string;
  key: string;
  part: "look" | "select" | "brush" | "outline";
  operation: Operation | null; // whose knobs it shows
  ring: boolean; // the brush's rim goes with the pointer
  begin: Begin;
}

const KEYS: Record<string, string> = {
  insert: "b", erase: "e", push: "p", attract: "a", jitter: "j", resize: "s", turn: "t", swap: "g", freeze: "f", paint: "i", relax: "r",
};
const LINGERING = new Set(["insert", "attract", "jitter", "relax", "paint"]); // go on where the pen is held still

// All tools for what the server can do, in the order of the rail.
export function tools(desk: Desk, operations: Operation[]): Tool[] {
  const brushes = operations.filter((one) => takes(one, "path") && takes(one, "size") && one.group !== "select" && one.group !== "style");
  const order = Object.keys(KEYS);
  const place = (one: Operation): number => (order.includes(one.name) ? order.indexOf(one.name) : order.length);
  brushes.sort((a, b) => place(a) - place(b));
  const select = operations.find((one) => one.name === "select");
  return [...looking(desk), ...(select ? selecting(desk, select) : []), ...brushes.map((one) => brushing(desk, one)), ...outlining(desk, operations)];
}

// Shows the map that the tool in hand paints, in place of the picture.
export function mapShown(desk: Desk): void {
  const show = (): void => {
    const operation = desk.tool.value?.operation;
    const map = operation?.name === "paint" ? desk.settings.get(operation, "map") : null;
    desk.appearance.instead.value = map === "tone" || map === "importance" ? map : null;
  };
  desk.tool.on(show);
  desk.settings.changed.on(show);
}

function takes(operation: Operation, name: string): boolean {
  return operation.knobs.some((knob) => knob.name === name);
}

function looking(desk: Desk): Tool[] {
  const begin = (first: Point): Gesture => {
    const { viewport } = desk;
    return {
      move: (points) => {
        const last = points[points.length - 1]!;
        const [x, y] = [(last.x - first.x) * viewport.scale, (last.y - first.y) * viewport.scale];
        viewport.pan(x / viewport.ratio, y / viewport.ratio);
      },
      end: () => undefined,
      cancel: () => undefined,
    };
  };
  return [{ name: "pan", title: "Pan", help: "Drag the paper about", key: "h", part: "look", operation: null, ring: false, begin }];
}

function mode(keys: Keys): "replace" | "add" | "remove" {
  return keys.alt ? "remove" : keys.shift ? "add" : "replace";
}

function selecting(desk: Desk, operation: Operation): Tool[] {
  const send = (by: string, keys: Keys, path: number[], more: object = {}): void => {
    void desk.apply("select", { by, mode: mode(keys), path, ...more, ...desk.ofLayer(operation) });
  };
  const tool = (name: string, key: string, help: string, begin: Begin, ring = false): Tool => {
    return { name, title: title(name), help: `${help}; Shift adds, Alt takes away`, key, part: "select", operation: ring ? operation : null, ring, begin };
  };
  const held = (point: Point, keys: Keys): Gesture | null => (mode(keys) === "replace" ? handles(desk, point) : null);
  const pick: Begin = (point, keys) => {
    const path = [point.x, point.y, 1];
    return held(point, keys) ?? clicked(() => send("pick", keys, path));
  };
  const rectangle: Begin = (point, keys) =>
    held(point, keys) ?? framed(desk, point, (last) => send("rectangle", keys, [point.x, point.y, 1, last.x, last.y, 1]), () => send("pick", keys, [point.x, point.y, 1]));
  const lasso: Begin = (point, keys) => around(desk, point, (path) => send("lasso", keys, path));
  const brush: Begin = (point, keys) => {
    const size = desk.settings.get(operation, "size");
    const group = desk.newGroup();
    let sent = 0;
    return stroke(point, {
      size: typeof size === "number" ? size : 5,
      lead: false,
      least: 1,
      lingers: false,
      most: 3 * desk.drawing.hello.value!.limits.path,
      send: (path) => {
        const how = sent++ && mode(keys) === "replace" ? "add" : mode(keys);
        return desk.apply("select", { by: "brush", mode: how, path, size, ...desk.ofLayer(operation) }, { group });
      },
    });
  };
  return [
    tool("pick", "v", "Select the mark that you touch, and move or turn what is selected by its handles", pick),
    tool("rectangle", "m", "Select in a rectangle", rectangle),
    tool("lasso", "l", "Select inside an outline that you draw", lasso),
    tool("select brush", "q", "Select under a brush", brush, true),
  ];
}

function brushing(desk: Desk, operation: Operation): Tool {
  const begin: Begin = (point, keys) => {
    const { settings } = desk;
    const params = { ...settings.params(operation), ...desk.ofLayer(operation) };
    const size = Number(settings.get(operation, "size"));
    const by = operation.name === "turn" ? settings.get(operation, "by") : settings.get(operation, "turn");
    const group = desk.newGroup();
    return stroke(point, {
      size,
      lead: operation.name === "push" || (operation.name === "turn" && by === "stroke"),
      least: operation.name === "insert" && by === "stroke" ? 2 : 1,
      lingers: LINGERING.has(operation.name),
      most: 3 * desk.drawing.hello.value!.limits.path,
      send: async (path) => {
        const on = takes(operation, "on") ? { on: "brush" } : {};
        const done = await desk.apply(operation.name, { ...params, ...(keys.alt ? opposite(operation, params) : {}), ...on, size, path }, { group });
        if (!done) throw new Error("refused");
      },
    });
  };
  const { name, help } = operation;
  return { name, title: title(name), help, key: KEYS[name] ?? "", part: "brush", operation, ring: true, begin };
}

// What a brush does with Alt held: the other way round.
function opposite(operation: Operation, params: Record<string, unknown>): Record<string, number | boolean> {
  const value = (name: string): unknown => params[name] ?? operation.knobs.find((knob) => knob.name === name)?.default;
  if (operation.name === "resize") return { factor: 1 / Number(value("factor")) };
  if (operation.name === "turn") return { angle: -Number(value("angle")) };
  if (operation.name === "freeze") return { frozen: !value("frozen") };
  if (operation.name === "paint") return { value: 1 - Number(value("value")) };
  return {};
}

function outlining(desk: Desk, operations: Operation[]): Tool[] {
  const found: Tool[] = [];
  const wall = operations.find((one) => one.name === "wall");
  const outline = { part: "outline", operation: null, ring: false } as const;
  if (wall) {
    const begin: Begin = (point) => around(desk, point, (path) => void desk.apply("wall", { path }));
    found.push({ name: "wall", title: "Wall", help: "Draw an outline that relaxation does not cross", key: "w", ...outline, begin });
  }
  if (operations.some((one) => one.group === "style")) {
    const begin: Begin = (point) => around(desk, point, (path) => (desk.region.value = path));
    found.push({ name: "region", title: "Region", help: "Draw the outline of what a style shall draw anew", key: "d", ...outline, begin });
  }
  return found;
}

function clicked(done: () => void): Gesture {
  return { move: () => undefined, end: done, cancel: () => undefined };
}

// A rectangle drawn from corner to corner, or a click.
function framed(desk: Desk, first: Point, done: (last: Point) => void, click: () => void): Gesture {
  let last = first;
  return {
    move: (points) => (last = points[points.length - 1]!),
    end: () => (far(desk, first, last) < 3 ? click() : done(last)),
    cancel: () => undefined,
    draw: (context) => {
      const [[x0, y0], [x1, y1]] = [desk.viewport.px(first.x, first.y), desk.viewport.px(last.x, last.y)];
      context.strokeRect(x0, y0, x1 - x0, y1 - y0);
      context.fillRect(x0, y0, x1 - x0, y1 - y0);
    },
  };
}

// An outline drawn by hand.
function around(desk: Desk, first: Point, done: (path: number[]) => void): Gesture {
  const points = [first];
  return {
    move: (more) => {
      for (const point of more) if (far(desk, points[points.length - 1]!, point) >= 2) points.push(point);
    },
    end: () => {
      const path = points.flatMap((point) => [Math.round(point.x * 1000) / 1000, Math.round(point.y * 1000) / 1000, 1]);
      if (points.length > 2) done(path.slice(0, 3 * desk.drawing.hello.value!.limits.path));
    },
    cancel: () => undefined,
    draw: (context) => {
      context.beginPath();
      for (const { x, y } of points) context.lineTo(...desk.viewport.px(x, y));
      context.fill("evenodd");
      context.stroke();
    },
  };
}

// How far apart two places are, px of the page.
function far(desk: Desk, a: Point, b: Point): number {
  return (Math.hypot(a.x - b.x, a.y - b.y) * desk.viewport.scale) / desk.viewport.ratio;
}
