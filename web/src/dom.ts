// Elements, made in one call.

type Attributes = Record<string, string | number | boolean | null | undefined | ((event: never) => void)>;
type Child = Node | string | null | undefined | false;

// An element with attributes (true: there, false and null: not there; a function: a listener of that event) and children.
export function el<K extends keyof HTMLElementTagNameMap>(tag: K, attributes: Attributes = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  set(element, attributes);
  element.append(...children.filter((child): child is Node | string => child !== null && child !== undefined && child !== false));
  return element;
}

export function set(element: Element, attributes: Attributes): void {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name, value as EventListener);
    else if (value === null || value === undefined || value === false) element.removeAttribute(name);
    else element.setAttribute(name, value === true ? "" : String(value));
  }
}

// Gives an element other words; the same again would be laid out anew.
export function put(element: Element, words: string): void {
  if (element.textContent !== words) element.textContent = words;
}

let count = 0;

// An id that no other element has.
export function unique(name: string): string {
  return `${name}-${++count}`;
}

export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`the page has no element ${id}`);
  return element as T;
}

// An icon of 16 by 16, of path data drawn with a pen.
export function icon(d: string): SVGSVGElement {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  set(svg, { viewBox: "0 0 16 16", class: "icon", "aria-hidden": "true" });
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  set(path, { d });
  svg.append(path);
  return svg;
}

// A button with an icon alone: its name is for screen readers and shown as a tip.
export function iconButton(d: string, name: string, click: () => void, attributes: Attributes = {}): HTMLButtonElement {
  return el("button", { type: "button", class: "icon-button", "aria-label": name, title: name, click, ...attributes }, icon(d));
}

export function button(name: string, click: () => void, attributes: Attributes = {}): HTMLButtonElement {
  return el("button", { type: "button", click, ...attributes }, name);
}
