"""Packing: a drawing as bytes and back, to the bit. What it shares with the drawing that was begun with is named and not written."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

import numpy as np
import shapely

from crowquill import marks, sheet
from crowquill.editor import drawing, items
from crowquill.lettering import Words
from crowquill.paths import Paths

CLASSES: dict[str, type] = {
    f"{cls.__module__}.{cls.__name__}": cls
    for cls in (
        drawing.Drawing, drawing.Layer, drawing.Tiling, drawing.Picture, drawing.Map, items.Items, items.Kind, Paths, Words,
        marks.Glyph, marks.Patch, marks.Marks, sheet.Ink, sheet.Layer, sheet.Bitmap,
    )
}  # fmt: skip
NAMES = {cls: name for name, cls in CLASSES.items()}
LARGEST = 2**30  # bytes of a packed drawing once it is unpacked
EDGE = 8  # bytes that an array begins at a multiple of


def parts(value: Any) -> list[Any]:
    """All values of our classes, arrays and geometries in a value, each once, in an order that is the same for equal ones."""
    found: dict[int, Any] = {}

    def walk(one: Any) -> None:
        if id(one) in found:
            return
        if isinstance(one, (np.ndarray, shapely.Geometry)) or type(one) in NAMES:
            found[id(one)] = one
        for part in _inside(one):
            walk(part)

    walk(value)
    return list(found.values())


def _inside(value: Any) -> Iterator[Any]:
    if type(value) in NAMES:
        yield from (getattr(value, own.name) for own in fields(value))
    elif isinstance(value, (tuple, list)):
        yield from value


def packed(value: Any, known: list[Any]) -> bytes:
    """The bytes of a value. `known` are parts() of another, which whoever unpacks it has too. Raises ValueError for what is not ours."""
    whole = _Packer({id(part): k for k, part in enumerate(known)})
    tree = json.dumps(whole.told(value), separators=(",", ":"), allow_nan=False).encode()
    head = struct.pack("<Q", len(tree)) + tree
    return zlib.compress(head + bytes(-len(head) % EDGE) + b"".join(whole.arrays), 1)


class _Packer:
    """Turns values into plain data, and their arrays into bytes; each value once."""

    def __init__(self, known: dict[int, int]) -> None:
        self.known = known
        self.arrays: list[bytes] = []
        self.size = 0
        self.done: dict[int, int] = {}

    def told(self, value: Any) -> Any:
        """A value as JSON can hold it: a list of a letter and what it takes, or a plain value."""
        if value is None or isinstance(value, (bool, int, float, str)):
            return value
        if isinstance(value, np.generic):
            return value.item()
        if id(value) in self.known:
            return ["k", self.known[id(value)]]
        if id(value) in self.done:
            return ["o", self.done[id(value)]]
        if isinstance(value, (tuple, list)):
            return ["t" if isinstance(value, tuple) else "l", *map(self.told, value)]
        if isinstance(value, Mapping):
            return ["m", *([key, self.told(own)] for key, own in value.items())]
        made = self._made(value)
        self.done[id(value)] = len(self.done)
        return made

    def _made(self, value: Any) -> list[Any]:
        if isinstance(value, np.ndarray):
            return ["a", value.dtype.str, *value.shape, self._put(np.ascontiguousarray(value).tobytes())]
        if isinstance(value, shapely.Geometry):
            return ["g", *self._told_bytes(shapely.to_wkb(value))]
        if type(value) not in NAMES:
            raise ValueError(f"{type(value).__name__} is not packed")
        return ["c", NAMES[type(value)], *(self.told(getattr(value, own.name)) for own in fields(value))]

    def _told_bytes(self, data: bytes) -> tuple[int, int]:
        return len(data), self._put(data)

    def _put(self, data: bytes) -> int:
        """Where bytes begin that are added to those of arrays."""
        at, more = self.size, bytes(-len(data) % EDGE)
        self.arrays += [data, more]
        self.size += len(data) + len(more)
        return at


def unpacked(data: bytes, known: list[Any]) -> Any:
    """What was packed. Raises ValueError for bytes that are no such thing."""
    try:
        reader = zlib.decompressobj()
        whole = reader.decompress(data, LARGEST)
        if not reader.eof:
            raise ValueError("it is too large, or cut off")
        (length,) = struct.unpack_from("<Q", whole)
        tree = json.loads(whole[8 : 8 + length])
        return _Unpacker(memoryview(whole)[8 + length + -(8 + length) % EDGE :], known).value(tree)
    except (zlib.error, struct.error, LookupError, TypeError, AttributeError, RecursionError, shapely.errors.ShapelyError) as error:
        raise ValueError(f"it cannot be unpacked ({error})") from None


class _Unpacker:
    """Makes values of plain data and the bytes of arrays."""

    def __init__(self, data: memoryview, known: list[Any]) -> None:
        self.data = data
        self.known = known
        self.done: list[Any] = []

    def value(self, told: Any) -> Any:
        """The value that told() gave."""
        if not isinstance(told, list):
            return told
        letter, *rest = told
        if letter in "ko":
            return (self.known if letter == "k" else self.done)[rest[0]]
        if letter in "tl":
            return (tuple if letter == "t" else list)(map(self.value, rest))
        if letter == "m":
            return {key: self.value(own) for key, own in rest}
        made = self._made(letter, rest)
        self.done.append(made)
        return made

    def _made(self, letter: str, rest: list[Any]) -> Any:
        if letter == "a":
            dtype, *shape, at = rest
            array = np.frombuffer(self.data, np.dtype(dtype), int(np.prod(shape)), at).reshape(shape)
            array.setflags(write=False)
            return array
        if letter == "g":
            length, at = rest
            return shapely.from_wkb(bytes(self.data[at : at + length]))
        name, *values = rest
        return CLASSES[name](*map(self.value, values))
