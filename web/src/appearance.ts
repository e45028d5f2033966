// How the page looks: light or dark, what lies beneath the drawing, which guides are shown. This browser remembers it.

import type { Look, Under } from "./painting";
import { Signal, Watched, remembered } from "./watch";

export type Theme = "system" | "light" | "dark";

const LEAST = 0.5; // opacity of a map that is being painted

export class Appearance {
  readonly theme = remembered<Theme>("theme", "system");
  readonly under = remembered<Under>("under", "picture");
  readonly instead = new Watched<Under | null>(null); // shown beneath while it is painted
  readonly opacity = remembered<number>("opacity", 0.25);
  readonly rulers = remembered<boolean>("rulers", true);
  readonly guides = remembered<boolean>("guides", true);
  readonly keys = remembered<boolean>("keys", true); // shortcuts of one character, which can be in the way of those who speak to the page
  readonly changed = new Signal();
  private readonly colours = new Map<string, string>();

  constructor() {
    const system = matchMedia("(prefers-color-scheme: dark)");
    const dress = (): void => {
      const dark = this.theme.value === "dark" || (this.theme.value === "system" && system.matches);
      document.documentElement.dataset.theme = dark ? "dark" : "light";
      this.colours.clear();
      this.changed.say();
    };
    this.theme.on(dress);
    system.addEventListener("change", dress);
    for (const one of [this.under, this.instead, this.opacity, this.rulers, this.guides]) one.on(() => this.changed.say());
  }

  // Light becomes dark, and dark light.
  flip(): void {
    this.theme.value = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  }

  // A colour of the page's style sheet.
  colour(name: string): string {
    let colour = this.colours.get(name);
    if (!colour) this.colours.set(name, (colour = getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim()));
    return colour;
  }

  get look(): Look {
    const { instead, under, opacity } = this;
    const tints = { selected: triple(this.colour("selected")), frozen: triple(this.colour("frozen")), lines: triple(this.colour("lines")) };
    const whole = { desk: this.colour("desk"), paper: "#fff", tints, under: instead.value ?? under.value };
    return { ...whole, opacity: instead.value ? Math.max(opacity.value, LEAST) : opacity.value };
  }
}

function triple(hex: string): [number, number, number] {
  const number = parseInt(hex.slice(1), 16);
  return [(number >> 16) & 255, (number >> 8) & 255, number & 255];
}
