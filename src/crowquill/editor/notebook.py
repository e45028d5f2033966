"""The editor in a cell of a notebook: the same page, its words carried by the notebook's own line to the kernel in place of a network."""

from __future__ import annotations

import asyncio
import tempfile
import threading
from collections.abc import Coroutine, MutableMapping
from importlib.resources import files
from pathlib import Path
from typing import Any

import anywidget
import traitlets

from crowquill.editor.drawing import sheet_of
from crowquill.editor.server import HOST, application
from crowquill.editor.session import Session
from crowquill.formats import save
from crowquill.sheet import Sheet

TOKEN, PORT = "notebook", 0  # of the application, which nobody reaches but through the widget
HEADERS = [(b"host", f"{HOST}:{PORT}".encode()), (b"origin", f"http://{HOST}:{PORT}".encode())]
Event = MutableMapping[str, Any]


def _file(name: str) -> str:
    return (files("crowquill.editor") / "page" / name).read_text(encoding="utf-8")


def page() -> str:
    """The editor's page as one text, its style and script inside it."""
    script = _file("editor.js").replace("</script", "<\\/script")
    whole = _file("index.html").replace('<script src="editor.js"></script>', f"<script>{script}</script>")
    return whole.replace('<link rel="stylesheet" href="editor.css">', f"<style>{_file('editor.css')}</style>")


class Canvas(anywidget.AnyWidget):
    """A drawing under the pen in a notebook; `sheet` is what has become of it.

    >>> canvas = Canvas(sheet)  # doctest: +SKIP
    >>> canvas  # doctest: +SKIP
    >>> save(canvas.sheet, "edited.pdf")  # doctest: +SKIP

    A sheet is edited as a copy in a folder of its own, which close() takes away; a file's edits, and what is exported, lie beside it.
    """

    _esm = _file("notebook.js")
    page = traitlets.Unicode().tag(sync=True)
    height = traitlets.Int(640).tag(sync=True)

    def __init__(self, drawing: Sheet | str | Path, height: int = 640) -> None:
        super().__init__(page=page(), height=height)
        self._folder = tempfile.TemporaryDirectory(prefix="crowquill-", ignore_cleanup_errors=True)
        if isinstance(drawing, Sheet):
            save(drawing, Path(self._folder.name) / "sheet.svg")
            drawing = Path(self._folder.name) / "sheet.svg"
        self._session = Session(Path(drawing))
        self._views: dict[str, asyncio.Queue[Event]] = {}
        self._loop = asyncio.new_event_loop()
        self._tasks: set[asyncio.Task[None]] = set()
        self._started, self._ended = False, asyncio.Event()
        self._app = application(self._session, TOKEN, PORT)
        self._thread = threading.Thread(target=self._lives, daemon=True)
        self._thread.start()
        self.on_msg(lambda _widget, content, _buffers: self.hear(content))

    @property
    def sheet(self) -> Sheet:
        """The drawing as it is now."""
        return sheet_of(self._session.drawing)

    def close(self) -> None:
        """Ends the editor; what was edited stays in `sheet`."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._ended.set)
            self._thread.join()
            self._session.close()
            self._folder.cleanup()
        super().close()

    def hear(self, content: Event) -> None:
        """Takes what a view says: that it is there, or goes, a request of the page's, or which of its files it wants."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._take, str(content.get("view")), content)

    def _take(self, view: str, content: Event) -> None:
        if "get" in content:
            self._begin(self._got(view, str(content["get"])))
        elif "open" in content:
            self._views[view] = asyncio.Queue()
            self._views[view].put_nowait({"type": "websocket.connect"})
            self._begin(self._opened(view, self._views[view]))
        elif view in self._views and "text" in content:
            self._views[view].put_nowait({"type": "websocket.receive", "text": str(content["text"])})
        elif view in self._views and "close" in content:
            self._views.pop(view).put_nowait({"type": "websocket.disconnect", "code": 1001})

    def _lives(self) -> None:
        """Runs the application until the widget is closed."""
        try:
            self._loop.run_until_complete(self._app({"type": "lifespan"}, self._stages, _nothing))
        finally:
            self._loop.close()

    async def _stages(self) -> Event:
        """Of the application's life: its start, and once it shall end and all views are gone, its end."""
        if not self._started:
            self._started = True
            return {"type": "lifespan.startup"}
        await self._ended.wait()
        for view, queue in self._views.items():
            self.send({"view": view, "closed": 1001})
            queue.put_nowait({"type": "websocket.disconnect", "code": 1001})
        await asyncio.gather(*self._tasks, return_exceptions=True)
        return {"type": "lifespan.shutdown"}

    def _begin(self, work: Coroutine[Any, Any, None]) -> None:
        task = self._loop.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    async def _opened(self, view: str, queue: asyncio.Queue[Event]) -> None:
        """Serves a view's page as if by a socket."""

        async def send(event: Event) -> None:
            if event.get("bytes") is not None:
                self.send({"view": view, "frame": True}, [event["bytes"]])
            elif event.get("text") is not None:
                self.send({"view": view, "text": event["text"]})
            elif event["type"] == "websocket.close":
                self.send({"view": view, "closed": event.get("code", 1000)})

        await self._app(_scope("websocket", "socket"), queue.get, send)

    async def _got(self, view: str, name: str) -> None:
        """Sends a file of the page's."""
        status, kind, body = 0, "", b""

        async def send(event: Event) -> None:
            nonlocal status, kind, body
            if event["type"] == "http.response.start":
                status, kind = event["status"], dict(event["headers"]).get(b"content-type", b"").decode()
            body += event.get("body", b"")

        await self._app(_scope("http", name), _asked, send)
        self.send({"view": view, "got": name, "type": kind}, [body] if status == 200 else [])


async def _nothing(_event: Event) -> None:
    pass


async def _asked() -> Event:
    return {"type": "http.request", "body": b""}


def _scope(kind: str, name: str) -> Event:
    path = f"/{TOKEN}/{name}"
    return {
        "type": kind,
        "path": path,
        "raw_path": path.encode(),
        "query_string": b"",
        "method": "GET",
        "headers": HEADERS,
        "subprotocols": [],
    }
