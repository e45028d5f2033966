"""The integrals of coverage to the left of an edge, from sums over the pixels of each row: the part of a cell's moments that it bears.

Source: A. Secord, Weighted Voronoi Stippling, NPAR 2002, for the sums; Green's theorem for the edges.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crowquill.kernel import compiled
from crowquill.paths import Array
from crowquill.tone import BLOCK

Part = tuple[float, float, float, float, float, float, float]


class Band(NamedTuple):
    """Sums of rows of a picture of so many: see Tone.prefix."""

    prefix: Array
    top: int
    rows: int


@compiled
def edge(band: Band, left: float, top: float, x0: float, y0: float, x1: float, y1: float) -> Part:
    """The integrals of 1, x, y, xx, xy, yy times the coverage left of an edge, about (left, top), and the absolute parts of the first.

    Of the part of it that lies in the band; the first of all rows reaches up without end, and the last down. Pixel by pixel along
    it. Where "left" begins is one and the same for a row, and cancels round a ring.
    """
    m = mx = my = xx = xy = yy = size = 0.0
    dx, dy = x1 - x0, y1 - y0
    if dy == 0:  # along a row there is nothing to integrate
        return m, mx, my, xx, xy, yy, size
    prefix, first, last, columns = band.prefix, band.top, band.top + len(band.prefix) - 1, band.prefix.shape[1]
    j, j_end = min(max(int(np.floor(y0)), 0), band.rows - 1), min(max(int(np.floor(y1)), 0), band.rows - 1)
    if max(j, j_end) < first or min(j, j_end) > last:
        return m, mx, my, xx, xy, yy, size
    right, down = 1 if dx > 0 else -1, 1 if dy > 0 else -1
    t, end, along = 0.0, 1.0, 1 / dy
    if not first <= j <= last:
        j = first if down > 0 else last
        t = ((j + (down < 0)) - y0) * along
    if not first <= j_end <= last:
        j_end = last if down > 0 else first
        end = ((j_end + (down > 0)) - y0) * along
    i = min(max(int(np.floor(x0 + t * dx)), 0), columns - 1)
    i_end = min(max(int(np.floor(x1 if end == 1 else x0 + end * dx)), 0), columns - 1)
    # where along the edge, 0 to 1, it crosses into the next column and the next row
    across = 1 / dx if i != i_end else 0.0
    x_at = ((i + (right > 0)) - x0) * across if i != i_end else 2.0
    y_at = ((j + (down > 0)) - y0) * along if j != j_end else 2.0
    while True:
        until = min(x_at, y_at, end)
        if until > t:
            a0, a1, a2 = _before(prefix, int(left), i, j - first)
            rho, edge = prefix[j - first, i, 3], i - left
            a0, a1, a2 = a0 - rho * edge, a1 - rho * edge * edge / 2, a2 - rho * edge * edge * edge / 3
            half, way = (t + until) / 2, (until - t) / 2
            # the middle of the piece and half of its way: means along it of powers of x and y
            x, y, u, v, h = x0 + half * dx - left, y0 + half * dy - top, way * dx, way * dy, 2 * way * dy
            uu, uv, vv = u * u / 3, u * v / 3, v * v / 3
            r0 = a0 + rho * x
            r1 = a1 + rho * (x * x + uu) / 2
            m += h * r0
            size += abs(h * r0)
            mx += h * r1
            my += h * (r0 * y + rho * uv)
            xx += h * (a2 + rho * x * (x * x + 3 * uu) / 3)
            xy += h * (r1 * y + rho * x * uv)
            yy += h * (r0 * (y * y + vv) + 2 * rho * y * uv)
            t = until
        if i == i_end and j == j_end:
            if t >= end:
                break
            x_at = y_at = 2.0
        elif x_at <= y_at:
            i += right
            x_at = ((i + (right > 0)) - x0) * across if i != i_end else 2.0
        else:
            j += down
            y_at = ((j + (down > 0)) - y0) * along if j != j_end else 2.0
    return m, mx, my, xx, xy, yy, size


@compiled
def _before(prefix: Array, left: int, i: int, j: int) -> tuple[float, float, float]:
    """The sums of coverage times 1, x, x^2 over the pixels of row j from the block of `left` to column i, x counted from `left`."""
    block = i // BLOCK
    a0, a1, a2 = _about(prefix[j, i, 0], prefix[j, i, 1], prefix[j, i, 2], float(block * BLOCK - left))
    low, high, sign = (left // BLOCK, block, 1.0) if block >= left // BLOCK else (block, left // BLOCK, -1.0)
    for b in range(low, high):
        end = (b + 1) * BLOCK - 1  # the block's last pixel makes its sums whole
        rho = prefix[j, end, 3]
        e0, e1 = float(BLOCK - 1), float(BLOCK)
        s0 = prefix[j, end, 0] + rho
        s1 = prefix[j, end, 1] + rho * (e1 * e1 - e0 * e0) / 2
        s2 = prefix[j, end, 2] + rho * (e1 * e1 * e1 - e0 * e0 * e0) / 3
        s0, s1, s2 = _about(s0, s1, s2, float(b * BLOCK - left))
        a0, a1, a2 = a0 + sign * s0, a1 + sign * s1, a2 + sign * s2
    return a0, a1, a2


@compiled
def _about(s0: float, s1: float, s2: float, shift: float) -> tuple[float, float, float]:
    """Sums of 1, x, x^2 with every x larger by `shift`."""
    return s0, s1 + shift * s0, s2 + 2 * shift * s1 + shift * shift * s0
