"""Cells: the exact partition of a canvas among sites, in the sites' order, clipped with shapely."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
import pythoncdt
import shapely

from crowquill.kernel import compiled
from crowquill.paths import Array, Index, Paths, frozen
from crowquill.tone import touched

SUPER = 3  # vertices of its own that the triangulation counts first
NEAR = 1e-9  # of the canvas: pieces this close touch; clipping rounds at 1e-16


@dataclass(frozen=True, eq=False)
class Net:
    """The triangulation behind the cells: vertices and neighbours (t, 3), the sites that differ, the circles' centres (t, 2)."""

    vertices: Any
    neighbours: Any
    unique: Index
    centres: Array

    @cached_property
    def edges(self) -> tuple[Index, Array]:
        """Every two sites joined, (e, 2), and the ends of the edge between their cells, (e, 2, 2), not clipped."""
        table = np.empty((3 * len(self.vertices) // 2 + 3, 4), np.int64)
        table = table[: _joined(self.vertices, self.neighbours, len(self.unique), table)]
        return self.unique[table[:, :2]], self.centres[table[:, 2:]]


@dataclass(frozen=True, eq=False)
class Cells:
    """The parts of a canvas nearest to each of n sites.

    rings   mm; ring k belongs to site owner[k], owners rise. A cell has one ring, more where
            the canvas has holes (they turn the other way) or islands, none where it has no part of the canvas
    canvas  the (Multi)Polygon that the cells fill: areas sum to its area

    Of coincident sites the first has the cell. Neighbours share unclipped edges bit for bit.
    """

    sites: Array
    rings: Paths
    owner: Index
    canvas: shapely.Geometry
    net: Net | None = field(repr=False, default=None)

    @cached_property
    def first(self) -> Index:
        """Where each site's rings start, (n + 1,): site i has rings first[i] to first[i + 1]."""
        return np.searchsorted(self.owner, np.arange(len(self.sites) + 1)).astype(np.int64)

    @cached_property
    def pairs(self) -> Index:
        """Sites i < j between whose cells an edge runs on the canvas, before parts are handed over: (e, 2), sorted."""
        if self.net is None:
            return np.zeros((0, 2), np.int64)
        sites, edges = self.net.edges
        length = np.hypot(*(edges[:, 0] - edges[:, 1]).T)
        real = length > 1e-12 * _reach(self.sites, self.canvas)[1]  # cocircular sites meet in a point, not an edge
        sites, edges = sites[real], edges[real]
        meet = shapely.intersects(self.canvas, shapely.linestrings(edges))
        found = np.sort(sites[meet], axis=1)
        return found[np.lexsort((found[:, 1], found[:, 0]))]


def voronoi(sites: npt.ArrayLike, canvas: shapely.Geometry) -> Cells:
    """The Voronoi cells of sites (n, 2) mm in a canvas, a shapely (Multi)Polygon with any holes.

    On a canvas that is not convex a cell keeps the part nearest its site (the one it lies
    in); a part cut off from it goes to the cell it touches whose site is nearest, so that
    the areas still sum to the canvas. One site, a row of sites and coincident sites all have an
    answer; no sites give no cells. Raises ValueError for sites that are not finite.

    Source: F. Aurenhammer, Voronoi Diagrams, ACM Computing Surveys 23(3), 1991.
    """
    sites = frozen(sites, np.float64, (None, 2), "sites")
    if not len(sites):
        none = np.zeros(0, np.int64)
        return Cells(sites, Paths.of([]), none, canvas, None)
    points, vertices, neighbours, unique = _triangles(sites, canvas)
    centres = np.empty((len(vertices), 2))
    _circumcentres(points, vertices, centres)
    _gathered(points, vertices, neighbours, centres, _reach(sites, canvas)[1])
    start = np.zeros(len(unique) + 1, np.int64)
    ring = np.empty(3 * len(vertices), np.int64)
    _fans(vertices, neighbours, len(unique), start, ring)
    xy = centres[ring[: start[-1]]]
    xy = xy[: _distinct(xy, start)]
    return _clipped(sites, Net(vertices, neighbours, unique, centres), Paths(xy, start), canvas)


def _reach(sites: Array, canvas: shapely.Geometry) -> tuple[Array, float]:
    """The middle of canvas and sites together, and the half diagonal of their common box."""
    bounds = np.array(shapely.bounds(canvas)).reshape(2, 2)
    low = np.minimum(bounds[0], sites.min(axis=0))
    high = np.maximum(bounds[1], sites.max(axis=0))
    return (low + high) / 2, float(np.hypot(*(high - low))) / 2


def _triangles(sites: Array, canvas: shapely.Geometry) -> tuple[Array, Any, Any, Index]:
    """Points, triangles' vertices and neighbours of the Delaunay triangulation, and the sites that differ.

    Points are SUPER dummies, the distinct sites, then four far ones. These stand off by more
    than the canvas is wide, so no place on the canvas is nearest to them, yet they close every cell:
    one site or a row of sites needs no rule of its own.
    """
    middle, reach = _reach(sites, canvas)
    far = middle + 8 * reach * np.array([[1.0, 0.1], [-0.1, 1.0], [-1.0, -0.1], [0.1, -1.0]])
    unique = np.arange(len(sites))
    try:
        table = _delaunay(np.concatenate([sites, far]))
    except RuntimeError:  # it refuses coincident points; finding them first would cost every call
        unique = np.sort(np.unique(sites + 0.0, axis=0, return_index=True)[1])
        table = _delaunay(np.concatenate([sites[unique], far]))
    points = np.concatenate([np.zeros((SUPER, 2)), sites[unique], far])
    return points, table["vertices"], table["neighbors"], unique


def _delaunay(points: Array) -> Any:
    """The triangle table of a robust triangulation, its own outer triangle left on."""
    net = pythoncdt.Triangulation(pythoncdt.VertexInsertionOrder.AUTO, pythoncdt.IntersectingConstraintEdges.NOT_ALLOWED, 0.0)
    flat: Any = np.ascontiguousarray(points)
    net.insert_vertices(flat)
    return net.triangles_array()


@compiled
def _circumcentres(points: Array, vertices: Any, centres: Array) -> None:
    """The centre of each triangle's circle; triangles with a dummy get 0.

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
        bb, cc = bx * bx + by * by, cx * cx + cy * cy
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
            if u >= t or min(vertices[u, 0], vertices[u, 1], vertices[u, 2]) < SUPER:
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


def _clipped(sites: Array, net: Net, rings: Paths, canvas: shapely.Geometry) -> Cells:
    """The cells on the canvas: only those that its outline may cut are handed to shapely."""
    unique = net.unique
    cut = np.flatnonzero(_may_be_cut(rings, canvas, sites[unique]))
    polygons = rings.take(cut).polygons()
    sound = shapely.is_valid(polygons)
    polygons[~sound] = shapely.convex_hull(polygons[~sound])  # a cell is convex: only rounding can have crossed it
    pieces, cell = shapely.get_parts(shapely.intersection(polygons, canvas), return_index=True)
    areal = shapely.area(pieces) > 0
    pieces, cell = pieces[areal], cut[cell[areal]]
    if len(np.unique(cell)) < len(cell):
        cell = _handed_over(pieces, cell, sites[unique], rings, cut, net)
    clipped, piece = Paths.of_polygons(pieces)
    whole = np.setdiff1d(np.arange(len(unique)), cut, assume_unique=True)
    owner = np.concatenate([whole, cell[piece]])
    every = Paths(np.concatenate([rings.xy, clipped.xy]), np.concatenate([rings.start, clipped.start[1:] + len(rings.xy)]))
    order = np.argsort(owner, kind="stable")
    source = np.concatenate([whole, np.arange(len(rings), len(every))])[order]
    return Cells(sites, every.take(source), unique[owner[order]], canvas, net)


def _may_be_cut(rings: Paths, canvas: shapely.Geometry, sites: Array) -> npt.NDArray[np.bool_]:
    """Whether a cell may not lie in the canvas whole.

    Either its box touches a square of a grid, half a spacing wide, that the canvas's outline touches, or its site
    lies outside, and all of the cell with it.
    """
    n = len(sites)
    low, high = np.array(shapely.bounds(canvas)).reshape(2, 2)
    spacing = np.sqrt(np.prod(high - low) / n)
    grid = np.maximum(1, np.ceil(2 * (high - low) / spacing)).astype(np.int64)
    grid = np.minimum(grid, 4 * int(np.sqrt(n)) + 16)  # a thin canvas has few squares across, not many along
    step = (high - low) / grid
    marks = touched(canvas, tuple(low), tuple(step), (grid[1], grid[0]))
    sums = np.pad(np.cumsum(np.cumsum(marks, axis=0, dtype=np.int64), axis=1), ((1, 0), (1, 0)))
    lower, upper = np.empty((n, 2)), np.empty((n, 2))
    _boxes(rings.xy, rings.start, lower, upper)
    left, top = np.clip(np.floor((lower - low) / step), 0, grid - 1).astype(np.int64).T
    right, bottom = np.clip(np.floor((upper - low) / step), 0, grid - 1).astype(np.int64).T + 1
    inside = sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
    cut = np.asarray(inside > 0) | (lower < low).any(axis=1) | (upper > high).any(axis=1)
    if shapely.area(canvas) < np.prod(high - low):
        shapely.prepare(canvas)
        cut |= ~shapely.contains_xy(canvas, sites)
    return cut


@compiled
def _boxes(xy: Array, start: Index, lower: Array, upper: Array) -> None:
    """The box of each ring; every ring has a corner here."""
    for ring in range(len(start) - 1):
        for axis in range(2):
            low = high = xy[start[ring], axis]
            for k in range(start[ring] + 1, start[ring + 1]):
                low, high = min(low, xy[k, axis]), max(high, xy[k, axis])
            lower[ring, axis], upper[ring, axis] = low, high


def _handed_over(pieces: npt.NDArray[np.object_], cell: Index, sites: Array, rings: Paths, cut: Index, net: Net) -> Index:
    """The owner of each piece: of each cell the one nearest its site stays, the rest go to the nearest site of those they touch.

    A piece may touch one that has itself been handed over: rounds are made until nothing changes, all of a round at
    once, so that the order of sites does not matter. What touches nothing stays with its own site.
    """
    kept = np.zeros(len(pieces), bool)
    points = shapely.points(sites)
    nearest = np.lexsort((-shapely.area(pieces), shapely.distance(pieces, points[cell]), cell))
    kept[nearest[np.flatnonzero(np.diff(cell[nearest], prepend=-1))]] = True
    waiting = np.flatnonzero(~kept)
    beside = _neighbours(np.searchsorted(net.unique, net.edges[0]), len(sites))
    around = np.setdiff1d(np.concatenate([beside[i] for i in cell[waiting]]), cut)  # whole cells may be touched too
    shapes = np.concatenate([pieces, rings.take(around).polygons()])
    of, own = np.concatenate([cell, around]), np.concatenate([kept, np.ones(len(around), bool)])
    owner = np.where(own, of, -1)
    low, high = shapely.bounds(shapes).reshape(-1, 2, 2).transpose(1, 0, 2)
    tolerance = NEAR * float((np.nanmax(high, axis=0) - np.nanmin(low, axis=0)).max())
    members: dict[int, list[int]] = {}
    for k, i in enumerate(of.tolist()):
        members.setdefault(i, []).append(k)
    while len(waiting):
        found = {}
        for k in waiting.tolist():
            others = [m for i in (*beside[of[k]], of[k]) for m in members.get(int(i), []) if owner[m] >= 0]
            others = [m for m in others if not (own[m] and of[m] == of[k])]  # what it was cut off from
            touched = [m for m, near in zip(others, shapely.dwithin(shapes[others], shapes[k], tolerance), strict=True) if near]
            if touched:
                found[k] = min((shapely.distance(points[owner[m]], shapes[k]), int(owner[m])) for m in touched)[1]
        if not found:
            break
        owner[list(found)] = list(found.values())
        waiting = np.setdiff1d(waiting, list(found))
    owner[waiting] = of[waiting]
    return owner[: len(pieces)]


def _neighbours(pairs: Index, n: int) -> list[Index]:
    """For each of n sites the others it is paired with."""
    both = np.concatenate([pairs, pairs[:, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    return np.split(both[:, 1], np.searchsorted(both[:, 0], np.arange(1, n)))
