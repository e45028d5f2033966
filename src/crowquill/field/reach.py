"""Distances from lines, and the directions in which they grow.

Source: A. Hausner, Simulating Decorative Mosaics, SIGGRAPH 2001, for directions from distances.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from crowquill.field.directions import Field
from crowquill.field.grids import between, coarse, sides
from crowquill.kernel import compiled
from crowquill.paths import Array, Index, Paths, frozen


@dataclass(frozen=True, eq=False)
class Distances:
    """How far the centre of each pixel of a rectangle is from the nearest line: mm (h, w), on a size (width, height) mm."""

    mm: Array
    size: tuple[float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "mm", frozen(self.mm, np.float64, (None, None), "mm"))

    def at(self, xy: npt.ArrayLike) -> Array:
        """The distance at points (n, 2) mm, straight between the pixels' centres, (n,)."""
        return between(self.mm, self.size, xy)

    def field(self, reach: float | None = None, fold: int = 2) -> Field:
        """The directions in which distance grows: straight away from the nearest line.

        Strength is the slope, 1 but where two lines are as near; with a reach in mm it falls off with the distance d
        as e^-(d / reach)^2, so that what is near a line holds and `eased` leads the rest.
        """
        h, w = self.mm.shape
        slope = [
            np.gradient(self.mm, side / count, axis=k) if count > 1 else np.zeros((h, w))
            for k, side, count in ((1, self.size[0], w), (0, self.size[1], h))
        ]
        fall = 1.0 if reach is None else np.exp(-((self.mm / reach) ** 2))
        return Field(np.arctan2(slope[1], slope[0]), np.minimum(np.hypot(*slope), 1.0) * fall, self.size, fold)

    def through(self, slow: Array) -> Distances:
        """The least sums of `slow` (h, w), over 0, along ways from the line: distances where all is as slow as 1.

        Within two squares of a line what is slow there counts for all of the way.
        Source: H. Zhao, A Fast Sweeping Method for Eikonal Equations, Mathematics of Computation 74, 2005.
        """
        (h, w), (width, height) = self.mm.shape, self.size
        near = self.mm < 2 * max(width / w, height / h)
        mm = np.where(near, self.mm * slow, np.inf)
        _sweep(mm, slow, near, width / w, height / h)
        return Distances(np.where(np.isfinite(mm), mm, self.mm * slow), self.size)


def distances(lines: Paths, size: tuple[float, float], grid: tuple[int, int] | None = None) -> Distances:
    """How far each square's centre is from the nearest of some lines; curves are made straight to 1e-4 of the size.

    grid  (h, w) of squares on a size in mm; left out, 40 000 in the shape of the size

    Each square tries the sides that its neighbours are nearest to, from all corners twice: exact but where the places nearest to
    a side do not hang together on the grid, which is where two sides are as near. The outline of a canvas is
    `Paths.of_polygons(tone.canvas)[0]`. Where there are no lines all is as far as the rectangle is across.
    Source: P.-E. Danielsson, Euclidean Distance Mapping, Computer Graphics and Image Processing 14, 1980.
    """
    h, w = coarse(size) if grid is None else grid
    ends = sides(lines.flat(1e-4 * max(size)))
    if not len(ends):
        return Distances(np.full((h, w), np.hypot(*size)), size)
    square, nearest = np.full((h, w), np.inf), np.full((h, w), -1)
    _begun(ends, size[0] / w, size[1] / h, square, nearest)
    _spread(ends, size[0] / w, size[1] / h, square, nearest)
    return Distances(np.sqrt(square), size)


@compiled
def _try(ends: Array, side: int, dx: float, dy: float, r: int, c: int, square: Array, nearest: Index) -> None:
    """Notes a side for a square where it is nearer than the nearest so far."""
    x, y = (c + 0.5) * dx - ends[side, 0, 0], (r + 0.5) * dy - ends[side, 0, 1]
    u, v = ends[side, 1, 0] - ends[side, 0, 0], ends[side, 1, 1] - ends[side, 0, 1]
    length = u * u + v * v
    part = min(max((x * u + y * v) / length, 0.0), 1.0) if length > 0 else 0.0
    far = (x - part * u) ** 2 + (y - part * v) ** 2
    if far < square[r, c]:
        square[r, c], nearest[r, c] = far, side


@compiled
def _begun(ends: Array, dx: float, dy: float, square: Array, nearest: Index) -> None:
    """Tries each side on the squares that it runs through and those around; beyond the grid, on the nearest."""
    h, w = square.shape
    for side in range(len(ends)):
        u, v = ends[side, 1, 0] - ends[side, 0, 0], ends[side, 1, 1] - ends[side, 0, 1]
        count = int(2 * max(abs(u) / dx, abs(v) / dy)) + 1
        for k in range(count + 1):
            column = min(max(int((ends[side, 0, 0] + u * k / count) / dx), 0), w - 1)
            row = min(max(int((ends[side, 0, 1] + v * k / count) / dy), 0), h - 1)
            for r in range(max(row - 1, 0), min(row + 2, h)):
                for c in range(max(column - 1, 0), min(column + 2, w)):
                    _try(ends, side, dx, dy, r, c, square, nearest)


@compiled
def _spread(ends: Array, dx: float, dy: float, square: Array, nearest: Index) -> None:
    """Tries on each square the sides of its neighbours, going from the top and from the bottom, twice."""
    h, w = square.shape
    for sweep in range(4):
        down = 1 if sweep % 2 == 0 else -1
        for m in range(h):
            r = m if down == 1 else h - 1 - m
            for right in (1, -1):
                for k in range(w):
                    c = k if right == 1 else w - 1 - k
                    for i, j in ((r, c - right), (r - down, c - 1), (r - down, c), (r - down, c + 1)):
                        if 0 <= i < h and 0 <= j < w and nearest[i, j] >= 0 and nearest[i, j] != nearest[r, c]:
                            _try(ends, nearest[i, j], dx, dy, r, c, square, nearest)


@compiled
def _sweep(far: Array, slow: Array, known: npt.NDArray[np.bool_], dx: float, dy: float) -> None:
    """Fills in the least sums of `slow` along ways from what is known, by eight sweeps to the corners."""
    h, w = far.shape
    for sweep in range(8):
        down, right = sweep % 2 == 0, sweep // 2 % 2 == 0
        for k in range(h):
            r = k if down else h - 1 - k
            for m in range(w):
                c = m if right else w - 1 - m
                if known[r, c]:
                    continue
                a = min(far[r, c - 1] if c > 0 else np.inf, far[r, c + 1] if c < w - 1 else np.inf)
                b = min(far[r - 1, c] if r > 0 else np.inf, far[r + 1, c] if r < h - 1 else np.inf)
                best = min(a + slow[r, c] * dx, b + slow[r, c] * dy)
                p, q = 1 / dx**2, 1 / dy**2
                inner = (p + q) * slow[r, c] ** 2 - p * q * (a - b) ** 2
                if a < np.inf and b < np.inf and inner >= 0:
                    both = (p * a + q * b + np.sqrt(inner)) / (p + q)
                    if both >= max(a, b):
                        best = min(best, both)
                far[r, c] = min(far[r, c], best)
