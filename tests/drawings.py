"""Drawings that tests of formats write and read back, and the comparison of two sheets."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any

import numpy as np

from crowquill import formats, glyphs, hilbert
from crowquill.marks import Glyph, Marks
from crowquill.paths import Paths
from crowquill.sheet import Ink, Layer, Sheet

NIB = glyphs.load("nib-03").glyphs
KITE = Glyph.of(Paths.of([[(3, 0), (1, 1), (0, 0.2), (1, -0.7)]]))


def marks(n: int, width: float = 180, height: float = 267, shapes: tuple[Glyph, ...] = NIB, seed: int = 1) -> Marks:
    """Dots of a 0.3 mm pen evenly spaced in the margins of a page, in Hilbert order, as a style leaves them."""
    rng = np.random.default_rng(seed)
    pitch = np.sqrt(width * height / n)
    grid = np.stack(np.meshgrid(np.arange(pitch / 2, width, pitch), np.arange(pitch / 2, height, pitch)), axis=-1).reshape(-1, 2)
    xy = grid + 15 + rng.uniform(-0.3, 0.3, grid.shape) * pitch
    which, size = rng.integers(len(shapes), size=len(xy)), np.array([shape.size for shape in shapes])
    made = Marks.of(xy, shapes, scale=(size * np.sqrt(np.pi) / 2)[which], angle=rng.uniform(0, 2 * np.pi, len(xy)), glyph=which)
    return made.take(hilbert.of_points(xy))


def everything(seed: int = 1, n: int = 30) -> Sheet:
    """All that a sheet can hold: dots of curves and of lines, fills with a hole, strokes, colours, words."""
    ring = Paths.of([[(5, 5), (45, 5), (45, 45), (5, 45)], [(10, 10), (10, 20), (20, 20), (20, 10)]])
    strokes = Paths.of([[(1, 1), (2.5, 3), (9, 1.001)], [(-3, 7), (60, 70)]], closed=False)
    curves = Paths.of([[(1, 1), (2, 1), (3, 2), (3, 3), (9, 9), (4, 4), (1, 8)]], closed=False, cubic=True)
    layers = (
        Layer(Ink(), marks(n, seed=seed)),
        Layer(Ink(), marks(n, shapes=(KITE,), seed=seed), "kites"),
        Layer(Ink("sky", (0.7, 0.2, 0, 0.05)), ring),
        Layer(Ink("wash", (0, 0, 0, 0.3)), strokes.take([])),
        Layer(Ink("line", (0, 1, 1, 0), 0.25), strokes),
        Layer(Ink(pen=0.1), curves),
    )
    recipe = {"style": "stipple", "picture": 'Möwe & "Ente" <3>.png', "knobs": {"pen": 0.3, "dots": None, "size": [1, 2]}}
    return Sheet((210, 297.003), layers, recipe, {"seconds": 1.0})


def same(one: Sheet, other: Sheet) -> None:
    """Raises AssertionError unless the sheets are alike to the last bit; reports do not count."""
    assert facts(one) == facts(other)


def facts(sheet: Sheet) -> Any:
    """All that a sheet says, as plain values."""
    return sheet.size, dict(sheet.recipe), [(layer.ink, layer.name, _plain(layer.art)) for layer in sheet.layers]


def _plain(art: Marks | Paths) -> Any:
    if isinstance(art, Paths):
        return art.xy.tolist(), art.start.tolist(), art.closed, art.cubic
    columns = [column.tolist() for column in (art.xy, art.angle, art.scale, art.glyph)]
    return columns, [(glyph.size, _plain(glyph.paths)) for glyph in art.glyphs]


def strokes(seed: int = 1, n: int = 30) -> Sheet:
    """The same with outlines in place of fills: what a pen plotter draws."""
    sheet = everything(seed, n)
    return replace(sheet, layers=tuple(replace(layer, ink=replace(layer.ink, pen=layer.ink.pen or 0.3)) for layer in sheet.layers))


def drawable(format: str, seed: int = 1) -> Sheet:
    """All that a sheet can hold and the format draws."""
    return strokes(seed) if hasattr(formats.module(format, format), "STROKES") else everything(seed)


@functools.cache
def file(format: str) -> bytes:
    """The bytes of drawable() in a format."""
    return formats.to_bytes(drawable(format), format)
