"""The table of a sheet that a project file keeps: what is said of it as plain data, and its numbers in one run of bytes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.lettering import FACES, Words
from crowquill.marks import TURN_STEPS, Glyph, Marks
from crowquill.paths import Array, Paths
from crowquill.sheet import Art, Bitmap, Ink, Layer, Sheet, outlined

SCHEMA = 1  # a reader refuses a newer one
SHARES = 10_000  # parts of a share of ink that are kept


def packed(sheet: Sheet) -> tuple[dict[str, Any], Iterator[bytes]]:
    """What is said of the sheet, and its numbers as one run of bytes, in pieces."""
    layers = []
    for layer in sheet.layers:
        ink: dict[str, Any] = {"name": layer.ink.name, "cmyk": list(layer.ink.cmyk), "pen": layer.ink.pen}
        ink |= {key: True for key in ("spot", "overprint") if getattr(layer.ink, key)}
        entry: dict[str, Any] = {"name": layer.name, "ink": ink}
        art = layer.art
        if isinstance(art, Marks):
            entry |= {"marks": len(art), "glyphs": [_glyph(glyph) for glyph in art.glyphs]}
        elif isinstance(art, Words) and art.font in FACES:
            entry |= {"words": list(art.text), "font": art.font, "at_mm": art.xy.tolist(), "high_mm": art.size.tolist()}
        elif isinstance(art, Bitmap):
            entry |= {"pixels": [art.width, len(art.bits)], "dpi": art.dpi, "at_mm": art.corner.tolist()}
        else:
            art = outlined(art)
            entry |= {"paths": len(art), "points": len(art.xy), "closed": art.closed, "cubic": art.cubic}
            if layer.fill is not None:
                entry["filled"] = True
        layers.append(entry)
    about = {"schema": SCHEMA, "size_mm": list(sheet.size), "layers": layers, "recipe": dict(sheet.recipe)}
    return about, (piece for layer in sheet.layers for piece in _numbers(layer))


def _numbers(layer: Layer) -> Iterator[bytes]:
    """The numbers of a layer, a column at a time."""
    art = layer.art
    if isinstance(art, Marks):
        for lengths in (art.xy[:, 0], art.xy[:, 1], art.scale):
            yield _column(np.diff(np.round(lengths * 1000), prepend=0))
        yield _column(np.diff(art.glyph, prepend=0))
        yield _column(np.round(art.angle * (TURN_STEPS / (2 * np.pi))))
        yield from (glyph.paths.xy.astype("<f8").tobytes() for glyph in art.glyphs)
    elif isinstance(art, Bitmap):
        yield art.bits.tobytes()
    elif not (isinstance(art, Words) and art.font in FACES):
        art = outlined(art)
        for column in (*np.round(art.xy * 1000).T, art.start):
            yield _column(np.diff(column, prepend=0))
        if layer.fill is not None:
            yield from (_column(np.round(share * SHARES)) for share in layer.fill.T)


def _glyph(glyph: Glyph) -> dict[str, Any]:
    return {"size_mm": glyph.size, "points": len(glyph.paths.xy), "closed": glyph.paths.closed, "cubic": glyph.paths.cubic}


def _column(values: npt.ArrayLike) -> bytes:
    """Whole numbers as 8 planes of bytes, lowest first; signs folded in, so that the high planes are zeros and deflate to nothing."""
    whole = np.asarray(values).astype("<i8")
    folded = ((whole << 1) ^ (whole >> 63)).astype("<u8")
    return np.ascontiguousarray(folded.view(np.uint8).reshape(-1, 8).T).tobytes()


def unpacked(about: dict[str, Any], table: bytes) -> Sheet:
    at = 0

    def take(size: int) -> bytes:
        nonlocal at
        if at + size > len(table):
            raise IndexError("it is cut short")
        at += size
        return table[at - size : at]

    def column(n: int) -> npt.NDArray[np.int64]:
        planes = np.frombuffer(take(8 * n), np.uint8).reshape(8, n)
        folded = np.ascontiguousarray(planes.T).view("<u8").reshape(n)
        return (folded >> np.uint64(1)).astype(np.int64) ^ -(folded & np.uint64(1)).astype(np.int64)

    layers = []
    for entry in about["layers"]:
        art: Art
        if "marks" in entry:
            n = entry["marks"]
            x, y, scale, glyph = (np.cumsum(column(n)) for _ in range(4))
            turns = column(n)
            glyphs = tuple(
                Glyph(Paths.of([np.frombuffer(take(16 * g["points"]), "<f8")], closed=g["closed"], cubic=g["cubic"]), g["size_mm"])
                for g in entry["glyphs"]
            )
            places: Array = np.stack([x, y], axis=1) / 1000
            art = Marks(places, (turns * (2 * np.pi / TURN_STEPS)).astype(np.float64), scale / 1000.0, glyph, glyphs)
        elif "words" in entry:
            art = Words(tuple(map(str, entry["words"])), np.array(entry["at_mm"]).reshape(-1, 2), np.array(entry["high_mm"]), entry["font"])
        elif "pixels" in entry:
            across, down = entry["pixels"]
            bits = np.frombuffer(take(down * -(-across // 8)), np.uint8).reshape(down, -1)
            art = Bitmap(bits, across, float(entry["dpi"]), np.array(entry["at_mm"]))
        else:
            x, y = (np.cumsum(column(entry["points"])) for _ in range(2))
            start = np.cumsum(column(entry["paths"] + 1))
            art = Paths(np.stack([x, y], axis=1) / 1000, start, entry["closed"], entry["cubic"])
        fill = np.stack([column(len(art)) for _ in range(4)], axis=1) / SHARES if "filled" in entry else None
        ink = entry["ink"]
        made = Ink(ink["name"], tuple(ink["cmyk"]), ink["pen"], bool(ink.get("spot", False)), bool(ink.get("overprint", False)))
        layers.append(Layer(made, art, entry["name"], fill))
    return Sheet(tuple(about["size_mm"]), tuple(layers), about["recipe"], {"warnings": []})
