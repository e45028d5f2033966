"""Moments: mass, centroid and covariance, in closed form, of rings alone or of the tone inside them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt

from crowquill import levels
from crowquill.cells import Cells
from crowquill.delaunay import Fans, after
from crowquill.kernel import compiled, shared_out
from crowquill.paths import Array, Index, Paths
from crowquill.strips import Band, Part, edge
from crowquill.tone import BLOCK, Tone

NOTHING = 1e-14  # of the sum of absolute parts: a mass below is rounding, and the cell is without ink
FAINT = 1e-6  # of that sum: of less than this, rounding may lead the centroid out of the cell
BAND = 1 << 23  # pixels to a band: sums of 256 MB, and all cells gone over once a band
SHARE = 4096  # sites to a share of work
Corners = npt.NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Moments:
    """A row a site: mass (n,) mm^2, centroid (n, 2) mm, covariance (n, 2, 2) mm^2 (second central moments over mass).

    Where the mass is 0 the centroid is the fallback handed in and the covariance 0, never NaN.
    """

    mass: Array
    centroid: Array
    covariance: Array

    def __post_init__(self) -> None:
        for values in (self.mass, self.centroid, self.covariance):
            values.setflags(write=False)

    @classmethod
    def of(cls, sums: Array, about: Array, fallback: Array) -> Moments:
        """Moments from the integrals of 1, x, y, xx, xy, yy (n, 6) about the points `about` (n, 2)."""
        mass = sums[:, 0]
        some = np.abs(mass) > 0
        over = np.where(some, mass, 1.0)[:, None]
        mean = sums[:, 1:3] / over
        x, y = mean.T
        xx, xy, yy = (sums[:, 3:6] / over).T
        covariance = np.stack([xx - x * x, xy - x * y, xy - x * y, yy - y * y], axis=1).reshape(-1, 2, 2)
        return cls(mass.copy(), np.where(some[:, None], about + mean, fallback), np.where(some[:, None, None], covariance, 0.0))


def of_rings(rings: Paths, fallback: npt.ArrayLike | None = None) -> Moments:
    """Area, centroid and covariance of each ring, exact for straight and cubic sides.

    rings     n rings, mm; area is positive when x turns towards y (clockwise as seen, y being down)
    fallback  (n, 2), the centroid where the area is 0; the first point, or the origin, when left out

    Summed about each ring's first point: about a far origin the digits cancel.
    Source: C. Steger, On the Calculation of Arbitrary Moments of Polygons, TU Munich 1996.

    >>> of_rings(Paths.of([[(0, 0), (2, 0), (2, 1), (0, 1)]])).mass.tolist()
    [2.0]
    """
    about = np.zeros((len(rings), 2))
    filled = np.diff(rings.start) > 0
    about[filled] = rings.xy[rings.start[:-1][filled]]
    return Moments.of(rings.green(), about, about if fallback is None else np.asarray(fallback, np.float64))


def of_tone(cells: Cells, tone: Tone) -> Moments:
    """Mass, centroid and covariance of the tone in each cell, exact for coverage constant on each pixel.

    cells  of n sites in the tone's canvas
    gives  a row a site; mass is mm^2 of ink; a cell without ink has mass 0 and its site as centroid

    Integrals along the cells' edges over sums of whole pixels to the left, so the cost
    follows the cells' perimeter and not their area.
    Source: A. Secord, Weighted Voronoi Stippling, NPAR 2002, for the sums; Green's theorem for the edges.
    """
    dx, dy = tone.pixel
    n, net = len(cells.sites), cells.net
    xy, first = cells.clipped.xy / (dx, dy), np.append(0, np.cumsum(np.bincount(cells.of, minlength=n)))
    corner, sums = np.zeros((n, 2)), np.zeros((n, 7))
    drawn = np.flatnonzero(np.diff(first))
    corner[drawn] = xy[cells.clipped.start[first[drawn]]]
    if net is not None and len(cells.whole):
        corner[net.unique[cells.whole]] = net.centres[net.fans.begin[cells.whole]] / (dx, dy)
    about = np.clip(np.floor(corner, out=corner), 0, np.array(tone.shape)[::-1] - 1).astype(np.int32)
    for band in _bands(tone):
        shared_out(partial(_edges, band, xy, cells.clipped.start, first, about, sums), n)
        if net is not None and len(cells.whole):
            own = np.zeros(len(net.unique), np.bool_)
            own[cells.whole] = True
            if len(band.prefix) < band.rows:
                lower, upper = net.boxes()
                own &= (lower[:, 1] < (band.top + len(band.prefix)) * dy) & (upper[:, 1] >= band.top * dy)
            shared_out(partial(_fans, band, net.fans, 1 / dx, 1 / dy, net.unique, own, about, sums), -(-len(own) // SHARE), 1)
    mass, centroid, covariance = np.empty(n), np.empty((n, 2)), np.empty((n, 2, 2))
    shared_out(lambda lo, hi: _finished(sums, about, cells.sites, dx, dy, mass, centroid, covariance, lo, hi), n)
    # next to no ink in a corner is rounding of the whole pixels beside it: it may not lead out of the cell
    faint = np.flatnonzero((mass > 0) & (sums[:, 0] < FAINT * sums[:, 6]))
    if len(faint):
        centroid[faint] = np.clip(centroid[faint], *_boxes(cells, faint))
    return Moments(mass, centroid, covariance)


def _boxes(cells: Cells, which: Index) -> tuple[Array, Array]:
    """The least and the greatest coordinates of these sites' cells, (k, 2) mm each."""
    drawn = np.flatnonzero(np.isin(cells.of, which))
    parts = [(cells.clipped.take(drawn), cells.of[drawn])]
    if cells.net is not None:
        own = cells.whole[np.isin(cells.net.unique[cells.whole], which)]
        parts.append((cells.net.rings(own), cells.net.unique[own]))
    low, high = np.full((len(which), 2), np.inf), np.full((len(which), 2), -np.inf)
    for rings, of in parts:
        place = np.searchsorted(which, of)[rings.path]
        np.minimum.at(low, place, rings.xy)
        np.maximum.at(high, place, rings.xy)
    return low, high


def _bands(tone: Tone) -> Iterator[Band]:
    """Sums of the whole picture, which it keeps, or of a large one by bands of rows."""
    rows, columns = tone.shape
    if rows * columns < levels.LARGE:
        yield Band(tone.prefix, 0, rows)
        return
    for top, bottom in levels.bands(tone.shape, BAND):
        yield Band(tone.prefix_of(top, bottom), top, rows)


def along(tone: Tone, lines: Array) -> Array:
    """The integral of coverage along each of the straight lines (k, 2, 2) mm, (k,) mm: its mean coverage times its length.

    A line on a border of pixels has one of the two; parts off the picture take the nearest pixel.
    """
    found = np.empty(len(lines))
    _crossed(tone.coverage, lines / tone.pixel, found)
    return np.asarray(found * np.hypot(*(lines[:, 1] - lines[:, 0]).T))


@compiled
def _crossed(coverage: Array, lines: Array, mean: Array) -> None:
    """The mean coverage along lines in pixels, from one crossing of a pixel's border to the next."""
    rows, columns = coverage.shape
    for line in range(len(lines)):
        x, y = lines[line, 0, 0], lines[line, 0, 1]
        dx, dy = lines[line, 1, 0] - x, lines[line, 1, 1] - y
        t = total = 0.0
        while t < 1:
            until = 1.0
            for at, way in ((x, dx), (y, dy)):
                if way != 0:
                    now = at + t * way
                    border = np.floor(now) + 1 if way > 0 else np.ceil(now) - 1
                    until = min(until, (border - at) / way)
            until = max(until, min(1.0, t + 1e-9))  # a border that rounding puts behind is stepped over
            middle = (t + until) / 2
            i = min(max(int(np.floor(x + middle * dx)), 0), columns - 1)
            j = min(max(int(np.floor(y + middle * dy)), 0), rows - 1)
            total += (until - t) * coverage[j, i]
            t = until
        mean[line] = total


@compiled
def _edges(band: Band, xy: Array, start: Index, first: Index, about: Corners, sums: Array, lo: int, hi: int) -> None:
    """Adds the integrals along the rings of sites lo to hi, in pixels about a pixel's corner each.

    Six integrals each, and the sum of the absolute parts of the first.
    """
    for site in range(lo, hi):
        for ring in range(first[site], first[site + 1]):
            before = start[ring + 1] - 1
            for k in range(start[ring], start[ring + 1]):
                part = edge(band, about[site, 0], about[site, 1], xy[before, 0], xy[before, 1], xy[k, 0], xy[k, 1])
                _added(sums[site], part)
                before = k


@compiled
def _fans(
    band: Band, net: Fans, across: float, down: float, unique: Index,
    own: npt.NDArray[np.bool_], about: Corners, sums: Array, lo: int, hi: int,
) -> None:  # fmt: skip
    """Adds the integrals of cells that are their net's own, in shares lo to hi of the sites, of so many pixels a mm across and down.

    An edge between two cells of a share is integrated once for both, if sums to its left begin in one block for both. A share is
    of so many sites whatever the number of threads: hence the same sums.
    """
    for share in range(lo, hi):
        low, high = share * SHARE, min((share + 1) * SHARE, len(unique))
        for i in range(low, high):
            if not own[i]:
                continue
            site, now = unique[i], net.begin[i]
            for _ in range(net.degree[i]):
                beyond, other = after(net, now, i)
                x0, y0 = net.centres[now, 0] * across, net.centres[now, 1] * down
                x1, y1 = net.centres[beyond, 0] * across, net.centres[beyond, 1] * down
                now = beyond
                both = low <= other < high and own[other]
                if both:
                    both = about[unique[other], 0] // BLOCK == about[site, 0] // BLOCK
                if both and other < i:
                    continue  # when it was the other's turn
                part = edge(band, about[site, 0], about[site, 1], x0, y0, x1, y1)
                _added(sums[site], part)
                if both:
                    twin = unique[other]
                    _taken(sums[twin], part, about[site, 0] - about[twin, 0], about[site, 1] - about[twin, 1])


@compiled
def _finished(
    sums: Array, about: Corners, sites: Array, dx: float, dy: float,
    mass: Array, centroid: Array, covariance: Array, lo: int, hi: int,
) -> None:  # fmt: skip
    """Moments in mm of sums in pixels, of sites lo to hi."""
    for i in range(lo, hi):
        m = sums[i, 0]
        if abs(m) < NOTHING * sums[i, 6] or m == 0:
            mass[i], centroid[i, 0], centroid[i, 1] = 0.0, sites[i, 0], sites[i, 1]
            covariance[i] = 0.0
            continue
        x, y = sums[i, 1] / m, sums[i, 2] / m
        mass[i] = m * dx * dy
        covariance[i, 0, 0] = (sums[i, 3] / m - x * x) * dx * dx
        covariance[i, 0, 1] = covariance[i, 1, 0] = (sums[i, 4] / m - x * y) * dx * dy
        covariance[i, 1, 1] = (sums[i, 5] / m - y * y) * dy * dy
        centroid[i, 0], centroid[i, 1] = (about[i, 0] + x) * dx, (about[i, 1] + y) * dy


@compiled
def _added(sums: Array, part: Part) -> None:
    for k in range(7):
        sums[k] += part[k]


@compiled
def _taken(sums: Array, part: Part, x: float, y: float) -> None:
    """Takes integrals away, about a point that lies x and y before the one they are about."""
    m, mx, my, xx, xy, yy, size = part
    sums[0] -= m
    sums[1] -= mx + x * m
    sums[2] -= my + y * m
    sums[3] -= xx + 2 * x * mx + x * x * m
    sums[4] -= xy + x * my + y * mx + x * y * m
    sums[5] -= yy + 2 * y * my + y * y * m
    sums[6] += size
