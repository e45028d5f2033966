"""Drawings to edit, and a page that edits over the socket as a browser would."""

from __future__ import annotations

import errno
import hashlib
import json
import os
import struct
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pytest
import shapely
from PIL import Image
from websockets.sync.client import ClientConnection, connect

from crowquill.editor.drawing import Drawing, Layer, Map, Picture
from crowquill.editor.items import COLUMNS, Items
from crowquill.editor.operations import applied
from crowquill.editor.operations.marking import library
from crowquill.editor.server import Server, listening
from crowquill.editor.session import Session
from crowquill.sheet import Ink

SIZE = (80.0, 60.0)
ART = (60.0, 40.0)
CORNER = np.array([10.0, 10.0])
PATIENCE = 60  # s, a guard against a hang


def drawing(n: int = 0, seed: int = 0, *, canvas: shapely.Geometry | None = None) -> Drawing:
    """A layer of n dots anywhere on a canvas whose tone rises from left to right."""
    picture = Picture(CORNER, ART, shapely.box(0, 0, *ART) if canvas is None else canvas)
    tone = Map.of(np.tile(np.linspace(0.1, 0.9, 60), (40, 1)))
    bare = Drawing(SIZE, picture, tone, (Layer(1, "", Ink(), Items.none()),), next_layer=2)
    bare, at = bare.with_kinds(library("nib-03"))
    xy = np.random.default_rng(seed).uniform(CORNER + 0.5, CORNER + np.array(ART) - 0.5, (n, 2))
    return bare.added(bare.layers[0], Items.of(0, xy, scale=0.3, kind=at[np.arange(n) % len(at)]))


def items(of: Drawing, layer: int = 1) -> Items:
    """The items of a layer."""
    return of.layer(layer).items


def way(*points: tuple[float, float], pressure: float = 1.0) -> list[float]:
    """The path of a brush through points."""
    return [value for x, y in points for value in (x, y, pressure)]


def do(of: Drawing, op: str, seed: int = 0, **params: Any) -> Drawing:
    """The drawing that an operation makes."""
    return applied(of, op, params, seed)


def digest(of: Drawing) -> str:
    """The same for drawings that are the same in every number."""
    total = hashlib.sha256()
    for layer in of.layers:
        total.update(repr((layer.id, layer.name, layer.ink, layer.hidden, layer.locked, layer.tiling)).encode())
        for name in COLUMNS:
            total.update(getattr(layer.items, name).tobytes())
    total.update(of.tone.values.tobytes() + (of.wish.values.tobytes() if of.wish else b"") + repr((of.first, of.next_layer)).encode())
    return total.hexdigest()


def with_items(of: Drawing, **columns: Any) -> Drawing:
    """The drawing with other columns in its first layer."""
    return of.with_layers(replace(of.layers[0], items=replace(items(of), **columns)))


def picture(path: Path, size: tuple[int, int] = (60, 40)) -> Path:
    """A picture that is darker to the right, in a file."""
    ramp = np.linspace(230, 30, size[0]).astype(np.uint8)
    Image.fromarray(np.tile(ramp, (size[1], 1))).save(path)
    return path


@contextmanager
def serving(session: Session) -> Iterator[Server]:
    """A server of a session on a free port, in a thread."""
    server = Server(session, listening(0))
    thread = threading.Thread(target=server.serve_until_stopped, daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.should_exit = True
        thread.join(PATIENCE)
        assert not thread.is_alive()


@contextmanager
def full_disk(session: Session) -> Iterator[None]:
    """As long as it lasts, nothing of a session's log finds room."""
    write, handle = os.write, session.journal._file

    def full(target: int, data: Any) -> int:
        if target == handle:
            raise OSError(errno.ENOSPC, "No space left on device")
        return write(target, data)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "write", full)
        yield


COLUMN = (
    (1, "um", "<i4", 2),
    (2, "scale", "<u4", 1),
    (4, "turn", "<u2", 1),
    (8, "kind", "<u4", 1),
    (16, "fill", "<u4", 1),
    (32, "flags", "u1", 1),
)


class Address(Protocol):
    """What has an address."""

    @property
    def address(self) -> str:
        """Where the page is."""


@dataclass
class Page:
    """What a page knows: all by the protocol, nothing by the server's own means."""

    socket: ClientConnection
    hello: dict[str, Any] = field(default_factory=dict)
    state: dict[str, Any] = field(default_factory=dict)
    items: dict[int, dict[str, Any]] = field(default_factory=dict)
    maps: dict[int, Any] = field(default_factory=dict)
    kinds: dict[int, dict[str, Any]] = field(default_factory=dict)
    lines: list[tuple[int, Any]] = field(default_factory=list)
    said: list[dict[str, Any]] = field(default_factory=list)
    n: int = 0

    @classmethod
    def at(cls, server: Address) -> Page:
        """A page at a server's address, once it shows the drawing."""
        origin = server.address.rsplit("/", 2)[0]
        page = cls(connect(f"ws{server.address[4:]}socket", origin=origin).__enter__())
        while not page.state:
            page.hear()
        return page

    def hear(self) -> dict[str, Any]:
        """The next message, once its frames have come."""
        data = self.socket.recv(PATIENCE)
        while isinstance(data, bytes):
            self._take(data)
            data = self.socket.recv(PATIENCE)
        message: dict[str, Any] = json.loads(data)
        self.said.append(message)
        if message["say"] == "hello":
            self.hello = message
        if message["say"] == "state":
            if message["reset"]:
                self.items, self.maps = {}, {}
            self.state = message
            self.kinds |= {kind["id"]: kind for kind in message["kinds"]}
            for _ in range(message["frames"]):
                frame = self.socket.recv(PATIENCE)
                assert isinstance(frame, bytes) and struct.unpack_from("<4I", frame)[1] == message["revision"]
                self._take(frame)
        return message

    def ask(self, do: str, **more: Any) -> dict[str, Any]:
        """What a request is answered with."""
        n = self.send(do, **more)
        return self.answer(n)

    def send(self, do: str, **more: Any) -> int:
        """Sends a request; its number."""
        self.n += 1
        self.socket.send(json.dumps({"do": do, "n": self.n, **more}))
        return self.n

    def answer(self, n: int) -> dict[str, Any]:
        """The answer to a request of a number."""
        while True:
            message = self.hear()
            if message.get("n") == n and message["say"] in ("done", "error"):
                return message

    def apply(self, op: str, *, times: int = 1, group: int | None = None, **params: Any) -> dict[str, Any]:
        """What came of an operation."""
        more = {} if group is None else {"group": group}
        return self.ask("apply", op=op, params=params, times=times, **more)

    def _take(self, frame: bytes) -> None:
        sort, _, chunks, _ = struct.unpack_from("<4I", frame)
        at = 16
        for _ in range(chunks):
            at = {1: self._items, 2: self._map, 3: self._lines}[sort](frame, at)
            assert at % 4 == 0
        assert at == len(frame)

    def _items(self, frame: bytes, at: int) -> int:
        layer, n, bits, first = struct.unpack_from("<4I", frame, at)
        at += 16
        ids = list(range(first, first + n))
        if not bits & 64:
            ids = np.frombuffer(frame, "<u4", n, at).tolist()
            at += 4 * n
        if not bits & ~64:
            for id in ids:
                del self.items[id]
        if bits & 128:
            at = self._steps(frame, at, ids)
            bits &= ~1
        for bit, name, kind, width in COLUMN:
            if bits & bit:
                column = np.frombuffer(frame, kind, n * width, at)
                at += -(-column.nbytes // 4) * 4
                rows = column.reshape(width, n).T if width > 1 else column
                for id, value in zip(ids, rows.tolist(), strict=True):
                    self.items.setdefault(id, {"layer": layer})[name] = value
                    self.items[id]["layer"] = layer
        return at

    def _steps(self, frame: bytes, at: int, ids: list[int]) -> int:
        for axis in (0, 1):
            for id, step in zip(ids, np.frombuffer(frame, "<i2", len(ids), at).tolist(), strict=True):
                x = self.items[id]["um"]
                x[axis] += step
            at += -(-2 * len(ids) // 4) * 4
        return at

    def _map(self, frame: bytes, at: int) -> int:
        number, top, left, h, w, rows, columns, _ = struct.unpack_from("<8I", frame, at)
        part = np.frombuffer(frame, "u1", h * w, at + 32).reshape(h, w)
        whole = self.maps.get(number, np.zeros((rows, columns), np.uint8)).copy()
        whole[top : top + h, left : left + w] = part
        self.maps[number] = whole
        return at + 32 + -(-h * w // 4) * 4

    def _lines(self, frame: bytes, at: int) -> int:
        what, paths, points, _ = struct.unpack_from("<4I", frame, at)
        start = np.frombuffer(frame, "<u4", paths + 1, at + 16)
        xy = np.frombuffer(frame, "<f4", 2 * points, at + 20 + 4 * paths).reshape(-1, 2)
        assert start[-1] == points
        self.lines.append((what, np.split(xy, start[1:-1])))
        return at + 20 + 4 * paths + 8 * points


def shown(of: Drawing) -> dict[int, dict[str, Any]]:
    """The items of a drawing as a page would have them."""
    found = {}
    for layer in of.layers:
        part = layer.items
        for k, id in enumerate(part.id.tolist()):
            flags = int(part.selected[k]) | int(part.frozen[k]) << 1
            own = {name: getattr(part, name)[k].tolist() for name in ("um", "scale", "turn", "kind", "fill")}
            found[id] = {"layer": layer.id, **own, "flags": flags}
    return found
