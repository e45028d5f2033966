// The knobs of every operation as they are set on this page. Brushes share those that mean the same for all of them.

import type { Knob, KnobValue, Operation, Params } from "./protocol";
import { Signal } from "./watch";

const SHARED = new Set(["size", "strength", "falloff"]); // of every brush
const ELSEWHERE = new Set(["path", "on", "layer"]); // set by where and how a tool is used

export class Settings {
  readonly changed = new Signal<string>(); // the knob's name
  private readonly own = new Map<string, KnobValue>();

  // The knobs of an operation that have a control of their own.
  static shown(operation: Operation): Knob[] {
    return operation.knobs.filter((knob) => !ELSEWHERE.has(knob.name));
  }

  get(operation: Operation, name: string): KnobValue {
    const kept = this.own.get(this.key(operation, name));
    return kept === undefined ? (operation.knobs.find((knob) => knob.name === name)?.default ?? null) : kept;
  }

  set(operation: Operation, name: string, value: KnobValue): void {
    this.own.set(this.key(operation, name), value);
    this.changed.say(name);
  }

  // A number among the knobs, times a factor and within its range.
  scale(operation: Operation, name: string, factor: number): void {
    const knob = operation.knobs.find((one) => one.name === name);
    const value = this.get(operation, name);
    if (!knob || typeof value !== "number") return;
    const grown = Number((value * factor).toPrecision(2));
    this.set(operation, name, Math.min(knob.high ?? grown, Math.max(Math.max(knob.low ?? grown, 0.01), grown)));
  }

  // What is sent: every knob that is not as it comes.
  params(operation: Operation): Params {
    const params: Params = {};
    for (const knob of Settings.shown(operation)) {
      const value = this.get(operation, knob.name);
      if (value !== null && JSON.stringify(value) !== JSON.stringify(knob.default)) params[knob.name] = value;
    }
    return params;
  }

  private key(operation: Operation, name: string): string {
    return SHARED.has(name) && operation.knobs.some((knob) => knob.name === "path") && operation.group !== "relax"
      ? name
      : `${operation.name} ${name}`;
  }
}
