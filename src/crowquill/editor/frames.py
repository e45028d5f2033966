"""Frames: what of a drawing a page has not got yet, as bytes; see PROTOCOL.md."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.editor.drawing import Drawing, Map
from crowquill.editor.items import Columns, Items, Mask
from crowquill.paths import Paths

ITEMS, RASTER, LINES = 1, 2, 3
BITS = {"um": 1, "scale": 2, "turn": 4, "kind": 8, "fill": 16, "flags": 32}
ALL = 63
RANGE, STEPS = 64, 128  # ids follow each other; places as steps from where they were
FAR = 2**15  # um: a step is shorter


def of_items(old: Drawing | None, new: Drawing, revision: int) -> bytes | None:
    """The frame that makes the items of an old drawing, or of none, those of a new one; None where they are the same."""
    before = {layer.id: layer.items for layer in old.layers} if old else {}
    after = {layer.id: layer.items for layer in new.layers}
    touched = {id: items for id, items in after.items() if before.get(id) is not items}
    changes = [chunk for id, items in touched.items() for chunk in _changed(id, before.get(id, Items.none()), items)]
    removals = []
    for id, items in before.items():
        if after.get(id) is not items:
            gone = items.id
            for there in touched.values():  # what is in another layer now has only moved
                gone = gone[~_among(gone, there.id)]
            if len(gone):
                removals.append(_chunk(id, gone, 0, {}))
    chunks = removals + changes
    return struct.pack("<4I", ITEMS, revision, len(chunks), 0) + b"".join(chunks) if chunks else None


def _among(ids: Columns, others: Columns) -> Mask:
    """Which ids are among others; by a table, as ids are small."""
    if ids is others:
        return np.ones(len(ids), bool)
    table = np.zeros(1 + max(ids.max(initial=0), others.max(initial=0)), bool)
    table[others] = True
    return np.asarray(table[ids])


def _changed(layer: int, old: Items, new: Items) -> list[bytes]:
    """Chunks for items that are new in a layer, and for those that changed there."""
    here: npt.NDArray[np.int64] | None = None
    there: npt.NDArray[np.int64] | None = None
    fresh = np.zeros(0, np.int64)
    if old.id is not new.id and not np.array_equal(old.id, new.id):
        known = _among(new.id, old.id)
        here, there, fresh = np.flatnonzero(known), np.flatnonzero(_among(old.id, new.id)), np.flatnonzero(~known)
    chunks = [_chunk(layer, new.id[fresh], ALL, _columns(new, fresh))] if len(fresh) else []
    rows, bits = _different(old, new, there, here)
    if len(rows):
        which = rows if here is None else here[rows]
        steps = _steps(old, new, rows, there, which, bits)
        columns = _columns(new, which, bits if steps is None else bits & ~BITS["um"])
        chunks.append(_chunk(layer, new.id[which], bits, columns, steps))
    return chunks


def _steps(old: Items, new: Items, rows: Any, there: Any, which: Any, bits: int) -> Columns | None:
    """How far the items at these rows have moved, um, where all of them moved less than FAR."""
    if not bits & BITS["um"]:
        return None
    way = new.um - old.um if there is None and len(rows) == len(new) else new.um[which] - old.um[rows if there is None else there[rows]]
    return way.astype("<i2") if way.min() > -FAR and way.max() < FAR else None


def _different(old: Items, new: Items, there: Any, here: Any) -> tuple[npt.NDArray[np.int64], int]:
    """Which of the items that both have differ, and the bits of the columns in which any does."""
    differs, bits = np.zeros(len(new) if here is None else len(here), bool), 0
    for name, bit in (("um", 1), ("scale", 2), ("turn", 4), ("kind", 8), ("fill", 16), ("selected", 32), ("frozen", 32)):
        before, after = getattr(old, name), getattr(new, name)
        if here is None and before is after:
            continue
        apart = before != after if here is None else before[there] != after[here]
        apart = apart.any(axis=1) if apart.ndim == 2 else apart
        if apart.any():
            differs |= apart
            bits |= bit
    return np.flatnonzero(differs), bits


def _columns(items: Items, rows: Any, bits: int = ALL) -> dict[str, Columns]:
    found = {name: getattr(items, name)[rows] for name, bit in BITS.items() if bits & bit and name != "flags"}
    if bits & BITS["flags"]:
        found["flags"] = items.selected[rows].astype(np.uint8) | items.frozen[rows].astype(np.uint8) << 1
    return found


def _chunk(layer: int, ids: Columns, bits: int, columns: dict[str, Columns], steps: Columns | None = None) -> bytes:
    if steps is not None:
        bits, columns = bits | STEPS, {**columns, "um": steps}
    follow = int(ids[-1]) - int(ids[0]) == len(ids) - 1
    parts = [struct.pack("<4I", layer, len(ids), bits | RANGE * follow, int(ids[0])), b"" if follow else ids.astype("<u4").tobytes()]
    for name, bit in BITS.items():
        if bits & bit:
            column = columns[name]
            for row in column.T if column.ndim == 2 else column[None]:
                data = row.astype(column.dtype.newbyteorder("<"), copy=False).tobytes()
                parts.append(data + bytes(-len(data) % 4))
    return b"".join(parts)


def of_maps(old: Drawing | None, new: Drawing, revision: int) -> bytes | None:
    """The frame of what changed in the tone and the importance; None where nothing did."""
    chunks = []
    for number, before, after in ((0, old.tone if old else None, new.tone), (1, old.wish if old else None, new.wish)):
        if after is not None and after is not before:
            chunks += _part(number, before, after)
        elif after is None and before is not None:  # importance undone: one half all over
            chunks += _part(number, before, Map(np.full(before.values.shape, 32767, np.uint16)))
    return struct.pack("<4I", RASTER, revision, len(chunks), 0) + b"".join(chunks) if chunks else None


def _part(number: int, before: Map | None, after: Map) -> list[bytes]:
    """A chunk for the rectangle of a map in which it changed."""
    h, w = after.values.shape
    top, bottom, left, right = 0, h, 0, w
    if before is not None and before.values.shape == (h, w):
        apart = before.values != after.values
        rows, columns = np.flatnonzero(apart.any(axis=1)), np.flatnonzero(apart.any(axis=0))
        if not len(rows):
            return []
        top, bottom, left, right = rows[0], rows[-1] + 1, columns[0], columns[-1] + 1
    data = (after.values[top:bottom, left:right] >> 8).astype(np.uint8).tobytes()
    head = struct.pack("<8I", number, top, left, bottom - top, right - left, h, w, 0)
    return [head + data + bytes(-len(data) % 4)]


def of_lines(what: int, paths: Paths, revision: int) -> bytes:
    """The frame of lines to be shown."""
    head = struct.pack("<8I", LINES, revision, 1, 0, what, len(paths), len(paths.xy), int(paths.closed))
    return head + paths.start.astype("<u4").tobytes() + paths.xy.astype("<f4").tobytes()
