"""A Delaunay triangulation kept while its sites move: edges are flipped where they are wrong, nothing is built anew.

The triangles hang on where the points lie and on nothing else: of four points on one circle that with the least index has
the edge, as if it stood a little lower than the rest. So mended triangles are those built anew, and all that is made of them is the
same to the last bit.
Source: C. L. Lawson, Software for C1 Surface Interpolation, 1977, for the flips; H. Edelsbrunner, E. P. Muecke, Simulation of
Simplicity, ACM Transactions on Graphics 9(1), 1990, for the ties.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.exact import depth, turn
from crowquill.kernel import compiled, shared_out
from crowquill.paths import Array

Table = npt.NDArray[np.int32]  # (t, 3): corners of triangles that turn from x to y, or those beside, number k across corners k and k + 1
MANY = 0.25  # of the points: when so many cannot move at once, building anew is sooner
TRIES = 400  # to reach a place, before a point is said to be stuck


def legal(points: Array, vertices: Table, neighbours: Table) -> None:
    """Flips edges until the triangles, in place, are Delaunay's.

    points  (n, 2), all different, and their convex hull filled by the triangles; beyond it the neighbour is -1
    """
    wrong = np.zeros(len(vertices), np.bool_)
    shared_out(lambda lo, hi: _tried(points, vertices, neighbours, wrong, lo, hi), len(wrong))
    _flipped(points, vertices, neighbours, np.flatnonzero(wrong))


def moved(old: Array, new: Array, vertices: Table, neighbours: Table) -> bool:
    """Makes the Delaunay triangles of points that lay at `old`, in place, those of `new`; whether that went well: if not, build anew.

    The hull's corners stay where they are. All points move at once but those that would turn a triangle over; then edges
    are flipped; then these go, one after another, as far as the triangles around let them, and edges are flipped between. Two
    points that would coincide are stuck.
    """
    points = new.copy()
    over = np.zeros(len(vertices), np.bool_)
    held = np.zeros(len(points), np.bool_)
    while True:
        shared_out(lambda lo, hi: _turned_over(points, vertices, over, lo, hi), len(vertices))
        back = np.unique(vertices[over])
        back = back[~held[back]]
        if not len(back):
            break
        held[back] = True
        points[back] = old[back]
    late = np.flatnonzero(held)
    if len(late) > MANY * len(points):
        return False
    legal(points, vertices, neighbours)
    return bool(_led(points, new, vertices, neighbours, late))


@compiled
def _turned_over(points: Array, vertices: Table, over: npt.NDArray[np.bool_], lo: int, hi: int) -> None:
    for t in range(lo, hi):
        over[t] = turn(points, vertices[t, 0], vertices[t, 1], vertices[t, 2]) <= 0


@compiled
def _tried(points: Array, vertices: Table, neighbours: Table, wrong: npt.NDArray[np.bool_], lo: int, hi: int) -> None:
    """Marks triangles with an edge to flip, each edge tried in one of its two."""
    for t in range(lo, hi):
        for k in range(3):
            if neighbours[t, k] < t and _is_wrong(points, vertices, neighbours, t, k):
                wrong[t] = True


@compiled
def _is_wrong(points: Array, vertices: Table, neighbours: Table, t: int, k: int) -> bool:
    """Whether edge k of t is to be flipped: what lies across is inside the circle of t, or on it and the edge is not the least's."""
    u = neighbours[t, k]
    if u < 0:
        return False
    a, b, c = vertices[t, k], vertices[t, (k + 1) % 3], vertices[t, (k + 2) % 3]
    d = vertices[u, (_side(neighbours, u, t) + 2) % 3]
    inside = depth(points, None, a, b, c, d)
    return bool(inside > 0 or (inside == 0 and min(c, d) < min(a, b)))


@compiled
def _side(neighbours: Table, t: int, u: int) -> int:
    """Which side of t the triangle u lies across."""
    return 0 if neighbours[t, 0] == u else 1 if neighbours[t, 1] == u else 2


@compiled
def _flip(vertices: Table, neighbours: Table, t: int, k: int) -> int:
    """Turns edge k of t, both triangles then beginning with a corner of the old edge; returns the other triangle."""
    u = neighbours[t, k]
    j = _side(neighbours, u, t)
    a, b, c, d = vertices[t, k], vertices[t, (k + 1) % 3], vertices[t, (k + 2) % 3], vertices[u, (j + 2) % 3]
    beyond_bc, beyond_ca = neighbours[t, (k + 1) % 3], neighbours[t, (k + 2) % 3]
    beyond_ad, beyond_db = neighbours[u, (j + 1) % 3], neighbours[u, (j + 2) % 3]
    vertices[t, 0], vertices[t, 1], vertices[t, 2] = a, d, c
    neighbours[t, 0], neighbours[t, 1], neighbours[t, 2] = beyond_ad, u, beyond_ca
    vertices[u, 0], vertices[u, 1], vertices[u, 2] = b, c, d
    neighbours[u, 0], neighbours[u, 1], neighbours[u, 2] = beyond_bc, t, beyond_db
    if beyond_ad >= 0:
        neighbours[beyond_ad, _side(neighbours, beyond_ad, u)] = t
    if beyond_bc >= 0:
        neighbours[beyond_bc, _side(neighbours, beyond_bc, t)] = u
    return int(u)


@compiled
def _flipped(points: Array, vertices: Table, neighbours: Table, first: Any) -> None:
    """Flips edges of these triangles, and of those that flips change, until none is wrong."""
    waiting = np.empty(max(64, 2 * len(first)), np.int64)
    waiting[: len(first)] = first
    _settled(points, vertices, neighbours, waiting, len(first), np.empty(0, np.int64))


@compiled
def _settled(points: Array, vertices: Table, neighbours: Table, waiting: Any, count: int, begin: Any) -> Any:
    """Flips edges of the first `count` triangles waiting until none is wrong; returns the list, which may have grown.

    begin  a triangle of each point, kept right; or nothing
    """
    while count > 0:
        count -= 1
        t = waiting[count]
        for k in range(3):
            if _is_wrong(points, vertices, neighbours, t, k):
                a, b = vertices[t, k], vertices[t, (k + 1) % 3]
                u = _flip(vertices, neighbours, t, k)
                if len(begin):
                    begin[a], begin[b] = t, u
                if count + 2 > len(waiting):
                    more = np.empty(2 * len(waiting), np.int64)
                    more[:count] = waiting[:count]
                    waiting = more
                waiting[count], waiting[count + 1] = u, t
                count += 2
                break
    return waiting


@compiled
def _led(points: Array, new: Array, vertices: Table, neighbours: Table, late: Any) -> bool:
    """Leads each late point to its new place, as far at a time as no triangle turns over; False where one is stuck."""
    begin = np.empty(len(points), np.int64)
    if len(late):
        for t in range(len(vertices)):
            for k in range(3):
                begin[vertices[t, k]] = t
    waiting = np.empty(256, np.int64)
    for v in late:
        x, y = points[v, 0], points[v, 1]
        share, tries = 1.0, 0
        while points[v, 0] != new[v, 0] or points[v, 1] != new[v, 1]:
            if share == 1.0:
                points[v, 0], points[v, 1] = new[v, 0], new[v, 1]
            else:
                points[v, 0], points[v, 1] = x + share * (new[v, 0] - x), y + share * (new[v, 1] - y)
            count = _star(points, vertices, neighbours, begin[v], v, waiting)
            tries += 1
            if count == 0:
                if tries > TRIES:
                    return False
                points[v, 0], points[v, 1] = x, y
                share /= 2
                continue
            waiting = _settled(points, vertices, neighbours, waiting, count, begin)
            x, y = points[v, 0], points[v, 1]
            share = 1.0
    return True


@compiled
def _star(points: Array, vertices: Table, neighbours: Table, t: int, v: int, around: Any) -> int:
    """Puts the triangles around v, of which t is one, into `around` and returns how many; 0 where one does not turn from x to y."""
    count, now = 0, t
    while True:
        if count == len(around) or turn(points, vertices[now, 0], vertices[now, 1], vertices[now, 2]) <= 0:
            return 0
        around[count] = now
        count += 1
        for k in range(3):
            if vertices[now, k] == v:
                now = neighbours[now, k]
                break
        if now == t:
            return count
