"""The triangulation behind the cells, Delaunay's or by weights, and its dual: centres of circles, fans of them around the sites."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import pythoncdt

from crowquill import regular
from crowquill.kernel import compiled
from crowquill.paths import Array, Index, Paths

SUPER = 3  # vertices of its own that the triangulation counts first
LEAST = 5  # squares of the reach: a weight so far below the greatest has no place on the canvas left, which is two reaches wide


@dataclass(frozen=True, eq=False)
class Net:
    """The triangulation behind the cells: vertices and neighbours (t, 3), the sites that have a cell, the circles' centres (t, 2)."""

    vertices: Any
    neighbours: Any
    unique: Index
    centres: Array

    def rings(self) -> Paths:
        """The cell of each site that has one before any clipping: the centres around it, turning from x to y."""
        start = np.zeros(len(self.unique) + 1, np.int64)
        around = np.empty(3 * len(self.vertices), np.int64)
        _fans(self.vertices, self.neighbours, len(self.unique), start, around)
        xy = self.centres[around[: start[-1]]]
        return Paths(xy[: _distinct(xy, start)], start)

    @cached_property
    def edges(self) -> tuple[Index, Array]:
        """Every two sites joined, (e, 2), and the ends of the edge between their cells, (e, 2, 2), not clipped."""
        table = np.empty((3 * len(self.vertices) // 2 + 3, 4), np.int64)
        table = table[: _joined(self.vertices, self.neighbours, len(self.unique), table)]
        return self.unique[table[:, :2]], self.centres[table[:, 2:]]


def triangulated(sites: Array, middle: Array, reach: float, weights: Array | None = None) -> Net:
    """The triangulation of sites (n, 2) that lie, with the canvas, within `reach` of `middle`, mm: Delaunay's, or the regular one.

    Four far points are added. They stand off by more than the canvas is wide, so no place on the canvas is
    nearest to them, yet they close every cell: one site or a row of sites needs no rule of its own.

    weights  (n,) mm^2, which are taken off squared distances; sites that no place on the canvas is left to may have no cell
    """
    far = middle + 8 * reach * np.array([[1.0, 0.1], [-0.1, 1.0], [-1.0, -0.1], [0.1, -1.0]])
    if weights is None:
        unique, vertices, neighbours = _distinct_delaunay(sites, far)
        heavy = np.zeros(len(unique) + len(far))
    else:
        unique, vertices, neighbours, heavy = _weighted(sites, far, reach, weights)
    points = np.concatenate([np.zeros((SUPER, 2)), sites[unique], far])
    centres = np.empty((len(vertices), 2))
    _circumcentres(points, np.append(np.zeros(SUPER), heavy), vertices, centres)
    _gathered(points, vertices, neighbours, centres, reach)
    return Net(vertices, neighbours, unique, centres)


def _distinct_delaunay(sites: Array, far: Array) -> tuple[Index, Any, Any]:
    """The first of each coincident sites, and vertices and neighbours of their triangles."""
    unique = np.arange(len(sites))
    try:
        table = _delaunay(np.concatenate([sites, far]))
    except RuntimeError:  # it refuses coincident points; finding them first would cost every call
        unique = np.sort(np.unique(sites + 0.0, axis=0, return_index=True)[1])
        table = _delaunay(np.concatenate([sites[unique], far]))
    return unique, table["vertices"], table["neighbors"]


def _weighted(sites: Array, far: Array, reach: float, weights: Array) -> tuple[Index, Index, Index, Array]:
    """The sites that have a cell, of coincident ones the heaviest, their triangles, and their weights and the far points'."""
    weights = np.maximum(weights, weights.max() - LEAST * reach**2)
    order = np.lexsort((-weights, *(sites + 0.0).T))  # stable: of equal weights the first
    new = np.append(True, (np.diff(sites[order], axis=0) != 0).any(axis=1))
    unique = np.sort(order[new])
    heavy = np.append(weights[unique], np.full(len(far), weights.min()))
    vertices, neighbours = regular.triangulated(np.concatenate([sites[unique], far]), heavy)
    seen = np.unique(vertices)
    return unique[seen[: -len(far)]], np.searchsorted(seen, vertices) + SUPER, neighbours, heavy[seen]


def _delaunay(points: Array) -> Any:
    """The triangle table of a robust triangulation, its own outer triangle left on."""
    net = pythoncdt.Triangulation(pythoncdt.VertexInsertionOrder.AUTO, pythoncdt.IntersectingConstraintEdges.NOT_ALLOWED, 0.0)
    flat: Any = np.ascontiguousarray(points)
    net.insert_vertices(flat)
    return net.triangles_array()


@compiled
def _circumcentres(points: Array, weights: Array, vertices: Any, centres: Array) -> None:
    """The centre of each triangle's circle, of equal power to its corners; triangles with a dummy get 0.

    Reckoned from an end of the shortest side: two close corners differ exactly in floats, and
    a third far off would swamp that difference.
    """
    for t in range(len(vertices)):
        centres[t, 0] = centres[t, 1] = 0.0
        if min(vertices[t, 0], vertices[t, 1], vertices[t, 2]) < SUPER:
            continue
        near, least = 0, np.inf
        for k in range(3):
            p, q = vertices[t, k], vertices[t, (k + 1) % 3]
            side = (points[q, 0] - points[p, 0]) ** 2 + (points[q, 1] - points[p, 1]) ** 2
            if side < least:
                near, least = k, side
        a, b, c = vertices[t, near], vertices[t, (near + 1) % 3], vertices[t, (near + 2) % 3]
        x, y = points[a, 0], points[a, 1]
        bx, by, cx, cy = points[b, 0] - x, points[b, 1] - y, points[c, 0] - x, points[c, 1] - y
        twice = 2 * (bx * cy - by * cx)
        if twice == 0:  # too thin for floats: the middle of its longest reach stands in
            centres[t, 0], centres[t, 1] = x + cx / 2, y + cy / 2
            continue
        bb, cc = bx * bx + by * by + (weights[a] - weights[b]), cx * cx + cy * cy + (weights[a] - weights[c])
        centres[t, 0], centres[t, 1] = x + (cy * bb - by * cc) / twice, y + (bx * cc - cx * bb) / twice


@compiled
def _gathered(points: Array, vertices: Any, neighbours: Any, centres: Array, reach: float) -> None:
    """Makes one of centres that differ by rounding alone, as those of triangles whose corners lie on one circle.

    Triangles are joined to neighbours of the same centre, and all of a group take the centre of one: so that the
    many triangles of a regular polygon agree to the last bit.
    """
    group: Any = np.arange(len(vertices))
    for t in range(len(vertices)):
        if min(vertices[t, 0], vertices[t, 1], vertices[t, 2]) < SUPER:
            continue
        for k in range(3):
            u = np.int64(neighbours[t, k])
            if not 0 <= u < t or min(vertices[u, 0], vertices[u, 1], vertices[u, 2]) < SUPER:
                continue
            corner, x, y = vertices[t, 0], centres[t, 0], centres[t, 1]
            radius = abs(x - points[corner, 0]) + abs(y - points[corner, 1])
            # a centre is good to some last digits of its radius, and of its coordinates about a far origin; thin triangles cost two more
            least = min(1e-6 * radius, 1e-13 * radius + 2e-14 * (abs(x) + abs(y) + reach))
            if abs(centres[u, 0] - x) + abs(centres[u, 1] - y) < least:
                mine, other = t, u
                while group[mine] != mine:
                    mine = group[mine]
                while group[other] != other:
                    other = group[other]
                group[max(mine, other)] = min(mine, other)
    for t in range(len(vertices)):
        root = t
        while group[root] != root:
            root = group[root]
        group[t] = root
        centres[t, 0], centres[t, 1] = centres[root, 0], centres[root, 1]


@compiled
def _fans(vertices: Any, neighbours: Any, n: int, start: Index, ring: Index) -> None:
    """For each of n sites the triangles around it, turning from x to y: ring[start[i]:start[i + 1]].

    Neighbour k of a triangle lies across its side k, k + 1.
    """
    begin = np.full(n, -1, np.int64)
    for t in range(len(vertices)):
        for k in range(3):
            v = np.int64(vertices[t, k]) - SUPER  # unsigned in the table
            if 0 <= v < n:
                begin[v] = t
                start[v + 1] += 1
    for site in range(n):
        start[site + 1] += start[site]
        now = begin[site]
        for at in range(start[site], start[site + 1]):
            ring[at] = now
            for k in range(3):
                if np.int64(vertices[now, k]) - SUPER == site:
                    now = np.int64(neighbours[now, (k + 2) % 3])
                    break


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
def _joined(vertices: Any, neighbours: Any, n: int, edges: Index) -> int:
    """Rows (site, site, triangle, triangle) of the edges between two of n sites; returns how many."""
    count = 0
    for t in range(len(vertices)):
        for k in range(3):
            u, v = np.int64(vertices[t, k]) - SUPER, np.int64(vertices[t, (k + 1) % 3]) - SUPER
            if 0 <= u < v < n:
                edges[count, 0], edges[count, 1] = u, v
                edges[count, 2], edges[count, 3] = t, np.int64(neighbours[t, k])
                count += 1
    return count
