"""How good a set of marks is: the ink it really puts on the paper."""

from __future__ import annotations

import numpy as np
import shapely

from crowquill.kernel import compiled
from crowquill.paths import Array, Index
from crowquill.sheet import Marks

SAMPLES = 16  # across the mean mark: its area comes out within 1 % each, and errors of many marks cancel
BAND = 64_000_000  # samples held at a time
JOINED = 3000  # marks: shapely joins so many in half a second
FLAT = 2e-4  # of a unit glyph


def rendered(marks: Marks, size: tuple[float, float], grid: tuple[int, int], *, pitch: float | None = None) -> Array:
    """The share of each pixel that the marks cover together, (h, w) for grid (h, w) over size (width, height) mm.

    Where marks overlap the paper is covered once. Each pixel is sampled on a regular grid no wider than
    `pitch` mm; left out, a sixteenth of the mean mark's width. Parts outside the size are not seen.
    """
    h, w = grid
    cover = np.zeros((h, w))
    if not (marks.scale > 0).any():
        return cover
    step = marks.scale.mean() / SAMPLES if pitch is None else pitch
    across = np.maximum(1, np.ceil(np.array([size[0] / w, size[1] / h]) / step)).astype(np.int64)
    dx, dy = size[0] / (w * across[0]), size[1] / (h * across[1])
    shapes = marks._shapes.flat(FLAT)
    corners = shapes.xy / np.sqrt(shapes.areas)[shapes.path][:, None]  # a chord cuts off area, which is given back
    reach = np.array([glyph.reach for glyph in marks.glyphs])[marks.glyph] * marks.scale
    rows = int(max(1, BAND // (w * across[0] * across[1])))  # pixel rows to a band
    for top in range(0, h, rows):
        bottom = min(h, top + rows)
        ink = np.zeros(((bottom - top) * across[1], w * across[0]), np.bool_)
        lower, upper = top * across[1] * dy - reach, bottom * across[1] * dy + reach
        near = marks.take((marks.xy[:, 1] >= lower) & (marks.xy[:, 1] <= upper))
        xy = (near.xy - (0, top * across[1] * dy)) / (dx, dy)
        _inked(xy, near.angle, near.scale, near.glyph, corners, shapes.start, dx, dy, ink)
        cover[top:bottom] = ink.reshape(bottom - top, across[1], w, across[0]).mean(axis=(1, 3))
    return cover


def ink(marks: Marks) -> float:
    """The area of paper that the marks cover together, mm^2, within about 1e-4.

    Marks that meet no other are known; a few that do are joined by shapely, many are sampled.
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
    return alone + _sampled(crowd, reach.max())


def _sampled(marks: Marks, edge: float) -> float:
    """The area covered by marks that reach no further than `edge` mm, by the samples that they hit."""
    low, high = marks.xy.min(axis=0) - edge, marks.xy.max(axis=0) + edge
    width, height = high - low
    # fewer marks are sampled more finely: some fifty million samples of ink, whatever the number
    pitch = min(marks.scale.mean() / SAMPLES, np.sqrt((marks.scale**2).sum() / 5e7))
    pitch = max(pitch, np.sqrt(width * height / 4e9))
    grid = (max(1, int(height / pitch / 64)), max(1, int(width / pitch / 64)))
    return float(rendered(marks.moved(-low), (width, height), grid, pitch=pitch).mean() * width * height)


@compiled
def _inked(xy: Array, angle: Array, scale: Array, glyph: Index, shapes: Array, start: Index, dx: float, dy: float, ink: Array) -> None:
    """Sets the samples inside each mark; xy is in samples, a sample of width dx and height dy mm at its own middle."""
    longest = 0
    for g in range(len(start) - 1):
        longest = max(longest, start[g + 1] - start[g])
    px, py, cross = np.empty(longest), np.empty(longest), np.empty(longest)
    for mark in range(len(xy)):
        begin, count = start[glyph[mark]], start[glyph[mark] + 1] - start[glyph[mark]]
        cos, sin = np.cos(angle[mark]) * scale[mark], np.sin(angle[mark]) * scale[mark]
        low, high = np.inf, -np.inf
        for k in range(count):
            u, v = shapes[begin + k, 0], shapes[begin + k, 1]
            px[k] = xy[mark, 0] + (cos * u - sin * v) / dx
            py[k] = xy[mark, 1] + (sin * u + cos * v) / dy
            low, high = min(low, py[k]), max(high, py[k])
        for row in range(max(0, int(np.ceil(low - 0.5))), min(ink.shape[0], int(np.floor(high - 0.5)) + 1)):
            y, found = row + 0.5, 0
            for k in range(count):
                after = k + 1 if k + 1 < count else 0
                if (py[k] <= y) != (py[after] <= y):
                    x, at = px[k] + (y - py[k]) / (py[after] - py[k]) * (px[after] - px[k]), found
                    while at > 0 and cross[at - 1] > x:  # kept in order: there are two, seldom four
                        cross[at] = cross[at - 1]
                        at -= 1
                    cross[at] = x
                    found += 1
            for k in range(0, found - 1, 2):
                first = max(0, int(np.ceil(cross[k] - 0.5)))
                last = min(ink.shape[1] - 1, int(np.floor(cross[k + 1] - 0.5)))
                for column in range(first, last + 1):
                    ink[row, column] = True
