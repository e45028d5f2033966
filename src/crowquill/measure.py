"""How good a set of marks is: the ink it really puts on the paper."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import raster
from crowquill.kernel import compiled
from crowquill.marks import Marks
from crowquill.paths import Array, Index

LINES = 16  # across the mean mark: its area comes out within half a percent, and errors of many marks cancel
FEWEST, MANY = 4, 100_000  # lines across, in place of those, where there are many more marks than these
TINY = float(np.finfo(float).tiny)
JOINED = 3000  # marks: shapely joins so many in half a second
FLAT = 2e-4  # of a unit glyph
TRIES, SAME = 8, 1e-3  # of factors, until the ink is as near as this


def rendered(marks: Marks, size: tuple[float, float], grid: tuple[int, int], *, pitch: float | None = None) -> Array:
    """The share of each pixel that the marks cover together, (h, w) for grid (h, w) over size (width, height) mm.

    Where marks overlap the paper is covered once. Spans are measured along lines no further apart than
    `pitch` mm; left out, a sixteenth of the mean mark's width. Parts outside the size are not seen.
    """
    h, w = grid
    if not (marks.scale > 0).any():
        return np.zeros(grid)
    pixel = size[0] / w, size[1] / h
    lines = max(1, int(np.ceil(pixel[1] / (marks.scale.mean() / LINES if pitch is None else pitch))))
    return raster.covered(marks, grid, pixel=pixel, lines=lines, flat=FLAT * float(marks.scale.max()))


def ink(marks: Marks) -> float:
    """The area of paper that the marks cover together, mm^2, within about 1e-4.

    Marks that meet no other are known; a few that do are joined by shapely, many are measured line by line.
    """
    if not (marks.scale > 0).all():
        marks = marks.take(marks.scale > 0)
    if not len(marks):
        return 0.0
    reach = np.array([glyph.reach for glyph in marks.glyphs])[marks.glyph] * marks.scale
    meets = meeting(marks.xy, reach)
    alone, crowd = float((marks.scale[~meets] ** 2).sum()), marks.take(meets)
    if len(crowd) <= JOINED:
        outlines = crowd.outlines().flat(FLAT * float(marks.scale.min())).polygons()
        return alone + float(shapely.area(shapely.union_all(outlines)))
    return alone + _lined(crowd, reach.max())


def meeting(xy: Array, reach: Array) -> npt.NDArray[np.bool_]:
    """Which of the circles at xy (n, 2) with these radii (n,) mm meet another: (n,). A square grid tells who may."""
    met = np.zeros(len(xy), bool)
    low, high = xy.min(axis=0), xy.max(axis=0)
    side = max(2 * float(reach.max()), float(np.sqrt(np.prod(high - low) / len(xy) / 4)), float((high - low).max()) / len(xy), TINY)
    columns, rows = ((high - low) / side).astype(np.int64) + 1
    square = ((xy - low) / side).astype(np.int64) @ (1, columns)
    order = np.argsort(square, kind="stable")
    start = np.searchsorted(square[order], np.arange(columns * rows + 1))
    _meeting(np.ascontiguousarray(xy[order]), reach[order], start, columns, rows, met)
    back = np.empty_like(met)
    back[order] = met
    return back


@compiled
def _meeting(xy: Array, reach: Array, start: Index, columns: int, rows: int, met: npt.NDArray[np.bool_]) -> None:
    """Marks circles that meet; those of each square, row by row, lie from start[square] to start[square + 1]."""
    for row in range(rows):
        for column in range(columns):
            for i in range(start[row * columns + column], start[row * columns + column + 1]):
                for other in range(row, min(row + 2, rows)):
                    left, right = max(column - 1, 0), min(column + 1, columns - 1)
                    first = max(start[other * columns + left], i + 1)
                    for j in range(first, start[other * columns + right + 1]):
                        if np.hypot(xy[i, 0] - xy[j, 0], xy[i, 1] - xy[j, 1]) < reach[i] + reach[j]:
                            met[i] = met[j] = True


def covering(marks: Marks, mm2: float, limits: tuple[float, float]) -> tuple[Marks, float]:
    """The marks, all larger or smaller by one factor so that they cover so much paper, and how much that is, mm^2.

    limits  of the factor, from 1 or less to 1 or more; within them the paper comes out to 0.1 %

    Marks that cover nothing stay as they are, and so do all where nothing is to be covered.
    """
    reach = np.array([glyph.reach for glyph in marks.glyphs])[marks.glyph] * marks.scale
    factor, covered, slope = 1.0, _lined(marks, reach.max()) if reach.any() else 0.0, 2.0  # of the logarithms: 2 where none meet
    for _ in range(TRIES):
        if not covered or not mm2 or abs(covered / mm2 - 1) < SAME:
            break
        other = float(np.clip(factor * (mm2 / covered) ** (1 / slope), *limits))
        if other == factor:
            break
        there = _lined(replace(marks, scale=marks.scale * other), other * reach.max())
        slope = float(np.clip(np.log(there / covered) / np.log(other / factor), 0.2, 2.0))
        factor, covered = other, there
    return replace(marks, scale=marks.scale * factor), covered


def _lined(marks: Marks, edge: float) -> float:
    """The area covered by marks that reach no further than `edge` mm, by the spans of lines that they cover."""
    low, high = marks.xy.min(axis=0) - edge, marks.xy.max(axis=0) + edge
    width, height = high - low
    # fewer marks are measured more finely, and of very many those of a strip at a time
    lines = min(LINES, max(FEWEST, LINES * np.sqrt(MANY / len(marks))))
    if lines < LINES:  # and by fewer corners: the area that chords cut off is given back
        flat = FLAT * (LINES / lines) ** 3
        marks = replace(marks, glyphs=tuple(replace(glyph, paths=glyph.paths.flat(flat)) for glyph in marks.glyphs))
    pitch = min(marks.scale.mean() / lines, np.sqrt((marks.scale**2).sum() / 5e7))
    pitch = max(pitch, np.sqrt(width * height / 4e9))
    h, w = (max(1, int(height / pitch / 64)), max(1, int(width / pitch / 64)))
    if len(marks) <= 2 * MANY or h < 2:
        return float(rendered(marks.moved(-low), (width, height), (h, w), pitch=pitch).mean() * width * height)
    cuts = np.unique(np.linspace(0, h, 1 + -(-len(marks) // (5 * MANY))).astype(np.int64))
    found = 0.0
    for top, bottom in (cuts[k : k + 2] * (height / h) for k in range(len(cuts) - 1)):
        here = marks.take((marks.xy[:, 1] > low[1] + top - edge) & (marks.xy[:, 1] < low[1] + bottom + edge))
        if len(here):
            grid = (round((bottom - top) * h / height), w)
            part = rendered(here.moved((-low[0], -low[1] - top)), (width, bottom - top), grid, pitch=pitch)
            found += float(part.mean() * width * (bottom - top))
    return found
