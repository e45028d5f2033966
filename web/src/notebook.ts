// The editor in a notebook's cell: the page in a frame of its own, its words carried to the kernel and back.

import type { FromKernel, ToKernel } from "./wire";

// What of a widget's model is used.
interface Model {
  get: (name: string) => unknown;
  send: (content: object) => void;
  on: Listens;
  off: Listens;
}

interface Listens {
  (event: "msg:custom", heard: (content: Said, buffers: DataView[]) => void): void;
  (event: "comm_live_update", heard: () => void): void; // the kernel has ended or begins anew
}

const ENDED = 1001; // as a socket is closed by a server that ends

type Said = { view: string } & ({ text: string } | { frame: true } | { got: string; type: string } | { closed: number });

function render({ model, el }: { model: Model; el: HTMLElement }): () => void {
  const view = `${Date.now()} ${Math.random()}`; // crypto.randomUUID wants https, which not every notebook has
  const frame = document.createElement("iframe");
  const channel = new MessageChannel();
  const heard = (said: Said, buffers: DataView[]): void => {
    if (said.view !== view) return;
    const bytes = buffers[0] ? copied(buffers[0]) : null;
    const message: FromKernel = "frame" in said ? { frame: bytes! } : "got" in said ? { ...said, data: bytes } : said;
    channel.port1.postMessage(message);
  };
  let alive = true;
  const end = (): void => {
    alive = false;
    channel.port1.postMessage({ closed: ENDED } satisfies FromKernel);
  };
  channel.port1.onmessage = ({ data }: MessageEvent<ToKernel>) => alive && model.send({ view, ...data });
  model.on("msg:custom", heard);
  model.on("comm_live_update", end);
  frame.title = "Crowquill's editor";
  Object.assign(frame.style, { width: "100%", height: `${Number(model.get("height"))}px`, border: "0" });
  frame.addEventListener("load", () => frame.contentWindow!.postMessage("crowquill", "*", [channel.port2]), { once: true });
  frame.srcdoc = String(model.get("page"));
  el.append(frame);
  return () => {
    model.off("msg:custom", heard);
    model.off("comm_live_update", end);
    if (alive) model.send({ view, close: true });
    channel.port1.close();
  };
}

function copied(view: DataView): ArrayBuffer {
  return view.buffer.slice(view.byteOffset, view.byteOffset + view.byteLength) as ArrayBuffer;
}

export default { render };
