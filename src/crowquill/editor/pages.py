"""Pages: what each shows, and how it catches up with the drawing."""

from __future__ import annotations

import asyncio
import json
from typing import Protocol

from starlette.websockets import WebSocket

from crowquill.editor import frames, telling
from crowquill.editor.drawing import Drawing
from crowquill.editor.session import Session


class Shown(Protocol):
    """What pages show: a session whose drawing has a revision, once it is ready, and what is under way."""

    session: Session
    revision: int
    ready: bool

    @property
    def busy(self) -> telling.Json | None:
        """What is under way."""


class Page:
    """A page: its socket, what it shows, and what is still to be said to it."""

    def __init__(self, socket: WebSocket) -> None:
        self.socket = socket
        self.shown: Drawing | None = None
        self.session: Session | None = None
        self.revision = -1
        self.open = 0
        self._said: list[telling.Json] = []
        self._wake = asyncio.Event()

    def say(self, message: telling.Json) -> None:
        """Says something, after what has changed before; of the steps of one work only the last is kept."""
        if message["say"] == "step":
            self._said = [one for one in self._said if one["say"] != "step" or one["n"] != message["n"]]
        self._said.append(message)
        self._wake.set()

    def wake(self) -> None:
        """Has the page catch up with what has changed."""
        self._wake.set()

    async def follow(self, hub: Shown) -> None:
        """Sends what changes, and what is said, as fast as the page takes it."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            said, self._said = self._said, []
            await self._catch_up(hub)
            for message in said:
                await self.socket.send_text(json.dumps(message, allow_nan=False))

    async def _catch_up(self, hub: Shown) -> None:
        if not hub.ready:
            return
        if self.session is not hub.session:
            self.session, self.shown, self.revision = hub.session, None, -1
            await self.socket.send_text(json.dumps(telling.hello(hub.session), allow_nan=False))
        if self.revision == hub.revision:
            return
        shown, drawing, revision = self.shown, hub.session.drawing, hub.revision
        told, parts = await asyncio.to_thread(_changes, shown, drawing, hub.session, revision)
        told |= {"revision": revision, "frames": len(parts), "busy": hub.busy}
        await self.socket.send_text(json.dumps(told, allow_nan=False))
        for part in parts:
            await self.socket.send_bytes(part)
        self.shown, self.revision = drawing, revision


def _changes(shown: Drawing | None, drawing: Drawing, session: Session, revision: int) -> tuple[telling.Json, list[bytes]]:
    """The state to be told, and its frames."""
    parts = [frames.of_items(shown, drawing, revision), frames.of_maps(shown, drawing, revision)]
    return telling.state(drawing, shown, session.history.names()), [part for part in parts if part]
