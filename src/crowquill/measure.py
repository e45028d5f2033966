"""How good a set of marks is: the ink it really puts on the paper."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely

from crowquill import raster
from crowquill.marks import Marks
from crowquill.paths import Array

LINES = 16  # across the mean mark: its area comes out within half a percent, and errors of many marks cancel
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
    from scipy.spatial import cKDTree

    marks = marks.take(marks.scale > 0)
    if not len(marks):
        return 0.0
    reach = np.array([glyph.reach for glyph in marks.glyphs])[marks.glyph] * marks.scale
    pairs = cKDTree(marks.xy).query_pairs(2 * reach.max(), output_type="ndarray")
    near = np.hypot(*(marks.xy[pairs[:, 0]] - marks.xy[pairs[:, 1]]).T) < reach[pairs].sum(axis=1)
    meets = np.zeros(len(marks), bool)
    meets[pairs[near]] = True
    alone, crowd = float((marks.scale[~meets] ** 2).sum()), marks.take(meets)
    if len(crowd) <= JOINED:
        outlines = crowd.outlines().flat(FLAT * float(marks.scale.min())).polygons()
        return alone + float(shapely.area(shapely.union_all(outlines)))
    return alone + _lined(crowd, reach.max())


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
    # fewer marks are measured more finely
    pitch = min(marks.scale.mean() / LINES, np.sqrt((marks.scale**2).sum() / 5e7))
    pitch = max(pitch, np.sqrt(width * height / 4e9))
    grid = (max(1, int(height / pitch / 64)), max(1, int(width / pitch / 64)))
    return float(rendered(marks.moved(-low), (width, height), grid, pitch=pitch).mean() * width * height)
