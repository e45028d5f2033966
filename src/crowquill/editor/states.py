"""States: what a drawing was after so many entries of its log, kept beside it, so that not all of them are done again.

They are a convenience: what is damaged, of another version or of another log is passed over, and the log itself is followed.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import threading
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

from crowquill.editor import log
from crowquill.editor.drawing import Drawing
from crowquill.editor.log import Entry
from crowquill.editor.opening import Header
from crowquill.editor.packing import packed, parts, unpacked
from crowquill.formats import replace_files

SCHEMA = 1
FOLDER = ".states"  # after the log's name
SUFFIX = ".state"
MOST = 8  # states kept
ROOM = 256 * 2**20  # bytes of them all; the last is kept if it alone is no larger


class States:
    """The states that are kept of one log. Calls of several threads wait for one another."""

    def __init__(self, path: Path, header: Header, begun: Drawing) -> None:
        """Those of a log at a path, which begins with a header and a drawing."""
        self.folder = path.with_name(path.name + FOLDER)
        self._begun = begun
        self._first = hashlib.sha256(log.line(header.data())).digest()
        self._digests: list[tuple[Entry, bytes]] = []
        self._lock = threading.Lock()

    @cached_property
    def _known(self) -> list[Any]:
        return parts(self._begun)

    def last(self, after: int, until: int, entries: Sequence[Entry]) -> tuple[int, Drawing] | None:
        """The last sound state after more than `after` and no more than `until` of these entries, and after how many; None without one."""
        with self._lock:
            for count in sorted(self._counts(), reverse=True):
                if after < count <= until:
                    with contextlib.suppress(OSError, ValueError):
                        return count, self._read(count, entries)
        return None

    def keep(self, entries: Sequence[Entry], drawing: Drawing) -> str:
        """Keeps the state after all these entries; why it could not be, empty where it was. Too large a one is not kept."""
        with self._lock:
            try:
                body = packed(replace(drawing, facts={}, notes=()), self._known)
                if len(body) > ROOM:
                    return ""
                told = {**self._told(entries), "sha256": hashlib.sha256(body).hexdigest()}
                self.folder.mkdir(exist_ok=True)
                self._thin(len(entries), len(body))
                replace_files([(self._path(len(entries)), lambda file: file.write(log.line(told) + body))])
            except OSError as error:
                return (error.strerror or "failed").lower()
            except ValueError as error:
                return str(error)
        return ""

    def clear(self) -> None:
        """Removes all of them, and their folder where nothing else is in it."""
        with self._lock, contextlib.suppress(OSError):
            for count in self._counts():
                self._path(count).unlink(missing_ok=True)
            self.folder.rmdir()

    def _counts(self) -> list[int]:
        """After how many entries there are states."""
        names = [path.name.removesuffix(SUFFIX) for path in self.folder.glob(f"*{SUFFIX}")] if self.folder.is_dir() else []
        return [int(name) for name in names if name.isdecimal() and name.isascii()]

    def _path(self, count: int) -> Path:
        return self.folder / f"{count:07d}{SUFFIX}"

    def _told(self, entries: Sequence[Entry]) -> dict[str, Any]:
        """What the first line says of the state after all these entries: whose it is."""
        lines = self._digest(entries).hex()
        return {"crowquill": "state", "schema": SCHEMA, "version": version("crowquill"), "entries": len(entries), "log": lines}

    def _digest(self, entries: Sequence[Entry]) -> bytes:
        """The digest of the header and these entries: of each entry and the digest before it, so that only what is new is read."""
        known = self._digests
        same = next((k for k, (one, entry) in enumerate(zip(known, entries, strict=False)) if one[0] is not entry), len(known))
        if same < len(entries):
            del known[same:]
            for entry in entries[same:]:
                before = known[-1][1] if known else self._first
                known.append((entry, hashlib.sha256(before + log.line(entry.data())).digest()))
        return known[len(entries) - 1][1] if entries else self._first

    def _read(self, count: int, entries: Sequence[Entry]) -> Drawing:
        """A state. ValueError for one that is damaged, or not of these entries, OSError where it cannot be read."""
        first, _, body = self._path(count).read_bytes().partition(b"\n")
        if _plain(first) != {**self._told(entries[:count]), "sha256": hashlib.sha256(body).hexdigest()}:
            raise ValueError("it is of another log, or damaged")
        found = unpacked(body, self._known)
        if not isinstance(found, Drawing):
            raise ValueError("it is no drawing")
        return found

    def _thin(self, count: int, size: int) -> None:
        """Makes room for a state of a size after so many entries. Those after as many and more are of what was undone, and go;
        then, of those that are too many, the one whose neighbours are nearest to each other for how long ago it was.
        """
        sizes = {}
        for one in self._counts():
            with contextlib.suppress(OSError):
                if one < count:
                    sizes[one] = self._path(one).stat().st_size
                else:
                    self._path(one).unlink()
        while sizes and (len(sizes) >= MOST or sum(sizes.values()) + size > ROOM):
            order = [0, *sorted(sizes), count]
            gone = min(order[1:-1], key=lambda k: (order[order.index(k) + 1] - order[order.index(k) - 1]) / (count - k))
            del sizes[gone]
            with contextlib.suppress(OSError):
                self._path(gone).unlink()


def _plain(text: bytes) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None
