"""The log: a line of JSON for the header, and one for each operation, undo or redo, in the order in which they came.

Every line is on the disk before the next is written. What is undone stays in the log; who reads it gets what counts in the end.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from crowquill.editor.opening import Header
from crowquill.vector import contents


@dataclass(frozen=True)
class Entry:
    """An operation with its parameters and seed. Neighbours of one group are undone together; `files` are SHA-256 of those it reads."""

    op: str
    params: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 0
    group: int = 0
    files: Mapping[str, str] = field(default_factory=dict)

    def data(self) -> dict[str, Any]:
        """The entry as JSON can hold it."""
        told: dict[str, Any] = {"op": self.op, "params": dict(self.params), "seed": self.seed, "group": self.group}
        return {**told, "files": dict(self.files)} if self.files else told


@dataclass(frozen=True)
class Found:
    """What a log holds: its header, the entries that are done, those that were undone and could be done again, and its sound bytes."""

    header: Header
    done: tuple[Entry, ...]
    undone: tuple[Entry, ...]
    sound: int


def line(data: Mapping[str, Any]) -> bytes:
    """A line of a log."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).encode() + b"\n"


def read(path: Path) -> Found:
    """What a log holds. A last line that was cut off, as by a crash, does not count.

    Raises ValueError, with the number of the line, for what is no log or is broken within, OSError for what cannot be read.
    """
    return parsed(contents(path), str(path))


def parsed(data: bytes, name: str) -> Found:
    """What the bytes of a log hold; errors call it `name`."""
    sound = data.rfind(b"\n") + 1
    lines = data[:sound].split(b"\n")[:-1]
    if lines and (not lines[-1].strip(b"\0") or not _is_json(lines[-1])):  # room that was made for a line that never came
        sound -= len(lines.pop()) + 1
    if not lines:
        raise ValueError(f"{name}: is no log of the editor: it has no whole line; move it away to begin anew")
    header = Header.parsed(_plain(lines[0], name, 1), name)
    done: list[Entry] = []
    undone: list[Entry] = []
    for number, text in enumerate(lines[1:], 2):
        told = _plain(text, name, number)
        try:
            _follow(told, done, undone)
        except ValueError as error:
            raise ValueError(f"{name}: line {number} {error}; restore the log, or move it away to begin anew") from None
    return Found(header, tuple(done), tuple(reversed(undone)), sound)


def _follow(told: Any, done: list[Entry], undone: list[Entry]) -> None:
    """Adds what a line says to what is done, and to the stack of what is undone."""
    if not isinstance(told, dict):
        raise ValueError("is no JSON object")
    if "op" in told:
        done.append(_entry(told))
        undone.clear()
        return
    if set(told) not in ({"undo"}, {"redo"}):
        raise ValueError("is neither an operation nor an undo or a redo")
    way, (count,) = next(iter(told)), told.values()
    source, target = (done, undone) if way == "undo" else (undone, done)
    if isinstance(count, bool) or not isinstance(count, int) or not 0 < count <= len(source):
        raise ValueError(f"has {way} {count!r} where there are {len(source)}")
    for _ in range(count):
        target.append(source.pop())


def _entry(told: Mapping[str, Any]) -> Entry:
    params, files = told.get("params", {}), told.get("files", {})
    seed, group = told.get("seed", 0), told.get("group", 0)
    whole = all(isinstance(value, int) and not isinstance(value, bool) and value >= 0 for value in (seed, group))
    tables = all(isinstance(table, dict) for table in (params, files))
    if not isinstance(told["op"], str) or not whole or not tables or set(told) - {"op", "params", "seed", "group", "files"}:
        raise ValueError("is no sound operation")
    return Entry(told["op"], params, seed, group, files)


def _is_json(text: bytes) -> bool:
    try:
        json.loads(text)
    except (ValueError, RecursionError):
        return False
    return True


def _plain(text: bytes, name: str, number: int) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        if number == 1:
            raise ValueError(f"{name}: is no log of the editor; give one, such as drawing.svg.edits") from None
        raise ValueError(f"{name}: line {number} is not sound JSON; restore the log, or move it away to begin anew") from None


class Journal:
    """A log that is written to: lines wait until they are written; what the disk does not take goes on waiting."""

    def __init__(self, path: Path, header: Header, sound: int = 0) -> None:
        """Opens the log after its sound bytes, cutting off what follows, or begins it. Raises OSError where it cannot be written."""
        self.path = path
        self._failure: OSError | None = None
        self._waiting = b""
        self._lines = 0
        self._sound = sound
        self._file = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o644)
        try:
            os.ftruncate(self._file, sound)
            if not sound:
                self.append(header.data())
                self.write()
                if self._failure:
                    raise OSError(self._failure.errno, self._failure.strerror, str(path))
                _settle_folder(path.parent)
        except OSError:
            self.close()
            if not sound:
                path.unlink(missing_ok=True)
            raise

    @property
    def waiting(self) -> int:
        """How many lines are not on the disk yet."""
        return self._lines

    @property
    def error(self) -> str:
        """Why lines are not on the disk yet."""
        return (self._failure.strerror or "failed").lower() if self._failure else ""

    def append(self, *told: Mapping[str, Any]) -> None:
        """Adds lines that wait to be written."""
        self._waiting += b"".join(map(line, told))
        self._lines += len(told)

    def write(self) -> None:
        """Writes all that waits to the disk. Where that fails it goes on waiting, and `error` says why."""
        if not self._waiting:
            return
        try:
            os.lseek(self._file, self._sound, os.SEEK_SET)
            rest = memoryview(self._waiting)
            while rest:
                rest = rest[os.write(self._file, rest) :]
            os.fsync(self._file)
        except OSError as error:
            self._failure = error
            self._cut()
            return
        self._sound += len(self._waiting)
        self._waiting, self._lines, self._failure = b"", 0, None

    def _cut(self) -> None:
        """Takes away what of a line was written, so that the log ends with a whole one."""
        try:
            os.ftruncate(self._file, self._sound)
        except OSError:
            return  # a reader leaves out what is cut off

    def close(self) -> None:
        """Closes the file."""
        os.close(self._file)


def _settle_folder(folder: Path) -> None:
    """A new file's name is on the disk only when its folder is; where folders cannot be opened, they need not be."""
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:
        return
    try:
        os.fsync(handle)
    except OSError:
        return
    finally:
        os.close(handle)
