"""The regular triangulation of weighted sites, of which power cells are the dual: sites are put in one by one, and edges flipped.

Stand each site at the height |x|^2 - weight: the triangles are the underside of the hull of all, and a site above it is in
none. With equal weights it is Delaunay's.
Source: H. Edelsbrunner, N. R. Shah, Incremental Topological Flipping Works for Regular Triangulations, Algorithmica 15, 1996.
"""

from __future__ import annotations

import numpy as np

from crowquill import hilbert
from crowquill.exact import turn, under
from crowquill.kernel import compiled
from crowquill.paths import Array, Index

RING = 4  # the last points, a convex ring around all others


def triangulated(points: Array, weights: Array) -> tuple[Index, Index]:
    """Vertices (t, 3), turning from x to y, and neighbours (t, 3): that of number k lies across vertices k and k + 1, -1 beyond all.

    points   (n + 4, 2), all different; the last four a convex ring around the others, turning from x to y
    weights  (n + 4,) mm^2
    """
    n = len(points) - RING
    vertices, neighbours = np.full((2 * n + 2, 3), -1, np.int64), np.full((2 * n + 2, 3), -1, np.int64)
    vertices[:2] = (n, n + 1, n + 2), (n, n + 2, n + 3)
    neighbours[0, 2], neighbours[1, 0] = 1, 0
    _put_in(points, weights, hilbert.of_points(points[:n]), vertices, neighbours)
    kept = np.flatnonzero(vertices[:, 0] >= 0)
    place = np.full(len(vertices) + 1, -1)  # the last row is for what lies beyond all
    place[kept] = np.arange(len(kept))
    return vertices[kept], place[neighbours[kept]]


@compiled
def _put_in(points: Array, weights: Array, order: Index, vertices: Index, neighbours: Index) -> None:
    """Puts points in, in this order. Rows of -1 are free; triangles at the point that is put in begin with it.

    Only sides across from that point can be wrong. Such a side is flipped, or an end of it left out that lies above its neighbours;
    where neither can be done, flips beside it make it possible.
    """
    free = np.arange(len(vertices) - 1, 1, -1)
    left, t = len(free), 0
    waiting = np.empty(len(vertices) + 4, np.int64)
    for p in order:
        t = _around(points, vertices, neighbours, t, p)
        a, b, c = vertices[t, 0], vertices[t, 1], vertices[t, 2]
        if weights[p] < max(weights[a], weights[b], weights[c]) and not under(points, weights, a, b, c, p):
            continue
        left -= 2
        _split(vertices, neighbours, t, p, free[left], free[left + 1])
        waiting[0], waiting[1], waiting[2], count = t, free[left], free[left + 1], 3
        for k in range(3):  # a point on a side parts the triangle beyond as well
            if turn(points, vertices[waiting[k], 1], vertices[waiting[k], 2], p) == 0:
                waiting[count] = _flipped(vertices, neighbours, waiting[k])
                count += 1
        while count > 0:
            count -= 1
            if vertices[waiting[count], 0] != p:  # left out meanwhile
                continue
            t = waiting[count]
            u, x, y = neighbours[t, 1], vertices[t, 1], vertices[t, 2]
            if u < 0:
                continue
            d = vertices[u, (_side(neighbours, u, t) + 2) % 3]
            if not under(points, weights, p, x, y, d):
                continue
            at_x, at_y = turn(points, p, x, d), turn(points, d, y, p)
            inner = x if at_x <= 0 else y
            straight = at_x == 0 or at_y == 0
            if at_x > 0 and at_y > 0:
                waiting[count], waiting[count + 1] = t, _flipped(vertices, neighbours, t)
                count += 2
            elif _degree(vertices, neighbours, t, inner) == 3 + straight:
                if straight:
                    other = _flipped(vertices, neighbours, t)
                    t, other = (t, other) if inner == x else (other, t)
                    waiting[count] = other
                    count += 1
                free[left], free[left + 1] = _merged(vertices, neighbours, t, inner)
                left += 2
                waiting[count] = t
                count += 1


@compiled
def _around(points: Array, vertices: Index, neighbours: Index, t: int, p: int) -> int:
    """The triangle that point p lies in, or on the border of, on a walk from t: in a regular triangulation none comes back."""
    while True:
        for k in range(3):
            if turn(points, vertices[t, k], vertices[t, (k + 1) % 3], p) < 0:
                t = int(neighbours[t, k])
                break
        else:
            return t


@compiled
def _side(neighbours: Index, t: int, u: int) -> int:
    """Which side of t the triangle u lies across."""
    return 0 if neighbours[t, 0] == u else 1 if neighbours[t, 1] == u else 2


@compiled
def _split(vertices: Index, neighbours: Index, t: int, p: int, u: int, v: int) -> None:
    """Parts t about p into t, u and v, which all begin with p."""
    a, b, c = vertices[t, 0], vertices[t, 1], vertices[t, 2]
    beyond_b, beyond_c = neighbours[t, 1], neighbours[t, 2]
    vertices[t, 0], vertices[t, 1], vertices[t, 2] = p, a, b
    vertices[u, 0], vertices[u, 1], vertices[u, 2] = p, b, c
    vertices[v, 0], vertices[v, 1], vertices[v, 2] = p, c, a
    neighbours[t, 1] = neighbours[t, 0]
    neighbours[t, 0], neighbours[t, 2] = v, u
    neighbours[u, 0], neighbours[u, 1], neighbours[u, 2] = t, beyond_b, v
    neighbours[v, 0], neighbours[v, 1], neighbours[v, 2] = u, beyond_c, t
    _beside(neighbours, beyond_b, t, u)
    _beside(neighbours, beyond_c, t, v)


@compiled
def _beside(neighbours: Index, t: int, old: int, new: int) -> None:
    """Tells t, if it is a triangle, that beside it there is a new one in the place of an old one."""
    if t >= 0:
        neighbours[t, _side(neighbours, t, old)] = new


@compiled
def _flipped(vertices: Index, neighbours: Index, t: int) -> int:
    """Turns the side of t across from its first vertex; returns the other triangle, which then begins with that vertex too."""
    u = int(neighbours[t, 1])
    j = _side(neighbours, u, t)
    p, y, d = vertices[t, 0], vertices[t, 2], vertices[u, (j + 2) % 3]
    beyond_x, beyond_y, beyond_p = neighbours[u, (j + 1) % 3], neighbours[u, (j + 2) % 3], neighbours[t, 2]
    vertices[t, 2], neighbours[t, 1], neighbours[t, 2] = d, beyond_x, u
    vertices[u, 0], vertices[u, 1], vertices[u, 2] = p, d, y
    neighbours[u, 0], neighbours[u, 1], neighbours[u, 2] = t, beyond_y, beyond_p
    _beside(neighbours, beyond_x, u, t)
    _beside(neighbours, beyond_p, t, u)
    return u


@compiled
def _degree(vertices: Index, neighbours: Index, t: int, v: int) -> int:
    """How many triangles lie around v, of which t is one; 5 stands for more and for those at the border of all."""
    now = t
    for count in range(1, 5):
        for k in range(3):
            if vertices[now, k] == v:
                now = neighbours[now, k]
                break
        if now == t:
            return count
        if now < 0:
            break
    return 5


@compiled
def _merged(vertices: Index, neighbours: Index, t: int, v: int) -> tuple[int, int]:
    """Makes one of the three triangles around v, of which t is one and begins as before; returns the other two, which are free."""
    i = 1 if vertices[t, 1] == v else 2
    before, after = int(neighbours[t, i - 1]), int(neighbours[t, i])
    j, k = _side(neighbours, before, t), _side(neighbours, after, t)
    vertices[t, i] = vertices[before, (j + 2) % 3]
    neighbours[t, i - 1], neighbours[t, i] = neighbours[before, (j + 1) % 3], neighbours[after, (k + 2) % 3]
    _beside(neighbours, neighbours[t, i - 1], before, t)
    _beside(neighbours, neighbours[t, i], after, t)
    vertices[before, 0] = vertices[after, 0] = -1
    return before, after
