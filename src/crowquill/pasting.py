"""Drawings larger than paper, as sheets to be pasted together: what lies on each, and marks in its margin that say how they join."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import shapely

from crowquill import trimming
from crowquill.forme import THIN
from crowquill.knobs import Range, Text
from crowquill.lettering import Words
from crowquill.marks import Marks, whole
from crowquill.paths import Array, Paths
from crowquill.sheet import Bitmap, Ink, Layer, Sheet, shifted
from crowquill.units import PAPERS, UM, paper

MARGIN = 12.0  # mm around what a sheet shows: more than office printers leave white, and room for marks
GAP = 1.0  # mm from what it shows to a mark
CUT, JOIN = 7.0, 3.0  # mm: the ticks at the edges of a sheet, and those where its neighbours' edges come to lie
TARGET = 1.5  # mm: the radius of a circle in the middle of what two sheets share
LETTERS = 3.0  # mm: the size of names
MOST = 10_000  # sheets of one drawing
INK = Ink("sheet marks")
Place = tuple[int, int]  # column and row, from 0


@dataclass(frozen=True)
class Cut:
    """How a drawing of `size` mm is cut: sheets of `paper` mm, each sharing `overlap` mm with the next, in columns and rows."""

    size: tuple[float, float]
    paper: tuple[float, float]
    overlap: float

    @property
    def room(self) -> tuple[float, float]:
        """Width and height in mm of what a sheet shows."""
        return self.paper[0] - 2 * MARGIN, self.paper[1] - 2 * MARGIN

    @property
    def shape(self) -> Place:
        """Columns and rows of sheets."""
        across, down = (
            max(1, math.ceil((side - self.overlap - UM) / (room - self.overlap))) for side, room in zip(self.size, self.room, strict=True)
        )
        return across, down

    @property
    def places(self) -> list[Place]:
        """All sheets, row by row."""
        return [(column, row) for row in range(self.shape[1]) for column in range(self.shape[0])]

    def corner(self, place: Place) -> Array:
        """The place on the drawing (2,) in mm where a sheet begins."""
        return np.array(whole(np.array(place) * (np.array(self.room) - self.overlap)))

    def sheet(self, drawing: Sheet, place: Place) -> Sheet:
        """What lies on a sheet, with its marks. Marks that it shows any part of are whole; lines and areas end with it.

        Raises ValueError for pixels, which are not cut.
        """
        corner = self.corner(place)
        low, high = corner, np.minimum(corner + self.room, self.size)
        layers = [part for layer in drawing.layers if (part := _shown(layer, low, high)) is not None]
        offset = whole(MARGIN - corner)
        layers = [replace(layer, art=shifted(layer.art, offset)) for layer in layers]
        made = dict(drawing.recipe)
        if "art_at_mm" in made:
            made |= {"paper_mm": list(self.paper), "art_at_mm": whole(np.array(made["art_at_mm"]) + offset).tolist()}
        return Sheet(self.paper, (*layers, *self._marks(place, high - low)), made, drawing.report, drawing.attached)

    def _marks(self, place: Place, shown: Array) -> Iterator[Layer]:
        """Ticks, targets and names in the margin of a sheet that shows so many mm."""
        ticks, targets = [], []
        words = [(_told(place, self.shape), MARGIN + self.overlap + LETTERS, MARGIN - GAP - CUT + LETTERS)]
        for axis in (0, 1):  # along x, then y
            before, after = place[axis] > 0, place[axis] + 1 < self.shape[axis]
            ends = [MARGIN, MARGIN + float(shown[axis])]
            joins = [ends[0] + self.overlap] * before + [ends[1] - self.overlap] * after
            middles = [ends[0] + self.overlap / 2] * before + [ends[1] - self.overlap / 2] * after
            edges = MARGIN - GAP, MARGIN + float(shown[1 - axis]) + GAP
            for at, long in [*((end, CUT) for end in ends), *((join, JOIN) for join in joins if self.overlap)]:
                ticks += [_tick(axis, at, edges[0] - long, long), _tick(axis, at, edges[1], long)]
            if self.overlap >= 4 * TARGET:
                sides = edges[0] - CUT + TARGET, edges[1] + CUT - TARGET
                targets += [ring for at in middles for side in sides for ring in _target(axis, at, side)]
        for axis, step in ((0, -1), (0, 1), (1, -1), (1, 1)):
            beside = (place[0] + step, place[1]) if axis == 0 else (place[0], place[1] + step)
            if 0 <= beside[axis] < self.shape[axis]:
                x, y = MARGIN + shown / 2
                edge = MARGIN / 2 if step < 0 else MARGIN * 1.5 + float(shown[axis])
                words.append((name(beside), edge - LETTERS, y) if axis == 0 else (name(beside), x, edge + LETTERS / 2))
        yield Layer(INK, Paths.of(ticks + targets), "sheet marks")
        yield Layer(INK, Words.of(words, size=LETTERS), "sheet names")


def cut(
    size: tuple[float, float],
    *,
    sheets: Annotated[str | None, Text("on sheets of this paper to be pasted together, a file each: a4, letter, 300x400mm")] = None,
    sheet_overlap: Annotated[float, Range(0, 1000, "mm", "what a sheet shares with its neighbours")] = 10.0,
) -> Cut | None:
    """How a drawing of this size in mm is cut to sheets, or None where none are asked for.

    A paper with a name lies as makes the fewest sheets; a size lies as it is. Raises ValueError for paper too small to share so
    much, and for more than 10 000 sheets.
    """
    if sheets is None:
        return None
    across, down = paper(sheets)
    turned = [(across, down), (down, across)] if sheets.strip().lower() in PAPERS else [(across, down)]
    if min(across, down) - 2 * MARGIN <= sheet_overlap:
        raise ValueError(
            f"sheets of {across:g} x {down:g} mm leave nothing between margins of {MARGIN:g} mm "
            f"and an overlap of {sheet_overlap:g} mm; give larger paper"
        )
    found = min((Cut(size, one, sheet_overlap) for one in turned), key=lambda cut: math.prod(cut.shape))
    if (number := math.prod(found.shape)) > MOST:
        raise ValueError(f"the drawing takes {number} sheets, over the limit of {MOST}; give larger paper, or less overlap")
    return found


def name(place: Place) -> str:
    """What a sheet is called: its column as letters, its row as a number.

    >>> name((0, 0)), name((27, 4))
    ('A1', 'AB5')
    """
    letters, left = "", place[0] + 1
    while left:
        left, letter = divmod(left - 1, 26)
        letters = chr(ord("A") + letter) + letters
    return f"{letters}{place[1] + 1}"


def _told(place: Place, shape: Place) -> str:
    last = name((shape[0] - 1, shape[1] - 1))
    return f"sheet {name(place)} of A1 to {last}" if shape != (1, 1) else f"sheet {name(place)}"


def _shown(layer: Layer, low: Array, high: Array) -> Layer | None:
    """What a layer has in a box; None where that is nothing."""
    art = layer.art
    if isinstance(art, Bitmap):
        raise ValueError("pixels of a device are not cut to sheets; leave out sheets, or draw dots or polygons")
    if isinstance(art, Marks):
        if not len(art):
            return None
        reach = np.array([glyph.reach for glyph in art.glyphs])[art.glyph] * art.scale + (layer.ink.pen or 0.0) / 2
        near = np.ones(len(art), bool)
        for axis in (0, 1):
            near &= (art.xy[:, axis] + reach > low[axis]) & (art.xy[:, axis] - reach < high[axis])
        return replace(layer, art=art.take(near)) if near.any() else None
    paths = art.outlines() if isinstance(art, Words) else art
    near = np.flatnonzero(_touches(paths, low, high))
    if not len(near):
        return None
    part = replace(layer, art=paths.take(near), fill=None if layer.fill is None else layer.fill[near])
    beyond = shapely.difference(shapely.box(*(low - 1e6), *(high + 1e6)), shapely.box(*low, *high))
    found = trimming.cut(part, beyond)[0]
    return found if len(found.art) else None


def _touches(paths: Paths, low: Array, high: Array) -> Array:
    """Which paths have a box that meets another box; a curve lies in the box of its controls."""
    counts = np.diff(paths.start)
    found = counts > 0
    if found.any():
        first = paths.start[:-1][found]
        least, most = np.minimum.reduceat(paths.xy, first), np.maximum.reduceat(paths.xy, first)
        found[found] = ((least <= high) & (most >= low)).all(axis=1)
    return np.asarray(found)


def _tick(axis: int, at: float, begin: float, long: float) -> Array:
    """A thin rectangle across an axis."""
    box = np.array([(at - THIN / 2, begin), (at + THIN / 2, begin), (at + THIN / 2, begin + long), (at - THIN / 2, begin + long)])
    return box if axis == 0 else box[::-1, ::-1]


def _target(axis: int, at: float, side: float) -> list[Array]:
    """A circle with a cross through it."""
    middle = np.array((at, side) if axis == 0 else (side, at))
    around = np.linspace(0, 2 * np.pi, 72, endpoint=False)
    circle = np.stack([np.cos(around), np.sin(around)], axis=1)
    rings = [TARGET * circle + middle, ((TARGET - THIN) * circle)[::-1] + middle]
    bars = [_tick(0, middle[0], middle[1] - TARGET, 2 * TARGET), _tick(1, middle[1], middle[0] - TARGET, 2 * TARGET)]
    return [*rings, *bars]
