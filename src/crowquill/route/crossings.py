"""Where the links of a ring of dots cross or touch, found without rounding.

Source: J. R. Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates,
Discrete & Computational Geometry 18, 1997, for signs that are always right.
"""

from __future__ import annotations

import numpy as np

from crowquill.kernel import compiled
from crowquill.paths import Array, Index

SURE = 4e-16  # of the sum of both products: a little over the 3.3e-16 by which rounding may change their difference
SPLIT = 134217729.0  # 2^27 + 1 parts a float into halves whose products are exact
FILL = 2.0  # links to a square of the grid, about


def crossings(a: Array, b: Array) -> Index:
    """Pairs of links from a[i] to b[i] that have a place in common which is not an end of both, (k, 2), each pair once, sorted.

    a, b  (n, 2) mm. Links of no length, and those with an end that is not a number, meet none.
    """
    drawn = np.flatnonzero((a != b).any(axis=1) & ~np.isnan(a + b).any(axis=1))
    if len(drawn) < 2:
        return np.zeros((0, 2), np.int64)
    start, ends = a[drawn], b[drawn]
    low = np.minimum(start, ends).min(axis=0)
    span = np.maximum(start, ends).max(axis=0) - low
    side = max(float(np.sqrt(span.prod() * FILL / len(drawn))), float(span.max()) * FILL / len(drawn))
    columns, rows = (np.floor(span / side).astype(np.int64) + 1).tolist()
    first = np.zeros(columns * rows + 1, np.int64)
    listed = np.empty(0, np.int64)
    for known in (False, True):  # how many to a square, then which
        if known:
            first = np.concatenate([[0], np.cumsum(first[:-1])])
            listed = np.empty(first[-1], np.int64)
        _listed(start, ends, low, side, columns, rows, first.copy() if known else first, listed, known)
    pairs = np.empty((1024, 2), np.int64)
    while (count := _meeting(start, ends, first, listed, pairs)) > len(pairs):
        pairs = np.empty((count, 2), np.int64)
    found: Index = np.unique(drawn[pairs[:count]], axis=0)
    return found


@compiled
def _listed(a: Array, b: Array, low: Array, side: float, columns: int, rows: int, at: Index, listed: Index, known: bool) -> None:
    """Counts the links in each square that they run through, or one beside it, or lists them from where `at` says."""
    for i in range(len(a)):
        x, y = (a[i, 0] - low[0]) / side, (a[i, 1] - low[1]) / side
        u, v = (b[i, 0] - low[0]) / side, (b[i, 1] - low[1]) / side
        if y > v:
            x, y, u, v = u, v, x, y
        for row in range(max(0, int(y - 1e-9)), min(rows - 1, int(v + 1e-9)) + 1):
            p, q = x, u
            if v > y:
                p = x + (u - x) * min(max((row - y) / (v - y), 0.0), 1.0)
                q = x + (u - x) * min(max((row + 1 - y) / (v - y), 0.0), 1.0)
            for column in range(max(0, int(min(p, q) - 1e-6)), min(columns - 1, int(max(p, q) + 1e-6)) + 1):
                square = row * columns + column
                if known:
                    listed[at[square]] = i
                at[square] += 1


@compiled
def _meeting(a: Array, b: Array, first: Index, listed: Index, pairs: Index) -> int:
    """Fills in pairs of links that meet, some more than once, as far as there is room; returns how many there are."""
    count = 0
    for square in range(len(first) - 1):
        for k in range(first[square], first[square + 1]):
            for m in range(first[square], k):
                i, j = listed[k], listed[m]
                if meets(a[i, 0], a[i, 1], b[i, 0], b[i, 1], a[j, 0], a[j, 1], b[j, 0], b[j, 1]):
                    if count < len(pairs):
                        pairs[count, 0], pairs[count, 1] = min(i, j), max(i, j)
                    count += 1
    return count


@compiled
def meets(ax: float, ay: float, bx: float, by: float, cx: float, cy: float, dx: float, dy: float) -> bool:
    """Whether the links ab and cd share a place that is not an end of both."""
    if max(ax, bx) < min(cx, dx) or max(cx, dx) < min(ax, bx) or max(ay, by) < min(cy, dy) or max(cy, dy) < min(ay, by):
        return False
    c, d = turn(ax, ay, bx, by, cx, cy), turn(ax, ay, bx, by, dx, dy)
    if c * d > 0:
        return False
    a, b = turn(cx, cy, dx, dy, ax, ay), turn(cx, cy, dx, dy, bx, by)
    if a * b > 0:
        return False
    if a * b < 0 and c * d < 0:
        return True
    return (  # an end of one inside the other
        (c == 0 and _inside(ax, ay, bx, by, cx, cy))
        or (d == 0 and _inside(ax, ay, bx, by, dx, dy))
        or (a == 0 and _inside(cx, cy, dx, dy, ax, ay))
        or (b == 0 and _inside(cx, cy, dx, dy, bx, by))
        or (c == 0 and d == 0 and min(ax, bx) == min(cx, dx) and max(ax, bx) == max(cx, dx) and min(ay, by) == min(cy, dy))
    )


@compiled
def crosses(a: Array, b: Array, c: Array, d: Array) -> bool:
    """Whether the links ab and cd cross inside both."""
    return turn(a[0], a[1], b[0], b[1], c[0], c[1]) * turn(a[0], a[1], b[0], b[1], d[0], d[1]) < 0 and (
        turn(c[0], c[1], d[0], d[1], a[0], a[1]) * turn(c[0], c[1], d[0], d[1], b[0], b[1]) < 0
    )


@compiled
def _inside(ax: float, ay: float, bx: float, by: float, px: float, py: float) -> bool:
    """Whether p, on the line through a and b, lies between them and is neither."""
    if (px == ax and py == ay) or (px == bx and py == by):
        return False
    return min(ax, bx) <= px <= max(ax, bx) and min(ay, by) <= py <= max(ay, by)


@compiled
def turn(ax: float, ay: float, bx: float, by: float, px: float, py: float) -> int:
    """1 where p lies on the side of ab to which x turns towards y, -1 on the other, 0 on the line."""
    left, right = (bx - ax) * (py - ay), (by - ay) * (px - ax)
    d = left - right
    if abs(d) > SURE * (abs(left) + abs(right)):
        return 1 if d > 0 else -1
    # each product of two coordinates as two floats, their sum without rounding: the sign is that of the largest that is left
    sums = np.zeros(12)
    factors = ((bx, py), (-ax, py), (-bx, ay), (-by, px), (ay, px), (by, ax))
    for k in range(6):
        high, low = _product(factors[k][0], factors[k][1])
        _add(sums, 2 * k, low)
        _add(sums, 2 * k + 1, high)
    for k in range(11, -1, -1):
        if sums[k] != 0:
            return 1 if sums[k] > 0 else -1
    return 0


@compiled
def _product(x: float, y: float) -> tuple[float, float]:
    """The product of two floats, and what rounding took from it."""
    high = x * y
    p = SPLIT * x
    x1 = p - (p - x)
    p = SPLIT * y
    y1 = p - (p - y)
    x2, y2 = x - x1, y - y1
    return high, x2 * y2 - (((high - x1 * y1) - x2 * y1) - x1 * y2)


@compiled
def _add(sums: Array, held: int, value: float) -> None:
    """Adds a float to a sum of `held` floats that do not overlap, the smallest first, so that one more holds the exact sum."""
    for k in range(held):
        high = value + sums[k]
        part = high - value
        sums[k] = (value - (high - part)) + (sums[k] - part)
        value = high
    sums[held] = value
