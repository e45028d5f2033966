"""A learned style as one file: JSON, its arrays as base64 of zlib of whole numbers, little-endian.

Shapes are kept to a ten-thousandth of a millimetre, places to a 65536th of the tile, thresholds and correlations to as small a share.
"""

from __future__ import annotations

import base64
import binascii
import json
import os
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from crowquill.exemplar.style import Hand, Level, Style, Tile
from crowquill.marks import Glyph
from crowquill.paths import Array, Paths
from crowquill.vector import contents

SCHEMA = 2  # a reader refuses a newer one
FINEST = 1e-4  # mm, of shapes
STEPS = 65536
MOST = 4_000_000  # numbers of an array
SIDES = (1.0, 1000.0)  # mm, of tiles
TONES = 64  # of a tile; ten are learned


def save(style: Style, path: str | os.PathLike[str]) -> None:
    """Writes a style with its tiles to a file. The same style gives the same bytes."""
    Path(path).write_bytes(to_bytes(style))


def load(path: str | os.PathLike[str]) -> Style:
    """The style in a file. Raises ValueError for a file that is none, OSError where it cannot be read."""
    return parsed(contents(Path(path)), str(path))


def to_bytes(style: Style) -> bytes:
    """The file of a style. Raises ValueError for a hand without a tile."""
    data: dict[str, Any] = {
        "crowquill style": SCHEMA,
        "name": style.name,
        "dpi": style.dpi,
        "sha256": style.sha256,
        "turnover": [round(end, 6) for end in style.turnover],
        "notes": list(style.notes),
        "black": _hand(style.black),
    }
    if style.white is not None:
        data["white"] = _hand(style.white)
    return (json.dumps(data, indent=1, allow_nan=False) + "\n").encode()


def parsed(data: bytes, name: str) -> Style:
    """The style in the bytes of a file; errors call it `name`."""
    try:
        found = json.loads(data)
        schema = found["crowquill style"]
    except (ValueError, RecursionError, KeyError, TypeError):
        raise ValueError(f"{name}: holds no learned style; give one that was saved, or the scan with --example") from None
    if schema != SCHEMA:
        raise ValueError(f"{name}: a style of schema {str(schema)[:20]!r}, which this crowquill does not know; learn the example again")
    try:
        white = _read(found["white"]) if "white" in found else None
        dpi, (low, high) = float(found["dpi"]), map(float, found["turnover"])
        if not (np.isfinite(dpi) and 0 < low <= high <= 1):
            raise ValueError(f"turnover from {low} to {high}")
        notes = tuple(str(note) for note in found["notes"])
        return Style(str(found["name"]), dpi, str(found["sha256"]), _read(found["black"]), white, (low, high), notes)
    except (KeyError, TypeError, ValueError, OverflowError, AttributeError, binascii.Error, zlib.error) as error:
        why = " ".join(str(error).split())[:80]
        raise ValueError(f"{name}: its style is broken ({why}); learn the example again") from None


def _hand(hand: Hand) -> dict[str, Any]:
    if hand.tile is None:
        raise ValueError("a hand has no tile; make tiles with exemplar.learned() before it is saved")
    # unit glyphs at true size, so that the numbers are lengths
    rings = [glyph.paths.xy * (glyph.size * np.sqrt(np.pi) / 2) for glyph in hand.glyphs]
    return {
        "counts": [len(ring) for ring in rings],
        "cubic": hand.glyphs[0].paths.cubic,
        "shapes": _packed(np.round(np.concatenate(rings) / FINEST), "<i4"),
        "levels": [
            {
                "coverage": round(level.coverage, 6),
                "step_mm": round(float(level.lags[1]), 9),
                "correlation": np.round(level.correlation, 5).tolist(),
            }
            for level in hand.levels
        ],
        "side_mm": round(hand.tile.side, 6),
        "tones": [round(tone, 9) for tone in hand.tile.tones.tolist()],
        **_places(hand.tile),
        "thresholds": _packed(np.round(np.clip(hand.tile.threshold, 0, 1) * (STEPS - 1)), "<u2"),
    }


def _places(tile: Tile) -> dict[str, Any]:
    """Where marks lie in the darkest tone, and for each lighter one how far from there, tone by tone, those do that move at all."""
    steps = np.floor(tile.xy / tile.side * STEPS + 1e-6)
    slides = steps[:-1] - steps[1:]
    ends = [int(np.flatnonzero(slide.any(axis=1))[-1]) + 1 if slide.any() else 0 for slide in slides]
    return {
        "places": _packed(steps[-1] % STEPS, "<u2"),
        "slides": [_packed(slide[:end], "<i2") for slide, end in zip(slides, ends, strict=True)],
    }


def _tile(data: dict[str, Any]) -> Tile:
    side, tones = float(data["side_mm"]), np.array(data["tones"], np.float64)
    steps = [_unpacked(data["places"], "<u2").reshape(-1, 2)]
    threshold = _unpacked(data["thresholds"], "<u2") / (STEPS - 1)
    if (np.diff(threshold) < 0).any() or not SIDES[0] <= side <= SIDES[1]:
        raise ValueError(f"thresholds that do not rise, or a tile of {side:g} mm")
    if not 0 < len(tones) == len(data["slides"]) + 1 <= TONES or (np.diff(tones, prepend=0) <= 0).any():
        raise ValueError("tones that do not rise, or others than places are known in")
    for packed in reversed(data["slides"]):
        slide = _unpacked(packed, "<i2").reshape(-1, 2)
        steps.append(steps[-1] + np.pad(slide, ((0, len(steps[0]) - len(slide)), (0, 0))))
    return Tile(side, threshold, tones, np.array(steps[::-1]) * side / STEPS)


def _read(data: dict[str, Any]) -> Hand:
    points, counts = _unpacked(data["shapes"], "<i4").reshape(-1, 2) * FINEST, [int(count) for count in data["counts"]]
    if sum(counts) != len(points) or min(counts) < 3:
        raise ValueError(f"{len(points)} points for shapes of {sum(counts)}")
    rings = np.split(points, np.cumsum(counts)[:-1])
    glyphs = tuple(Glyph.of(Paths.of([ring], cubic=bool(data["cubic"]))) for ring in rings)
    levels = tuple(_level(level) for level in data["levels"])
    return Hand(glyphs, levels, _tile(data))


def _level(data: dict[str, Any]) -> Level:
    curve = np.array(data["correlation"], np.float64)
    lags: Array = float(data["step_mm"]) * np.arange(len(curve), dtype=np.float64)
    return Level(float(data["coverage"]), lags, curve)


def _packed(whole: Array, kind: str) -> str:
    return base64.b64encode(zlib.compress(whole.astype(kind).tobytes(), 9)).decode("ascii")


def _unpacked(text: str, kind: str) -> Array:
    size = np.dtype(kind).itemsize
    unpack = zlib.decompressobj()
    data = unpack.decompress(base64.b64decode(text, validate=True), MOST * size + 1)
    if not unpack.eof or len(data) % size or len(data) > MOST * size:
        raise ValueError(f"an array is cut off, or over {MOST} numbers")
    return np.asarray(np.frombuffer(data, kind), np.float64)
