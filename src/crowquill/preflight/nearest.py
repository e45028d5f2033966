"""The shortest way between two lines of many sides: compiled, for millions of pairs of neighbours."""

from __future__ import annotations

import numpy as np

from crowquill.kernel import compiled, shared_out
from crowquill.paths import Array, Index


def nearest(xy: Array, start: Index, bounds: Array, i: Index, j: Index, reach: Array) -> tuple[Array, Array]:
    """For each pair of lines their distance, (n,), and the two ends of the shortest way, (n, 2, 2); inf beyond reach, 0 where they cross.

    xy (m, 2) and start (k + 1,): the lines, of two points or more; bounds (k, 4): left, top, right, bottom of each; reach (n,)
    """
    gap, ends = np.full(len(i), np.inf), np.zeros((len(i), 2, 2))

    def work(lo: int, hi: int) -> None:
        _pairs(xy, start, bounds, i[lo:hi], j[lo:hi], reach[lo:hi], gap[lo:hi], ends[lo:hi])

    shared_out(work, len(i))
    return gap, ends


@compiled
def _pairs(xy: Array, start: Index, bounds: Array, i: Index, j: Index, reach: Array, gap: Array, ends: Array) -> None:
    for k in range(len(i)):
        one, other, best = i[k], j[k], reach[k]
        for s in range(start[one], start[one + 1] - 1):
            left, right = min(xy[s, 0], xy[s + 1, 0]), max(xy[s, 0], xy[s + 1, 0])
            top, bottom = min(xy[s, 1], xy[s + 1, 1]), max(xy[s, 1], xy[s + 1, 1])
            if left - best > bounds[other, 2] or right + best < bounds[other, 0]:
                continue
            if top - best > bounds[other, 3] or bottom + best < bounds[other, 1]:
                continue
            for t in range(start[other], start[other + 1] - 1):
                if min(xy[t, 0], xy[t + 1, 0]) - best > right or max(xy[t, 0], xy[t + 1, 0]) + best < left:
                    continue
                if min(xy[t, 1], xy[t + 1, 1]) - best > bottom or max(xy[t, 1], xy[t + 1, 1]) + best < top:
                    continue
                if _cross(xy, s, t):
                    best = gap[k] = 0.0
                    break
                for end in range(4):
                    p, side = (s + end, t) if end < 2 else (t + end - 2, s)
                    along = _along(xy, p, side)
                    x = xy[side, 0] + along * (xy[side + 1, 0] - xy[side, 0])
                    y = xy[side, 1] + along * (xy[side + 1, 1] - xy[side, 1])
                    far = np.sqrt((xy[p, 0] - x) ** 2 + (xy[p, 1] - y) ** 2)
                    if far < best:
                        best = gap[k] = far
                        ends[k, 0, 0], ends[k, 0, 1], ends[k, 1, 0], ends[k, 1, 1] = xy[p, 0], xy[p, 1], x, y
            if gap[k] == 0:
                break


@compiled
def _along(xy: Array, p: int, a: int) -> float:
    """How far along the side that begins at point a, 0 to 1, it is nearest to point p."""
    dx, dy = xy[a + 1, 0] - xy[a, 0], xy[a + 1, 1] - xy[a, 1]
    square = dx * dx + dy * dy
    return 0.0 if square == 0 else float(min(1.0, max(0.0, ((xy[p, 0] - xy[a, 0]) * dx + (xy[p, 1] - xy[a, 1]) * dy) / square)))


@compiled
def _turn(xy: Array, a: int, c: int) -> float:
    """On which side of the side that begins at point a point c lies, by its sign."""
    return float((xy[a + 1, 0] - xy[a, 0]) * (xy[c, 1] - xy[a, 1]) - (xy[a + 1, 1] - xy[a, 1]) * (xy[c, 0] - xy[a, 0]))


@compiled
def _cross(xy: Array, a: int, c: int) -> bool:
    """Whether the sides that begin at two points cross; those that touch are 0 apart in any case."""
    return _turn(xy, a, c) * _turn(xy, a, c + 1) < 0 and _turn(xy, c, a) * _turn(xy, c, a + 1) < 0
