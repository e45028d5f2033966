"""The centres of triangles' circles, where cells meet: one for all triangles whose corners lie on one circle."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.kernel import compiled, shared_out
from crowquill.mending import Table
from crowquill.paths import Array, Index


def centres(points: Array, weights: Array | None, vertices: Table, neighbours: Table, reach: float) -> Array:
    """The centre of each triangle's circle, or with weights the place of equal power to its corners, (t, 2) mm.

    points      (n, 2) mm, within some `reach` of where coordinates are taken about; weights (n,) mm^2
    vertices    (t, 3), turning from x to y; neighbours (t, 3): that of number k lies across vertices k and k + 1, or is -1

    Neither the order of the triangles nor that of their corners matters, not even to the last bit.
    """
    found = np.empty((len(vertices), 2))
    shared_out(lambda lo, hi: _circumcentres(points, weights, vertices, found, lo, hi), len(vertices))
    close = np.zeros(len(vertices), np.bool_)
    shared_out(lambda lo, hi: _close(points, vertices, neighbours, found, reach, close, lo, hi), len(vertices))
    _gathered(points, vertices, neighbours, found, reach, np.flatnonzero(close))
    return found


@compiled
def _circumcentres(points: Array, weights: Array | None, vertices: Table, centres: Array, lo: int, hi: int) -> None:
    """The centre of each triangle's circle, of equal power to its corners.

    Reckoned from an end of the shortest side: two close corners differ exactly in floats, and
    a third far off would swamp that difference. Corners are gone through from the least, so that their order in the table is nothing.
    """
    for t in range(lo, hi):
        first = 0
        for k in range(1, 3):
            if vertices[t, k] < vertices[t, first]:
                first = k
        near, least = 0, np.inf
        for k in range(first, first + 3):
            p, q = vertices[t, k % 3], vertices[t, (k + 1) % 3]
            side = (points[q, 0] - points[p, 0]) ** 2 + (points[q, 1] - points[p, 1]) ** 2
            if side < least:
                near, least = k % 3, side
        a, b, c = vertices[t, near], vertices[t, (near + 1) % 3], vertices[t, (near + 2) % 3]
        x, y = points[a, 0], points[a, 1]
        bx, by, cx, cy = points[b, 0] - x, points[b, 1] - y, points[c, 0] - x, points[c, 1] - y
        twice = 2 * (bx * cy - by * cx)
        if twice == 0:  # too thin for floats: the middle of its longest reach stands in
            centres[t, 0], centres[t, 1] = x + cx / 2, y + cy / 2
            continue
        bb, cc = bx * bx + by * by, cx * cx + cy * cy
        if weights is not None:
            bb, cc = bb + (weights[a] - weights[b]), cc + (weights[a] - weights[c])
        centres[t, 0], centres[t, 1] = x + (cy * bb - by * cc) / twice, y + (bx * cc - cx * bb) / twice


@compiled
def _are_close(points: Array, vertices: Table, neighbours: Table, centres: Array, reach: float, t: int, k: int) -> bool:
    """Whether the centres of t and of its neighbour k, both at the same corners, differ by rounding alone."""
    u = neighbours[t, k]
    if u < 0:
        return False
    corner = min(vertices[t, k], vertices[t, (k + 1) % 3])
    apart = abs(centres[u, 0] - centres[t, 0]) + abs(centres[u, 1] - centres[t, 1])
    x, y = max(abs(centres[t, 0]), abs(centres[u, 0])), max(abs(centres[t, 1]), abs(centres[u, 1]))
    radius = max(
        abs(centres[t, 0] - points[corner, 0]) + abs(centres[t, 1] - points[corner, 1]),
        abs(centres[u, 0] - points[corner, 0]) + abs(centres[u, 1] - points[corner, 1]),
    )
    # a centre is good to some last digits of its radius, and of its coordinates about a far origin; thin triangles cost two more
    return bool(apart < min(1e-6 * radius, 1e-13 * radius + 2e-14 * (x + y + reach)))


@compiled
def _close(
    points: Array, vertices: Table, neighbours: Table, centres: Array, reach: float, close: npt.NDArray[np.bool_], lo: int, hi: int
) -> None:
    """Marks triangles with a centre close to that of one before them."""
    for t in range(lo, hi):
        for k in range(3):
            if neighbours[t, k] < t and _are_close(points, vertices, neighbours, centres, reach, t, k):
                close[t] = True


@compiled
def _gathered(points: Array, vertices: Table, neighbours: Table, centres: Array, reach: float, close: Index) -> None:
    """Makes one of centres that differ by rounding alone, as those of triangles whose corners lie on one circle.

    Triangles are joined to neighbours of the same centre, and all of a group take the one of least x, then y: so that the
    many triangles of a regular polygon agree to the last bit.
    """
    if not len(close):
        return
    group: Any = np.arange(len(vertices))
    for t in close:
        for k in range(3):
            u = neighbours[t, k]
            if not 0 <= u < t or not _are_close(points, vertices, neighbours, centres, reach, t, k):
                continue
            mine, other = t, np.int64(u)
            while group[mine] != mine:
                mine = group[mine]
            while group[other] != other:
                other = group[other]
            x, y = centres[mine, 0] - centres[other, 0], centres[mine, 1] - centres[other, 1]
            if x < 0 or (x == 0 and y < 0):
                mine, other = other, mine
            group[mine] = other
    for t in range(len(group)):
        root = t
        while group[root] != root:
            root = group[root]
        group[t] = root
        centres[t, 0], centres[t, 1] = centres[root, 0], centres[root, 1]
