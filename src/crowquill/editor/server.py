"""The server: a page, its socket and its pictures, for whoever on this machine knows the address."""

from __future__ import annotations

import asyncio
import contextlib
import io
import json
import secrets
import socket
from collections.abc import AsyncIterator, Callable
from importlib.resources import files
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket

from crowquill import formats
from crowquill.editor import telling
from crowquill.editor.hub import Hub
from crowquill.editor.pages import Page
from crowquill.editor.session import Session
from crowquill.sheet import Sheet

HOST = "127.0.0.1"
GRACE = 3  # s for pages to close when the server ends
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "worker-src 'self' blob:; font-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".ico": "image/x-icon",
    ".woff2": "font/woff2",
    ".map": "application/json",
}


class Guard:
    """Lets through what asks for this very host and, of sockets, what comes from a page of ours: no other site's page can."""

    def __init__(self, app: ASGIApp, hub: Hub, port: int) -> None:
        self.app = app
        self.hub = hub
        self.hosts = {f"{name}:{port}".encode() for name in (HOST, "localhost")}
        self.origins = {b"http://" + host for host in self.hosts}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answers 403 in place of the application where a header is another."""
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        host = [value for key, value in scope["headers"] if key == b"host"]
        origin = [value for key, value in scope["headers"] if key == b"origin"]
        at_home = len(host) == 1 and host[0] in self.hosts
        own = len(origin) == 1 and origin[0] in self.origins
        if at_home and (own or (scope["type"] == "http" and not origin)):
            await self.app(scope, receive, send)
        elif scope["type"] == "websocket":
            await WebSocket(scope, receive, send).close(1008)
        else:
            await Response("this address is for its own page only", 403)(scope, receive, send)


def application(session: Session, token: str, port: int) -> Guard:
    """The application that serves a session below a token."""
    hub = Hub(session)

    @contextlib.asynccontextmanager
    async def lifespan(_app: Starlette) -> AsyncIterator[None]:
        runner = asyncio.create_task(hub.run())
        try:
            yield
        finally:
            runner.cancel()
            with contextlib.suppress(asyncio.CancelledError, Exception):
                await runner

    async def connected(websocket: WebSocket) -> None:
        await websocket.accept()
        await hub.serve(Page(websocket))

    routes = [
        WebSocketRoute(f"/{token}/socket", connected),
        Route(f"/{token}/picture.png", _served(lambda: _picture(hub.session))),
        Route(f"/{token}/libraries.json", _served(lambda: json.dumps(telling.libraries()).encode(), "application/json")),
        Route(f"/{token}/still-{{layer:int}}.svg", _still(hub)),
        Route(f"/{token}/", _page),
        Route(f"/{token}/{{name}}", _page),
    ]
    app = Starlette(routes=routes, lifespan=lifespan)
    return Guard(app, hub, port)


def _answer(data: bytes, kind: str) -> Response:
    return Response(data, headers=HEADERS, media_type=kind)


def _missing() -> Response:
    return Response("there is nothing here", 404, headers=HEADERS)


def _served(make: Callable[[], bytes], kind: str = "image/png") -> Callable[[Request], Any]:
    async def answer(_request: Request) -> Response:
        return _answer(await asyncio.to_thread(make), kind)

    return answer


def _still(hub: Hub) -> Callable[[Request], Any]:
    """Answers with a layer that is not edited, as an SVG of the paper's size."""

    async def answer(request: Request) -> Response:
        drawing = hub.session.drawing
        found = [layer.still for layer in drawing.layers if layer.still and layer.id == request.path_params["layer"]]
        if not found:
            return _missing()
        data = await asyncio.to_thread(formats.to_bytes, Sheet(drawing.size, (found[0],)), "svg")
        return _answer(data, TYPES[".svg"])

    return answer


def _picture(session: Session) -> bytes:
    """The picture beneath as a PNG: its colours, or its tone as it was first."""
    from PIL import Image

    drawing = session.begun
    rgb = drawing.picture.rgb
    pixels = 255 - (drawing.tone.values >> 8).astype("uint8") if rgb is None else rgb
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "PNG", compress_level=1)
    return file.getvalue()


async def _page(request: Request) -> Response:
    """A file of the page, by its name; index.html without one."""
    name = request.path_params.get("name", "index.html")
    suffix = name[name.rfind(".") :] if "." in name else ""
    folder = files("crowquill.editor") / "page"
    if suffix not in TYPES or any(mark in name for mark in "/\\\0:") or name.startswith("."):
        return _missing()
    found = folder / name
    return _answer(found.read_bytes(), TYPES[suffix]) if found.is_file() else _missing()


def listening(port: int) -> socket.socket:
    """A socket that listens on a port of this machine alone, or on any free one for 0. Raises ValueError for one that cannot be had."""
    found = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)  # named, or asyncio leaves delays of 40 ms in
    try:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        found.bind((HOST, port))
        found.listen(128)
    except OSError as error:
        found.close()
        raise ValueError(f"port {port} cannot be had ({(error.strerror or 'failed').lower()}); give another --port, or 0 for any") from None
    return found


class Server(uvicorn.Server):
    """The server of one session; `address` is where its page is."""

    def __init__(self, session: Session, listener: socket.socket) -> None:
        """A server at a socket that listens, below a token of its own."""
        self.listener = listener
        self.port = listener.getsockname()[1]
        self.token = secrets.token_urlsafe(24)
        self.app = application(session, self.token, self.port)
        super().__init__(
            uvicorn.Config(
                self.app, log_level="error", access_log=False, lifespan="on", ws="websockets-sansio", ws_max_size=telling.FRAME,
                ws_per_message_deflate=False, server_header=False, timeout_graceful_shutdown=GRACE,
            )
        )  # fmt: skip

    @property
    def address(self) -> str:
        """Where the page is."""
        return f"http://{HOST}:{self.port}/{self.token}/"

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        """Tells the pages, then closes all."""
        await self.app.hub.close("the editor was closed; all edits are in its log")
        await super().shutdown(sockets)

    @property
    def session(self) -> Session:
        """What is edited now: a page may open another file."""
        return self.app.hub.session

    def serve_until_stopped(self) -> None:
        """Serves until a signal or `should_exit`, and closes session and socket; a signal is raised again at the end."""
        try:
            self.run(sockets=[self.listener])
        finally:
            self.listener.close()
            self.session.close()
