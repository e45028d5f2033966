"""The outline of one dot of a scan: its contour between pixels, the level that is its edge, and how round it is."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
from contourpy import contour_generator
from scipy.interpolate import make_interp_spline
from scipy.spatial import ConvexHull

from crowquill.kernel import compiled
from crowquill.paths import Array

Grey = npt.NDArray[np.floating[Any]]


def iso_contours(patch: Grey) -> Callable[[float], Array]:
    """A function of a level: the longest closed line (n, 2) of x, y in pixels, turning from x to y.

    Pixel (r, c) has its centre at c + .5, r + .5. Between the centres runs a cubic spline, taken at thirds: straight sides
    of a pixel would lose 0.4 % of a dot of 14. Empty where no line closes. The patch has 4 pixels a side or more.
    """
    (y, down), (x, along) = (_thirds(side) for side in patch.shape)
    lines = contour_generator(x, y, down @ np.asarray(patch, np.float64) @ along.T)

    def at(level: float) -> Array:
        rings = [line[:-1] for line in map(np.asarray, lines.lines(level)) if len(line) > 3 and np.array_equal(line[0], line[-1])]
        ring = max(rings, key=lambda ring: arc(ring)[-1], default=np.empty((0, 2)))
        return ring[::-1] if len(ring) and moments(ring)[0] < 0 else ring

    return at


@lru_cache(64)
def _thirds(side: int) -> tuple[Array, Array]:
    """Thirds of so many pixels, from centre to centre, and the matrix that takes values at the centres there."""
    centres, thirds = np.arange(side) + 0.5, np.linspace(0.5, side - 0.5, 3 * side - 2)
    return thirds, make_interp_spline(centres, np.eye(side))(thirds)


def edge_level(patch: Grey, ink: float, half: Array) -> float:
    """The level at which a dot's outline lies: half way from paper (0) to ink, less what blur drew a round edge in.

    half  the contour of the patch at ink / 2

    A blur of standard deviation s draws the half level of a disc of radius r in by s^2 / 2r, where the darkness climbs
    by ink / (s sqrt(2 pi)) a pixel. At 1200 dpi and s = 0.8 pixels that is 1.5 % of the area of a 0.3 mm dot. What was
    smoothed on purpose is measured along with the optics.
    """
    if len(half) < 3:
        return ink / 2
    climb = float(np.median(_climb(np.asarray(patch, np.float64), half)))
    blur = np.sqrt(max(ink * ink / (2 * np.pi * max(climb, 1e-9) ** 2) - 1 / 3, 0))  # 1/3: of differences over two pixels
    radius = np.sqrt(moments(half)[0] / np.pi)
    return float(ink * (0.5 - min(blur / (2 * radius * np.sqrt(2 * np.pi)), 0.06)))  # over 0.06 the blur is as wide as the dot


def shape(ring: Array) -> tuple[float, float, float]:
    """Area, solidity (area by that of the convex hull) and axis ratio (by second moments, 1 for a circle) of a ring of 3 points or more."""
    area, _, _, xx, xy, yy = moments(ring)
    half = np.hypot((xx - yy) / 2, xy)
    middle = (xx + yy) / 2
    return area, area / ConvexHull(ring).volume, float(np.sqrt(max(middle - half, 0) / max(middle + half, 1e-12)))


def arc(ring: Array) -> Array:
    """Length along a closed ring up to each of its points, and all round: (n + 1,)."""
    step = np.diff(ring, axis=0, append=ring[:1])
    return np.concatenate([[0.0], np.cumsum(np.hypot(step[:, 0], step[:, 1]))])


@compiled
def _climb(patch: Array, ring: Array) -> Array:
    """The slope of a patch a pixel, of differences over two, at points between its centres."""
    high, wide = patch.shape
    climb = np.empty(len(ring))
    for k in range(len(ring)):
        x, y = ring[k, 0] - 0.5, ring[k, 1] - 0.5
        c, r = min(max(int(x), 1), wide - 3), min(max(int(y), 1), high - 3)
        u, v = x - c, y - r
        total = 0.0
        for i in range(2):
            for j in range(2):
                a, b = r + i, c + j
                across, down = patch[a, b + 1] - patch[a, b - 1], patch[a + 1, b] - patch[a - 1, b]
                total += (v if i else 1 - v) * (u if j else 1 - u) * np.sqrt(across * across + down * down) / 2
        climb[k] = total
    return climb


@compiled
def moments(ring: Array) -> tuple[float, float, float, float, float, float]:
    """Area, centroid x, y and covariance xx, xy, yy of the inside of a ring of straight sides; zeros where it has no area."""
    area = sx = sy = sxx = sxy = syy = 0.0
    ox, oy = ring[0]
    for k in range(len(ring)):
        a, b = ring[k - 1, 0] - ox, ring[k - 1, 1] - oy
        x, y = ring[k, 0] - ox, ring[k, 1] - oy
        cross = (a * y - x * b) / 2
        area += cross
        sx += cross * (a + x) / 3
        sy += cross * (b + y) / 3
        sxx += cross * (a * a + a * x + x * x) / 6
        sxy += cross * (2 * a * b + a * y + x * b + 2 * x * y) / 12
        syy += cross * (b * b + b * y + y * y) / 6
    if area == 0:
        return 0.0, ox, oy, 0.0, 0.0, 0.0
    sx, sy = sx / area, sy / area
    return area, sx + ox, sy + oy, sxx / area - sx * sx, sxy / area - sx * sy, syy / area - sy * sy
