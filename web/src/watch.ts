// Values and events that others listen to.

export class Signal<T = void> {
  private readonly listeners = new Set<(value: T) => void>();

  on(listener: (value: T) => void): void {
    this.listeners.add(listener);
  }

  say(value: T): void {
    for (const listener of [...this.listeners]) listener(value);
  }
}

export class Watched<T> {
  private readonly changed = new Signal<T>();

  constructor(private now: T) {}

  get value(): T {
    return this.now;
  }

  set value(value: T) {
    if (Object.is(value, this.now)) return;
    this.now = value;
    this.changed.say(value);
  }

  // Calls a listener with the value now and whenever it changes.
  on(listener: (value: T) => void): void {
    listener(this.now);
    this.changed.on(listener);
  }
}

// A value that this browser keeps from one visit to the next.
export function remembered<T extends string | number | boolean>(name: string, first: T): Watched<T> {
  const key = `crowquill ${name}`;
  const watched = new Watched<T>(first);
  try {
    const kept = JSON.parse(localStorage.getItem(key) ?? "null") as unknown;
    if (typeof kept === typeof first) watched.value = kept as T;
  } catch {
    // a browser that keeps nothing, or something else under that name: the first value stays
  }
  watched.on((value) => {
    try {
      localStorage.setItem(key, JSON.stringify(value));
    } catch {
      // a browser that keeps nothing
    }
  });
  return watched;
}
