"""The triangulation behind the cells, Delaunay's or by weights, and its dual: centres of circles, fans of them around the sites."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pythoncdt

from crowquill import circles, mending, regular
from crowquill.kernel import compiled, shared_out
from crowquill.mending import Table
from crowquill.paths import Array, Index, Paths

Numbers = npt.NDArray[np.int32]
SUPER = 3  # vertices of its own that the library counts first
FAR = 4  # points that close every cell, the last ones
LEAST = 5  # squares of the reach: a weight so far below the greatest has no place on the canvas left, which is two reaches wide


class Fans(NamedTuple):
    """What a loop over cells walks on: triangles as in a Net; of each of n sites the triangle that it begins with its least
    neighbour, and how many lie around it. See after()."""

    vertices: Table
    neighbours: Table
    centres: Array
    begin: Numbers
    degree: Numbers


@dataclass(frozen=True, eq=False)
class Net:
    """The triangulation behind the cells of sites, and of four far points that close every cell.

    unique      the sites that have a cell, (n,); corner i of a triangle is site unique[i], or a far point from n on
    points      (n + 4, 2) mm
    vertices    (t, 3), turning from x to y
    neighbours  (t, 3): that of number k lies across vertices k and k + 1, -1 beyond all
    centres     (t, 2) mm, of equal power to the corners

    Rows come in any order; what is made of them does not hang on it.
    """

    unique: Index
    points: Array
    vertices: Table
    neighbours: Table
    centres: Array

    @cached_property
    def fans(self) -> Fans:
        """The way round each site that has a cell, for loops over cells."""
        n = len(self.unique)
        begin, least, count = np.zeros(n, np.int32), np.full(n, len(self.points), np.int32), np.zeros(n, np.int32)
        _begun(self.vertices, begin, least, count)
        return Fans(self.vertices, self.neighbours, self.centres, begin, count)

    def rings(self, which: Index | None = None) -> Paths:
        """The cells of sites unique[which], of all when left out, before any clipping: the centres around, turning from x to y."""
        fans = self.fans
        which = np.arange(len(self.unique)) if which is None else which
        start = np.concatenate([[0], np.cumsum(fans.degree[which])])
        xy = np.empty((start[-1], 2))
        shared_out(lambda lo, hi: _fans(fans, which, start, xy, lo, hi), len(which))
        return Paths(xy[: _distinct(xy, start)], start)

    def boxes(self) -> tuple[Array, Array]:
        """The least and the greatest coordinates of each cell before clipping, (n, 2) each."""
        fans, n = self.fans, len(self.unique)
        lower, upper = np.empty((n, 2)), np.empty((n, 2))
        shared_out(lambda lo, hi: _boxes(fans, lower, upper, lo, hi), n)
        return lower, upper

    def areas(self) -> Array:
        """The area of each cell before clipping, (n,)."""
        areas = np.zeros(len(self.unique))
        shared_out(lambda lo, hi: _areas(self.fans, areas, lo, hi), len(areas))
        return areas

    @cached_property
    def edges(self) -> tuple[Index, Array]:
        """Every two sites joined, (e, 2), and the ends of the edge between their cells, (e, 2, 2), not clipped."""
        table = np.empty((3 * len(self.vertices) // 2 + 3, 4), np.int64)
        table = table[: _joined(self.fans, table)]
        return self.unique[table[:, :2]], self.centres[table[:, 2:]]


def triangulated(sites: Array, middle: Array, reach: float, weights: Array | None = None, last: Net | None = None) -> Net:
    """The triangulation of sites (n, 2) that lie, with the canvas, within `reach` of `middle`, mm: Delaunay's, or the regular one.

    Four far points are added. They stand off by more than the canvas is wide, so no place on the canvas is
    nearest to them, yet they close every cell: one site or a row of sites needs no rule of its own.

    weights  (n,) mm^2, which are taken off squared distances; sites that no place on the canvas is left to may have no cell
    last     the triangulation of the same sites, without weights, before a small movement: the same answer sooner
    """
    far = middle + 8 * reach * np.array([[1.0, 0.1], [-0.1, 1.0], [-1.0, -0.1], [0.1, -1.0]])
    heavy = None
    if weights is not None:
        unique, vertices, neighbours, heavy = _weighted(sites, far, reach, weights)
        points = np.concatenate([sites[unique], far])
    else:
        points = np.concatenate([sites, far])
        unique, points, vertices, neighbours = _mended(points, last) or _distinct_delaunay(points)
    return Net(unique, points, vertices, neighbours, circles.centres(points, heavy, vertices, neighbours, reach))


def _mended(points: Array, last: Net | None) -> tuple[Index, Array, Table, Table] | None:
    """The sites, points and triangles of `last` mended for these points, the far ones among them, where there are such that can be."""
    n = len(points) - FAR
    if last is None or len(last.unique) != n or len(last.points) != len(points) or (last.points[n:] != points[n:]).any():
        return None
    vertices, neighbours = last.vertices.copy(), last.neighbours.copy()
    if not mending.moved(last.points, points, vertices, neighbours):
        return None
    return last.unique, points, vertices, neighbours


def _distinct_delaunay(points: Array) -> tuple[Index, Array, Table, Table]:
    """The first of each coincident sites, these and the far points, and vertices and neighbours of their triangles."""
    unique = np.arange(len(points) - FAR)
    try:
        table = _delaunay(points)
    except RuntimeError:  # it refuses coincident points; finding them first would cost every call
        unique = np.sort(np.unique(points[:-FAR] + 0.0, axis=0, return_index=True)[1])
        points = np.concatenate([points[unique], points[-FAR:]])
        table = _delaunay(points)
    vertices, neighbours = _without_its_own(table["vertices"], table["neighbors"])
    mending.legal(points, vertices, neighbours)
    return unique, points, vertices, neighbours


def _delaunay(points: Array) -> Any:
    """The triangle table of a robust triangulation, its own outer triangle left on."""
    net = pythoncdt.Triangulation(pythoncdt.VertexInsertionOrder.AUTO, pythoncdt.IntersectingConstraintEdges.NOT_ALLOWED, 0.0)
    flat: Any = np.ascontiguousarray(points)
    net.insert_vertices(flat)
    return net.triangles_array()


def _without_its_own(vertices: Any, neighbours: Any) -> tuple[Table, Table]:
    """The library's table without triangles at vertices of its own, in the order of their least corners: near triangles are near in it.

    Its outer triangle stands off so far that the four far points' hull is filled.
    """
    least = vertices.min(axis=1)
    order = np.argsort(least, kind="stable")[np.count_nonzero(least < SUPER) :]
    place = np.full(len(vertices) + 1, -1, np.int32)  # the last row is for what lies beyond all
    place[order] = np.arange(len(order), dtype=np.int32)
    beside = np.minimum(neighbours[order], len(vertices))
    return (vertices[order].astype(np.int32) - np.int32(SUPER)), place[beside]


def _weighted(sites: Array, far: Array, reach: float, weights: Array) -> tuple[Index, Table, Table, Array]:
    """The sites that have a cell, of coincident ones the heaviest, their triangles, and their weights and the far points'."""
    weights = np.maximum(weights, weights.max() - LEAST * reach**2)
    order = np.lexsort((-weights, *(sites + 0.0).T))  # stable: of equal weights the first
    new = np.append(True, (np.diff(sites[order], axis=0) != 0).any(axis=1))
    unique = np.sort(order[new])
    heavy = np.append(weights[unique], np.full(len(far), weights.min()))
    vertices, neighbours = regular.triangulated(np.concatenate([sites[unique], far]), heavy)
    seen = np.unique(vertices)
    return unique[seen[: -len(far)]], np.searchsorted(seen, vertices).astype(np.int32), neighbours.astype(np.int32), heavy[seen]


@compiled
def _begun(vertices: Table, begin: Numbers, least: Numbers, count: Numbers) -> None:
    for t in range(len(vertices)):
        for k in range(3):
            v = vertices[t, k]
            if v < len(begin):
                count[v] += 1
                after = vertices[t, (k + 1) % 3]
                if after < least[v]:
                    least[v], begin[v] = after, t


@compiled
def after(net: Fans, t: int, v: int) -> tuple[int, int]:
    """The next triangle around v from t on, turning from x to y, and the corner that both share with v."""
    k = 2 if net.vertices[t, 0] == v else 0 if net.vertices[t, 1] == v else 1
    return int(net.neighbours[t, k]), int(net.vertices[t, k])


@compiled
def _fans(net: Fans, which: Index, start: Index, xy: Array, lo: int, hi: int) -> None:
    """The centres of the triangles around each of these sites, turning from x to y."""
    for i in range(lo, hi):
        now = net.begin[which[i]]
        for at in range(start[i], start[i + 1]):
            xy[at, 0], xy[at, 1] = net.centres[now, 0], net.centres[now, 1]
            now, _ = after(net, now, which[i])


@compiled
def _boxes(net: Fans, lower: Array, upper: Array, lo: int, hi: int) -> None:
    for i in range(lo, hi):
        now = net.begin[i]
        left, top = right, bottom = net.centres[now, 0], net.centres[now, 1]
        for _ in range(net.degree[i] - 1):
            now, _corner = after(net, now, i)
            left, top = min(left, net.centres[now, 0]), min(top, net.centres[now, 1])
            right, bottom = max(right, net.centres[now, 0]), max(bottom, net.centres[now, 1])
        lower[i, 0], lower[i, 1], upper[i, 0], upper[i, 1] = left, top, right, bottom


@compiled
def _areas(net: Fans, areas: Array, lo: int, hi: int) -> None:
    """Areas of sites lo to hi, summed about the first corner."""
    for i in range(lo, hi):
        now = net.begin[i]
        x, y = net.centres[now, 0], net.centres[now, 1]
        u = v = 0.0
        for _ in range(net.degree[i] - 1):
            now, _corner = after(net, now, i)
            s, t = net.centres[now, 0] - x, net.centres[now, 1] - y
            areas[i] += (u * t - s * v) / 2
            u, v = s, t


@compiled
def _distinct(xy: Array, start: Index) -> int:
    """Closes up over corners that repeat the one before them, as where four sites lie on a circle; returns how many are left."""
    kept, begin = 0, start[0]
    for ring in range(len(start) - 1):
        end, first = start[ring + 1], kept
        for k in range(begin, end):
            before = k - 1 if k > begin else end - 1
            if xy[k, 0] != xy[before, 0] or xy[k, 1] != xy[before, 1]:
                xy[kept, 0], xy[kept, 1] = xy[k, 0], xy[k, 1]
                kept += 1
        begin, start[ring], start[ring + 1] = end, first, kept
    return kept


@compiled
def _joined(net: Fans, edges: Index) -> int:
    """Rows (site, site, triangle, triangle) of the edges between two sites, the lower first, by site; returns how many."""
    found = 0
    for i in range(len(net.begin)):
        now = net.begin[i]
        for _ in range(net.degree[i]):
            beyond, other = after(net, now, i)
            if i < other < len(net.begin):
                edges[found, 0], edges[found, 1], edges[found, 2], edges[found, 3] = i, other, now, beyond
                found += 1
            now = beyond
    return found
