// The line to the server: requests and their answers, what else it says, and the way back when the line breaks.

import type { Done, Failed, Request, Said } from "./protocol";
import { Signal, Watched } from "./watch";
import type { Socket, Wire } from "./wire";

export type Line = "connecting" | "open" | "broken" | "ended";

interface Waiting {
  done: (done: Done) => void;
  failed: (error: Error) => void;
}

const AGAIN = [200, 500, 1000, 2000, 4000]; // ms before each try, the last for all that follow
const ENDED = 1001; // the close code of a server that ends
const TOO_LARGE = 1009;

export class Link {
  readonly line = new Watched<Line>("connecting");
  readonly said = new Signal<Said>();
  readonly frames = new Signal<ArrayBuffer>();
  readonly lost = new Signal<string>();
  private socket: Socket | null = null;
  private number = 0;
  private tries = 0;
  private readonly waiting = new Map<number, Waiting>();

  constructor(readonly wire: Wire) {}

  connect(): void {
    const socket = this.wire.open();
    this.socket = socket;
    socket.addEventListener("open", () => {
      this.tries = 0;
      this.line.value = "open";
    });
    socket.addEventListener("message", (event) => {
      const { data } = event as MessageEvent<string | ArrayBuffer>;
      if (typeof data === "string") this.hear(JSON.parse(data) as Said);
      else this.frames.say(data);
    });
    socket.addEventListener("close", (event) => this.closed((event as CloseEvent).code));
  }

  // Sends a request; fulfilled with the server's `done`, rejected with what it says is wrong, or when the line breaks before.
  ask(request: Request): Promise<Done> {
    if (this.socket?.readyState !== WebSocket.OPEN) return Promise.reject(new Error("There is no connection to the server."));
    const n = ++this.number;
    this.socket.send(JSON.stringify({ ...request, n }));
    return new Promise((done, failed) => this.waiting.set(n, { done, failed }));
  }

  private hear(said: Said): void {
    if (said.say === "done" || said.say === "error") this.answered(said);
    if (said.say === "closed") this.line.value = "ended";
    this.said.say(said);
  }

  private answered(answer: Done | Failed): void {
    if (answer.say === "error" && answer.n === null) return this.lost.say(answer.text);
    const waiting = this.waiting.get(answer.n ?? 0);
    this.waiting.delete(answer.n ?? 0);
    if (answer.say === "done") waiting?.done(answer);
    else waiting?.failed(new Error(answer.text));
  }

  private closed(code: number): void {
    this.socket = null;
    const many = code === TOO_LARGE ? "That was more than the server takes at once." : "The connection broke before the server answered.";
    for (const { failed } of this.waiting.values()) failed(new Error(many));
    this.waiting.clear();
    if (code === ENDED) this.line.value = "ended";
    else if (this.line.value !== "ended") this.line.value = "broken";
    setTimeout(() => this.connect(), AGAIN[Math.min(this.tries++, AGAIN.length - 1)]);
  }
}
