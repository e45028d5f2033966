"""Pages: what each shows, and how it catches up with the drawing."""

from __future__ import annotations

import asyncio
import json
from typing import Any, Protocol

from starlette.websockets import WebSocket

from crowquill.editor import frames, telling
from crowquill.editor.drawing import Drawing
from crowquill.editor.requests import told
from crowquill.editor.session import Session


class Shown(Protocol):
    """What pages show: a session whose drawing has a revision, and what is under way."""

    session: Session
    revision: int

    @property
    def busy(self) -> telling.Json | None:
        """What is under way."""


class Page:
    """A page: its socket, what it shows, what is still to be said to it, how many requests it has open, and its groups in the log."""

    def __init__(self, socket: WebSocket) -> None:
        self.socket = socket
        self.open = 0
        self.changes = 0  # of these, those that wait and are to change something
        self.groups: dict[int, int] = {}
        self._session: Session | None = None
        self._shown: Drawing | None = None
        self._paper: Any = None
        self._revision = 0
        self._said: list[telling.Json | bytes] = []
        self._wake = asyncio.Event()
        self._wake.set()

    def say(self, message: telling.Json | bytes) -> None:
        """Says something, after what has changed before; of the steps of one work only the last is kept."""
        if isinstance(message, dict) and message["say"] == "step":
            self._said = [one for one in self._said if isinstance(one, bytes) or (one["say"], one.get("n")) != ("step", message["n"])]
        self._said.append(message)
        self._wake.set()

    def answer(self, n: int, found: telling.Json) -> None:
        """Answers a request."""
        self.open -= 1
        self.say({"say": "done", "n": n, "notes": [], **found})

    def refuse(self, n: int, error: Exception) -> None:
        """Answers a request that failed."""
        self.open -= 1
        self.say({"say": "error", "n": n, "text": told(error)})

    def wake(self) -> None:
        """Has the page catch up with what has changed."""
        self._wake.set()

    def forget(self) -> None:
        """Has the page be told all of the drawing again."""
        self._shown, self._revision = None, 0
        self._wake.set()

    async def follow(self, hub: Shown) -> None:
        """Sends what changes, and what is said, as fast as the page takes it."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            said, self._said = self._said, []
            await self._catch_up(hub)
            for message in said:
                await self._send(message)

    async def _send(self, message: telling.Json | bytes) -> None:
        if isinstance(message, bytes):
            await self.socket.send_bytes(message)
        else:
            await self.socket.send_text(json.dumps(message, allow_nan=False))

    async def _catch_up(self, hub: Shown) -> None:
        """Sends what is other than what the page shows; in one piece, so that no other frame comes between."""
        session, drawing, revision = hub.session, hub.session.drawing, hub.revision
        if self._session is not session:
            self._session, self._paper = session, None
        if self._paper != (paper := _paper(drawing)):
            await self._send(telling.hello(session, drawing, session.notes if self._paper is None else ()))
            self._paper = paper
            self.forget()
        if self._revision == revision:
            return
        shown = self._shown
        parts = [frames.of_items(shown, drawing, revision), frames.of_maps(shown, drawing, revision)]
        every = [part for part in parts if part]
        state = telling.state(drawing, shown, session.history.names())
        self._shown, self._revision = drawing, revision
        await self._send(state | {"revision": revision, "frames": len(every), "busy": hub.busy})
        for frame in every:
            await self._send(frame)


def _paper(drawing: Drawing) -> Any:
    """What pages lay out by: the paper, its margin, and where the picture lies."""
    return drawing.size, drawing.margin, tuple(drawing.picture.corner.tolist()), drawing.picture.size
