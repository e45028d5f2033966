// One file for the page and for its painter: in a thread without a document it paints. In a notebook the page is a frame without an
// address; it waits for the port through which it reaches the kernel.

import { begin } from "./page";
import { paint } from "./painter";
import { network, through } from "./wire";

if (typeof document === "undefined") paint();
else {
  const own = document.currentScript as HTMLScriptElement;
  if (own.src) begin(own.src, network());
  else {
    const script = URL.createObjectURL(new Blob([own.textContent ?? ""], { type: "text/javascript" }));
    window.addEventListener("message", (event) => event.ports[0] && begin(script, through(event.ports[0])), { once: true });
  }
}
