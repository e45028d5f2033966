// How the page reaches its server: over the network, or from inside a notebook's cell through the port that the notebook gives.

export interface Wire {
  open: () => Socket;
  get: (name: string) => Promise<Blob | null>; // a file below the page's address; null where there is none
  readonly ended: string; // what is said when the other side has ended
}

// What of a WebSocket is used.
export interface Socket extends EventTarget {
  readonly readyState: number;
  send: (text: string) => void;
  close: (code?: number) => void;
}

export function network(): Wire {
  return {
    open() {
      const socket = new WebSocket(new URL("socket", location.href.replace(/^http/, "ws")));
      socket.binaryType = "arraybuffer";
      return socket;
    },
    async get(name) {
      const answer = await fetch(new URL(name, location.href));
      return answer.ok ? answer.blob() : null;
    },
    ended: "The server has ended. All is saved: start crowquill edit again and open the address that it prints.",
  };
}

// What goes through a notebook's port: to the kernel, and from it.
export type ToKernel = { open: true } | { text: string } | { get: string };
export type FromKernel = { text: string } | { frame: ArrayBuffer } | { got: string; type: string; data: ArrayBuffer | null } | { closed: number };

class PortSocket extends EventTarget implements Socket {
  readyState: number = WebSocket.CONNECTING;

  constructor(private readonly tell: (message: ToKernel) => void) {
    super();
    queueMicrotask(() => tell({ open: true }));
  }

  send(text: string): void {
    this.tell({ text });
  }

  // Takes what the kernel says; it is there once it says anything.
  hear(data: string | ArrayBuffer): void {
    if (this.readyState === WebSocket.CONNECTING) {
      this.readyState = WebSocket.OPEN;
      this.dispatchEvent(new Event("open"));
    }
    this.dispatchEvent(new MessageEvent("message", { data }));
  }

  close(code = 1000): void {
    this.readyState = WebSocket.CLOSED;
    this.dispatchEvent(new CloseEvent("close", { code }));
  }
}

export function through(port: MessagePort): Wire {
  let socket: PortSocket | null = null;
  const asked = new Map<string, ((blob: Blob | null) => void)[]>();
  const tell = (message: ToKernel): void => port.postMessage(message);
  port.onmessage = ({ data }: MessageEvent<FromKernel>) => {
    if ("text" in data) socket?.hear(data.text);
    else if ("frame" in data) socket?.hear(data.frame);
    else if ("closed" in data) socket?.close(data.closed);
    else {
      for (const done of asked.get(data.got) ?? []) done(data.data && new Blob([data.data], { type: data.type }));
      asked.delete(data.got);
    }
  };
  return {
    open: () => (socket = new PortSocket(tell)),
    get: (name) =>
      new Promise((done) => {
        asked.set(name, [...(asked.get(name) ?? []), done]);
        tell({ get: name });
      }),
    ended: "The kernel has ended, and the editor with it: run the cell again.",
  };
}
