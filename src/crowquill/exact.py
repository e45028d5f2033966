"""Signs that are right to the last bit: which way three points turn, and whether one lies under a plane of heights.

Floats answer where they are sure; else differences and products are kept whole, as sums of floats that do not overlap.
Source: J. R. Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates, DCG 18, 1997.
"""

from __future__ import annotations

import numpy as np

from crowquill.kernel import compiled
from crowquill.paths import Array

TURN = 4e-16  # of the sum of its two products: an area of differences is good to 3.4e-16
UNDER = 2e-15  # of the sum of its twelve products: a determinant of differences and heights is good to 1.2e-15
SPLIT = 134217729.0  # 2^27 + 1 cuts a float into halves whose products are whole


@compiled
def turn(points: Array, a: int, b: int, c: int) -> float:
    """Over 0 where the points a, b, c of (n, 2) turn from x to y, under 0 where they turn back, and 0 on a line: exact in sign."""
    one = (points[a, 0] - points[c, 0]) * (points[b, 1] - points[c, 1])
    other = (points[a, 1] - points[c, 1]) * (points[b, 0] - points[c, 0])
    if abs(one - other) > TURN * (abs(one) + abs(other)):
        return float(one - other)
    x, y = _less(points[a, 0], points[c, 0]), _less(points[a, 1], points[c, 1])
    u, v = _less(points[b, 0], points[c, 0]), _less(points[b, 1], points[c, 1])
    return float(_sum(_product(x, v), -_product(y, u))[-1])


@compiled
def depth(points: Array, weights: Array | None, a: int, b: int, c: int, d: int) -> float:
    """Over 0 where d lies under the plane of a, b, c, each at the height |x|^2 - weight, under 0 above it, and 0 on it: exact in sign.

    a, b, c turn from x to y. Without weights: over 0 where d lies inside the circle of the others, and 0 on it.
    """
    x, y, w = points[d, 0], points[d, 1], _weight(weights, d)
    ax, ay, bx, by, cx, cy = points[a, 0] - x, points[a, 1] - y, points[b, 0] - x, points[b, 1] - y, points[c, 0] - x, points[c, 1] - y
    aw, bw, cw = _weight(weights, a) - w, _weight(weights, b) - w, _weight(weights, c) - w
    aa, bb, cc = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
    total = (aa - aw) * (bx * cy - by * cx) + (bb - bw) * (cx * ay - cy * ax) + (cc - cw) * (ax * by - ay * bx)
    sizes = (aa + abs(aw) + bb + abs(bw) + cc + abs(cw)) ** 2  # more than the sum of products
    if abs(total) > UNDER * sizes:
        return float(total)
    sizes = (aa + abs(aw)) * (abs(bx * cy) + abs(by * cx)) + (bb + abs(bw)) * (abs(cx * ay) + abs(cy * ax))
    sizes += (cc + abs(cw)) * (abs(ax * by) + abs(ay * bx))
    if abs(total) > UNDER * sizes:
        return float(total)
    whole = np.zeros(1)
    for i, j, k in ((a, b, c), (b, c, a), (c, a, b)):
        height = _height(_less(points[i, 0], x), _less(points[i, 1], y), _less(_weight(weights, i), w))
        area = _area(_less(points[j, 0], x), _less(points[j, 1], y), _less(points[k, 0], x), _less(points[k, 1], y))
        whole = _sum(whole, _product(height, area))
    return float(whole[-1])


@compiled
def under(points: Array, weights: Array, a: int, b: int, c: int, d: int) -> bool:
    """Whether d lies under the plane of a, b, c: see depth()."""
    return bool(depth(points, weights, a, b, c, d) > 0)


@compiled
def _weight(weights: Array | None, i: int) -> float:
    if weights is None:
        return 0.0
    return float(weights[i])


@compiled
def _height(x: Array, y: Array, w: Array) -> Array:
    return _sum(_sum(_product(x, x), _product(y, y)), -w)


@compiled
def _area(x: Array, y: Array, u: Array, v: Array) -> Array:
    return _sum(_product(x, v), -_product(y, u))


@compiled
def _grown(parts: Array, more: float) -> Array:
    """The parts of their sum with one more float: no two share a binary place, they rise, and 0 is among them only alone."""
    out, n, rest = np.empty(len(parts) + 1), 0, more
    for part in parts:
        total = rest + part
        back = total - rest
        lost = (rest - (total - back)) + (part - back)
        rest = total
        if lost != 0:
            out[n] = lost
            n += 1
    if rest != 0 or n == 0:
        out[n] = rest
        n += 1
    return out[:n]


@compiled
def _less(one: float, other: float) -> Array:
    return _grown(np.array([one]), -other)


@compiled
def _sum(one: Array, other: Array) -> Array:
    for part in other:
        one = _grown(one, part)
    return one


@compiled
def _product(one: Array, other: Array) -> Array:
    total = np.zeros(1)
    for a in one:
        high = SPLIT * a - (SPLIT * a - a)
        low = a - high
        for b in other:
            top = SPLIT * b - (SPLIT * b - b)
            rest = b - top
            product = a * b
            total = _grown(_grown(total, low * rest - (((product - high * top) - low * top) - high * rest)), product)
    return total
