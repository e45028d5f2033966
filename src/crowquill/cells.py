"""Cells: the exact partition of a canvas among sites, by distance or by power, in the sites' order, clipped with shapely."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.delaunay import Net, triangulated
from crowquill.kernel import compiled, shared_out
from crowquill.paths import Array, Index, Paths, frozen
from crowquill.tone import touched

NEAR = 1e-9  # of the canvas: pieces this close touch; clipping rounds at 1e-16
TINY = np.finfo(float).tiny
MANY = 500  # corners of an outline, and cells it may cut, from which on it is cut to pieces first


@dataclass(frozen=True, eq=False)
class Cells:
    """The parts of a canvas nearest to each of n sites, by distance or by power.

    sites    (n, 2) mm
    clipped  rings that the canvas cut, or, without a net, all there are; mm
    of       the site that each of them is of; these rise
    canvas   the (Multi)Polygon that the cells fill: areas sum to its area
    net      the triangulation that the cells were made from, and `cut` (n,) which of them the outline may cut: the other cells
             are those of the net. Without both there are no borders and no pairs

    Of coincident sites the first has the cell. Neighbours share unclipped edges bit for bit.
    """

    sites: Array
    clipped: Paths
    of: Index
    canvas: shapely.Geometry
    net: Net | None = field(repr=False, default=None)
    cut: npt.NDArray[np.bool_] | None = field(repr=False, default=None)

    @cached_property
    def whole(self) -> Index:
        """The cells that are the net's own, as places in net.unique; none without a net."""
        if self.net is None or self.cut is None:
            return np.zeros(0, np.int64)
        return np.flatnonzero(~self.cut[self.net.unique])

    @cached_property
    def first(self) -> Index:
        """Where each site's rings start, (n + 1,): site i has rings first[i] to first[i + 1]."""
        counts = np.bincount(self.of, minlength=len(self.sites))
        if self.net is not None:
            counts[self.net.unique[self.whole]] += 1
        return np.concatenate([[0], np.cumsum(counts)])

    @cached_property
    def owner(self) -> Index:
        """The site that each ring is of, (r,), rising: a cell has one ring, more where the canvas has holes or islands, or none."""
        return np.repeat(np.arange(len(self.sites)), np.diff(self.first))

    @cached_property
    def rings(self) -> Paths:
        """The rings of all cells, mm; ring k belongs to site owner[k]. Holes turn the other way."""
        if self.net is None:
            return self.clipped
        own = self.net.rings(self.whole)
        every = Paths(np.concatenate([own.xy, self.clipped.xy]), np.concatenate([own.start, self.clipped.start[1:] + len(own.xy)]))
        return every.take(np.argsort(np.concatenate([self.net.unique[self.whole], self.of]), kind="stable"))

    @cached_property
    def areas(self) -> Array:
        """The area of each site's cell, (n,) mm^2."""
        found = np.bincount(self.of, self.clipped.areas, len(self.sites)).astype(np.float64)
        if self.net is not None:
            found[self.net.unique[self.whole]] += self.net.areas()[self.whole]
        return found

    @cached_property
    def borders(self) -> tuple[Index, Array]:
        """Sites i < j and the straight lines on the canvas between their cells, before parts are handed over: (e, 2), (e, 2, 2) mm."""
        if self.net is None or self.cut is None:
            return np.zeros((0, 2), np.int64), np.zeros((0, 2, 2))
        sites, edges = self.net.edges
        length = np.hypot(*(edges[:, 0] - edges[:, 1]).T)
        real = length > 1e-12 * _reach(self.sites, self.canvas)[1]  # cocircular sites meet in a point, not an edge
        sites, edges = np.sort(sites[real], axis=1), edges[real]
        cut = self.cut[sites].all(axis=1)
        lines, line = shapely.get_parts(shapely.intersection(shapely.linestrings(edges[cut]), self.canvas), return_index=True)
        xy, part = shapely.get_coordinates(lines, return_index=True)
        same = part[1:] == part[:-1]
        pieces = np.stack([xy[:-1][same], xy[1:][same]], axis=1)
        return np.concatenate([sites[~cut], sites[cut][line[part[1:][same]]]]), np.concatenate([edges[~cut], pieces])

    @cached_property
    def pairs(self) -> Index:
        """Sites i < j between whose cells an edge runs on the canvas, before parts are handed over: (e, 2), sorted."""
        return np.unique(self.borders[0], axis=0)


def voronoi(sites: npt.ArrayLike, canvas: shapely.Geometry, last: Cells | None = None) -> Cells:
    """The Voronoi cells of sites (n, 2) mm in a canvas, a shapely (Multi)Polygon with any holes.

    On a canvas that is not convex a cell keeps the part nearest its site (the one it lies
    in); a part cut off from it goes to the cell it touches whose site is nearest, so that
    the areas still sum to the canvas. One site, a row of sites and coincident sites all have an
    answer; no sites give no cells. Raises ValueError for sites that are not finite.

    last  the cells of the same sites before they moved a little: the same answer sooner

    Source: F. Aurenhammer, Voronoi Diagrams, ACM Computing Surveys 23(3), 1991.
    """
    return _partition(sites, None, canvas, True, last)


def power(sites: npt.ArrayLike, weights: npt.ArrayLike, canvas: shapely.Geometry, *, joined: bool = True) -> Cells:
    """The power cells of sites (n, 2) mm with weights (n,) mm^2: of each place its squared distances, less the weights, are compared.

    With equal weights they are the Voronoi cells. A site need not lie in its cell, and has none where heavier ones leave it
    no place; of coincident sites the heaviest has the cell, or the first. Else all is as in voronoi().

    joined  parts of a cell that the canvas cuts off are handed over, to the site of least power of those they touch; without it
            each place is the one's with the least power, be its cell in many parts

    Raises ValueError for sites or weights that are not finite, and for more or fewer weights than sites.
    Source: F. Aurenhammer, Power Diagrams, SIAM Journal on Computing 16(1), 1987.
    """
    sites = np.asarray(sites, np.float64)
    return _partition(sites, frozen(weights, np.float64, (len(sites),), "weights"), canvas, joined)


def _partition(sites: npt.ArrayLike, weights: Array | None, canvas: shapely.Geometry, joined: bool, last: Cells | None = None) -> Cells:
    sites = frozen(sites, np.float64, (None, 2), "sites")
    if not len(sites):
        return Cells(sites, Paths.of([]), np.zeros(0, np.int64), canvas)
    net = triangulated(sites, *_reach(sites, canvas), weights, last.net if last else None)
    return _clipped(sites, np.zeros(len(sites)) if weights is None else weights, net, canvas, joined)


def _reach(sites: Array, canvas: shapely.Geometry) -> tuple[Array, float]:
    """The middle of canvas and sites together, and the half diagonal of their common box."""
    bounds = np.array(shapely.bounds(canvas)).reshape(2, 2)
    low = np.minimum(bounds[0], sites.min(axis=0))
    high = np.maximum(bounds[1], sites.max(axis=0))
    return (low + high) / 2, float(np.hypot(*(high - low))) / 2


def _clipped(sites: Array, weights: Array, net: Net, canvas: shapely.Geometry, joined: bool) -> Cells:
    """The cells on the canvas: only those that its outline may cut are handed to shapely."""
    unique = net.unique
    may = _may_be_cut(net, canvas)
    cut = np.flatnonzero(may)
    polygons = net.rings(cut).polygons()
    shapely.prepare(canvas)
    sound = shapely.is_valid(polygons)
    free = sound & shapely.contains_properly(canvas, polygons)
    may[cut[free]] = False
    polygons[~sound] = shapely.convex_hull(polygons[~sound])  # a cell is convex: only rounding can have crossed it
    cut, polygons = cut[~free], polygons[~free]
    pieces, cell = shapely.get_parts(_inside(polygons, canvas), return_index=True)
    areal = shapely.area(pieces) > 0
    pieces, cell = pieces[areal], cut[cell[areal]]
    if joined and len(np.unique(cell)) < len(cell):
        cell = _handed_over(pieces, cell, sites[unique], weights[unique], cut, net)
    clipped, piece = Paths.of_polygons(pieces)
    order = np.argsort(cell[piece], kind="stable")
    outer = np.zeros(len(sites), bool)
    outer[unique] = may
    return Cells(sites, clipped.take(order), unique[cell[piece[order]]], canvas, net, outer)


def _inside(polygons: npt.NDArray[np.object_], canvas: shapely.Geometry) -> npt.NDArray[np.object_]:
    """The part of each polygon that lies in the canvas.

    An outline of many corners is first cut to the room of some polygons at a time: it would be walked whole for each of them.
    """
    if _is_upright_box(canvas):
        return np.asarray(shapely.clip_by_rect(polygons, *shapely.bounds(canvas)))  # eight times as fast
    if min(shapely.get_num_coordinates(canvas), len(polygons)) < MANY:
        return np.asarray(shapely.intersection(polygons, canvas))
    low, high = np.split(shapely.bounds(polygons), 2, axis=1)
    place = (low + high) / 2
    side = int(np.ceil(np.sqrt(len(polygons)) / 4))
    tile = np.minimum(side - 1, side * (place - place.min(axis=0)) // np.maximum(np.ptp(place, axis=0), TINY)).astype(np.int64)
    _, tile = np.unique(tile @ (side, 1), return_inverse=True)
    least, most = np.full((tile.max() + 1, 2), np.inf), np.full((tile.max() + 1, 2), -np.inf)
    np.minimum.at(least, tile, low)
    np.maximum.at(most, tile, high)
    margin = 0.01 * (most - least)  # no side of the room runs along a polygon
    rooms = shapely.box(*(least - margin).T, *(most + margin).T)
    return np.asarray(shapely.intersection(polygons, shapely.intersection(rooms, canvas)[tile]))


def _is_upright_box(canvas: shapely.Geometry) -> bool:
    return bool(shapely.equals_exact(shapely.normalize(canvas), shapely.normalize(shapely.box(*shapely.bounds(canvas)))))


def _may_be_cut(net: Net, canvas: shapely.Geometry) -> npt.NDArray[np.bool_]:
    """Whether a cell may not lie in the canvas whole.

    Its box reaches over a canvas that is a box itself. Else its box touches a square of a grid, half a spacing wide, that the
    canvas's outline touches, or its first corner lies outside, and all of the cell with it.
    """
    n = len(net.unique)
    low, high = np.array(shapely.bounds(canvas)).reshape(2, 2)
    lower, upper = net.boxes()
    if _is_upright_box(canvas):
        return np.asarray((lower[:, 0] < low[0]) | (lower[:, 1] < low[1]) | (upper[:, 0] > high[0]) | (upper[:, 1] > high[1]))
    spacing = np.sqrt(np.prod(high - low) / n)
    grid = np.maximum(1, np.ceil(2 * (high - low) / spacing)).astype(np.int64)
    grid = np.minimum(grid, 4 * int(np.sqrt(n)) + 16)  # a thin canvas has few squares across, not many along
    step = (high - low) / grid
    marks = touched(canvas, tuple(low), tuple(step), (grid[1], grid[0]))
    sums = np.pad(np.cumsum(np.cumsum(marks, axis=0, dtype=np.int64), axis=1), ((1, 0), (1, 0)))
    cut = np.empty(n, np.bool_)
    shared_out(lambda lo, hi: _on_marks(sums, low, high, step, lower, upper, cut, lo, hi), n)
    if shapely.area(canvas) < np.prod(high - low):
        cut |= ~shapely.contains_xy(canvas, net.centres[net.fans.begin])
    return cut


@compiled
def _on_marks(
    sums: Index, low: Array, high: Array, step: Array, lower: Array, upper: Array, cut: npt.NDArray[np.bool_], lo: int, hi: int
) -> None:
    """Whether boxes touch a marked square, of which sums over all before are given, or reach over the grid from low to high."""
    rows, columns = sums.shape[0] - 1, sums.shape[1] - 1
    for i in range(lo, hi):
        left, top, right, bottom = lower[i, 0], lower[i, 1], upper[i, 0], upper[i, 1]
        if left < low[0] or top < low[1] or right > high[0] or bottom > high[1]:
            cut[i] = True
            continue
        x = min(max(int((left - low[0]) // step[0]), 0), columns - 1)
        y = min(max(int((top - low[1]) // step[1]), 0), rows - 1)
        x_end = min(max(int((right - low[0]) // step[0]), 0), columns - 1) + 1
        y_end = min(max(int((bottom - low[1]) // step[1]), 0), rows - 1) + 1
        cut[i] = sums[y_end, x_end] - sums[y, x_end] - sums[y_end, x] + sums[y, x] > 0


def _handed_over(pieces: npt.NDArray[np.object_], cell: Index, sites: Array, weights: Array, cut: Index, net: Net) -> Index:
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
    shapes = np.concatenate([pieces, net.rings(around).polygons()])
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
            close = shapely.dwithin(shapes[others], shapes[k], tolerance)
            near = {int(owner[m]) for m, beside_it in zip(others, close, strict=True) if beside_it}
            if near:
                found[k] = min((shapely.distance(points[i], shapes[k]) ** 2 - weights[i], i) for i in near)[1]
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
