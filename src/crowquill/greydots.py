"""Dots as they were scanned, laid over each other on a grid of pixels: ink takes its share of what light the dots below it leave.

Source: D. Martin, G. Arroyo, M. V. Luzon, T. Isenberg, Scale-dependent and example-based grayscale stippling,
Computers & Graphics 35(1), 2011.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crowquill.kernel import compiled, shared_out
from crowquill.marks import Marks
from crowquill.paths import Array, Index

RIM = 0.28  # of the light: what dots of the shipped libraries take where their outlines run, so that both have one area
FINE = 1.05  # pixels of a scan to a sample at most: wider ones would miss the dark middles of small dots
HELD = 1 << 22  # samples at a time
ROWS = 4  # of pixels at least to a thread


@dataclass(frozen=True, eq=False)
class Greys:
    """Marks made ready for any rows of a grid of pixels, as a raster.Raster is; see `of`.

    grey    scans end to end, row by row, each in a frame of one pixel of paper; first (s + 1,) where each begins, wide (s,) its width
    scan    (n,) the scan of each mark, place (n, 2) mm
    turned  (n, 2) cosine and sine from the page to its scan, times pixels of the scan to the mm; middle (s, 2) of a scan, in its pixels
    reach   (n,) mm from a mark's place to its scan's furthest corner
    fine    samples to a pixel, each way
    """

    grey: Array
    first: Index
    wide: Index
    scan: Index
    place: Array
    turned: Array
    middle: Array
    reach: Array
    pixel: tuple[float, float]
    width: int
    fine: int

    @classmethod
    def of(cls, marks: Marks, *, pixel: tuple[float, float], width: int) -> Greys:
        """Marks, whose glyphs all have scans, on a grid `width` pixels wide, its first corner at (0, 0); pixel (width, height) mm.

        A pixel takes the mean of samples no further apart than pixels of the scans, so that tone is the same at any resolution.
        """
        used = np.unique(marks.glyph)
        scans = [scan for scan in (marks.glyphs[k].grey for k in used) if scan is not None]
        if len(scans) < len(used):
            raise ValueError(f"{len(used) - len(scans)} of the marks' glyphs have no scan; draw their outlines")
        marks = marks.take(marks.scale > 0)
        scan = np.searchsorted(used, marks.glyph)
        framed = [np.pad(patch.grey, 1) for patch in scans]
        side = np.array([patch.pixel_mm for patch in scans])
        middle = np.array([patch.centre_mm / patch.pixel_mm for patch in scans]).reshape(-1, 2)
        turn = np.array([patch.turn for patch in scans])
        own = np.array([marks.glyphs[k].size * np.sqrt(np.pi) / 2 for k in used])  # the scale at which a scan is as large as it was
        shape = np.array([patch.grey.shape[::-1] for patch in scans], np.float64).reshape(-1, 2)
        far = np.hypot(*np.maximum(middle + 0.5, shape - middle + 0.5).T)  # the frame lets ink fade over half a pixel
        finest = (side / own)[scan] * marks.scale  # mm, of a pixel of each mark's scan
        angle = turn[scan] - marks.angle
        return cls(
            np.concatenate([np.empty(0), *(patch.ravel() for patch in framed)]),
            np.cumsum([0, *(patch.size for patch in framed)]),
            np.array([patch.shape[1] for patch in framed], np.int64),
            scan,
            marks.xy,
            np.stack([np.cos(angle), np.sin(angle)], axis=1) / finest[:, None],
            middle,
            far[scan] * finest,
            pixel,
            width,
            max(1, int(np.ceil(max(pixel) / (FINE * finest.min())))) if len(marks) else 1,
        )

    def touches(self, top: int, bottom: int) -> bool:
        """As of a Raster."""
        return len(self._near(top, bottom)) > 0

    def rows(self, top: int, bottom: int) -> Array:
        """The share of its light that each pixel loses, (bottom - top, width): the same bits whatever rows are asked for together."""
        taken = np.empty((bottom - top, self.width))
        step = max(1, HELD // (self.width * self.fine**2))

        def work(lo: int, hi: int) -> None:
            for first in range(lo, hi, step):
                last = min(hi, first + step)
                light = np.ones(((last - first) * self.fine, self.width * self.fine))
                near = self._near(top + first, top + last)
                grid = (self.pixel[0] / self.fine, self.pixel[1] / self.fine)
                scans = (self.grey, self.first, self.wide, self.middle)
                _dimmed(*scans, self.scan, self.place, self.turned, self.reach, near, *grid, (top + first) * self.fine, light)
                taken[first:last] = 1 - light.reshape(last - first, self.fine, self.width, self.fine).mean(axis=(1, 3))

        shared_out(work, bottom - top, ROWS)
        return taken

    def _near(self, top: int, bottom: int) -> Index:
        """The marks that may reach these rows."""
        y, height = self.place[:, 1], self.pixel[1]
        return np.flatnonzero((y + self.reach >= top * height) & (y - self.reach <= bottom * height))


def scanned(marks: Marks) -> bool:
    """Whether there are marks, and each one's glyph has a scan."""
    return len(marks) > 0 and all(marks.glyphs[k].grey is not None for k in np.unique(marks.glyph))


def overlaid(marks: Marks, grid: tuple[int, int], *, pixel: tuple[float, float]) -> Array:
    """The share of its light that each pixel loses under marks whose glyphs have scans, (h, w) for grid (h, w); pixel in mm.

    Where dots that take a and b lie over each other, 1 - (1 - a) (1 - b) is taken.
    """
    return Greys.of(marks, pixel=pixel, width=grid[1]).rows(0, grid[0])


@compiled
def _dimmed(
    grey: Array, first: Index, wide: Index, middle: Array, scan: Index, place: Array, turned: Array, reach: Array, near: Index,
    dx: float, dy: float, top: int, light: Array,
) -> None:  # fmt: skip
    """Takes from light (h, w), samples dx by dy mm of which the first row is number `top`, what the marks `near` take of it."""
    h, w = light.shape
    for i in near:
        k, x, y, r = scan[i], place[i, 0], place[i, 1], reach[i]
        cos, sin = turned[i, 0], turned[i, 1]
        at, across = first[k], wide[k]
        down = (first[k + 1] - at) // across
        begin, end = max(0, int(np.ceil((y - r) / dy - 0.5)) - top), min(h, int(np.floor((y + r) / dy - 0.5)) - top + 1)
        left, right = max(0, int(np.ceil((x - r) / dx - 0.5))), min(w, int(np.floor((x + r) / dx - 0.5)) + 1)
        for row in range(begin, end):
            v = (row + top + 0.5) * dy - y
            for column in range(left, right):
                u = (column + 0.5) * dx - x
                # between the centres of pixels; those of the frame are the scan's number -1
                s, t = cos * u - sin * v + middle[k, 0] + 0.5, sin * u + cos * v + middle[k, 1] + 0.5
                if s < 0 or t < 0 or s >= across - 1 or t >= down - 1:
                    continue
                a, b = int(s), int(t)
                p, q = s - a, t - b
                here = at + b * across + a
                upper = grey[here] * (1 - p) + grey[here + 1] * p
                lower = grey[here + across] * (1 - p) + grey[here + across + 1] * p
                light[row, column] *= 1 - (upper * (1 - q) + lower * q)
