"""Moments: mass, centroid and covariance, in closed form, of rings alone or of the tone inside them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from crowquill.cells import Cells
from crowquill.delaunay import Fans, after
from crowquill.kernel import compiled, shared_out
from crowquill.paths import Array, Index, Paths, frozen
from crowquill.tone import BLOCK, Tone

NOTHING = 1e-14  # of the sum of absolute parts: a mass below is rounding, and the cell is without ink
SHARE = 4096  # sites to a share of work
Part = tuple[float, float, float, float, float, float, float]


@dataclass(frozen=True, eq=False)
class Moments:
    """A row a site: mass (n,) mm^2, centroid (n, 2) mm, covariance (n, 2, 2) mm^2 (second central moments over mass).

    Where the mass is 0 the centroid is the fallback handed in and the covariance 0, never NaN.
    """

    mass: Array
    centroid: Array
    covariance: Array

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
        return cls(
            frozen(mass, np.float64, (None,), "mass"),
            frozen(np.where(some[:, None], about + mean, fallback), np.float64, (None, 2), "centroid"),
            frozen(np.where(some[:, None, None], covariance, 0.0), np.float64, (None, 2, 2), "covariance"),
        )


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
    about, box, sums = np.zeros((n, 2)), np.tile([np.inf, np.inf, -np.inf, -np.inf], (n, 1)), np.zeros((n, 7))
    drawn = np.flatnonzero(np.diff(first))
    about[drawn] = xy[cells.clipped.start[first[drawn]]]
    if net is not None and len(cells.whole):
        about[net.unique[cells.whole]] = net.centres[net.fans.begin[cells.whole]] / (dx, dy)
    about = np.clip(np.floor(about), 0, np.array(tone.coverage.shape)[::-1] - 1.0)
    shared_out(lambda lo, hi: _edges(tone.prefix, xy, cells.clipped.start, first, about, sums, box, lo, hi), n)
    if net is not None and len(cells.whole):
        own = np.zeros(len(net.unique), np.bool_)
        own[cells.whole] = True
        fans = net.fans._replace(centres=net.centres / (dx, dy))
        shared_out(lambda lo, hi: _fans(tone.prefix, fans, net.unique, own, about, sums, box, lo, hi), -(-len(own) // SHARE), 1)
    sums[np.abs(sums[:, 0]) < NOTHING * sums[:, 6]] = 0
    sums = sums[:, :6] * dx * dy * np.array([1, dx, dy, dx * dx, dx * dy, dy * dy])
    found = Moments.of(sums, about * (dx, dy), cells.sites)
    # next to no ink in a corner is rounding of the whole pixels beside it: it may not lead out of the cell
    held = np.clip(found.centroid, box[:, :2] * (dx, dy), box[:, 2:] * (dx, dy))
    return replace(found, centroid=np.where(found.mass[:, None] > 0, held, found.centroid))


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
def _edges(prefix: Array, xy: Array, start: Index, first: Index, about: Array, sums: Array, box: Array, lo: int, hi: int) -> None:
    """Adds the integrals along the rings of sites lo to hi, in pixels about a pixel's corner each, and widens the cells' boxes.

    Six integrals each, and the sum of the absolute parts of the first.
    """
    for site in range(lo, hi):
        for ring in range(first[site], first[site + 1]):
            before = start[ring + 1] - 1
            for k in range(start[ring], start[ring + 1]):
                _widened(box[site], xy[k, 0], xy[k, 1])
                part = _edge(prefix, about[site, 0], about[site, 1], xy[before, 0], xy[before, 1], xy[k, 0], xy[k, 1])
                _added(sums[site], part)
                before = k


@compiled
def _fans(
    prefix: Array, net: Fans, unique: Index, own: npt.NDArray[np.bool_], about: Array, sums: Array, box: Array, lo: int, hi: int
) -> None:
    """Adds the integrals of cells that are their net's own, in shares lo to hi of the sites.

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
                x0, y0, x1, y1 = net.centres[now, 0], net.centres[now, 1], net.centres[beyond, 0], net.centres[beyond, 1]
                _widened(box[site], x0, y0)
                now = beyond
                both = low <= other < high and own[other]
                if both:
                    both = about[unique[other], 0] // BLOCK == about[site, 0] // BLOCK
                if both and other < i:
                    continue  # when it was the other's turn
                part = _edge(prefix, about[site, 0], about[site, 1], x0, y0, x1, y1)
                _added(sums[site], part)
                if both:
                    twin = unique[other]
                    _taken(sums[twin], part, about[site, 0] - about[twin, 0], about[site, 1] - about[twin, 1])


@compiled
def _widened(box: Array, x: float, y: float) -> None:
    box[0], box[1], box[2], box[3] = min(box[0], x), min(box[1], y), max(box[2], x), max(box[3], y)


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


@compiled
def _edge(prefix: Array, left: float, top: float, x0: float, y0: float, x1: float, y1: float) -> Part:
    """The integrals of 1, x, y, xx, xy, yy times the coverage left of an edge, about (left, top), and the absolute parts of the first.

    Pixel by pixel along it. Where "left" begins is one and the same for a row, and cancels round a ring.
    """
    m = mx = my = xx = xy = yy = size = 0.0
    dx, dy = x1 - x0, y1 - y0
    if dy == 0:  # along a row there is nothing to integrate
        return m, mx, my, xx, xy, yy, size
    rows, columns = prefix.shape[0], prefix.shape[1]
    i = min(max(int(np.floor(x0)), 0), columns - 1)
    j = min(max(int(np.floor(y0)), 0), rows - 1)
    i_end = min(max(int(np.floor(x1)), 0), columns - 1)
    j_end = min(max(int(np.floor(y1)), 0), rows - 1)
    right, down = 1 if dx > 0 else -1, 1 if dy > 0 else -1
    # where along the edge, 0 to 1, it crosses into the next column and the next row
    across, along = 1 / dx if i != i_end else 0.0, 1 / dy
    x_at = ((i + (right > 0)) - x0) * across if i != i_end else 2.0
    y_at = ((j + (down > 0)) - y0) * along if j != j_end else 2.0
    t = 0.0
    while True:
        until = min(x_at, y_at, 1.0)
        if until > t:
            a0, a1, a2 = _before(prefix, int(left), i, j)
            rho, edge = prefix[j, i, 3], i - left
            a0, a1, a2 = a0 - rho * edge, a1 - rho * edge * edge / 2, a2 - rho * edge * edge * edge / 3
            half, way = (t + until) / 2, (until - t) / 2
            # the middle of the piece and half of its way: means along it of powers of x and y
            x, y, u, v, h = x0 + half * dx - left, y0 + half * dy - top, way * dx, way * dy, 2 * way * dy
            uu, uv, vv = u * u / 3, u * v / 3, v * v / 3
            r0 = a0 + rho * x
            r1 = a1 + rho * (x * x + uu) / 2
            m += h * r0
            size += abs(h * r0)
            mx += h * r1
            my += h * (r0 * y + rho * uv)
            xx += h * (a2 + rho * x * (x * x + 3 * uu) / 3)
            xy += h * (r1 * y + rho * x * uv)
            yy += h * (r0 * (y * y + vv) + 2 * rho * y * uv)
            t = until
        if i == i_end and j == j_end:
            if t >= 1.0:
                break
            x_at = y_at = 2.0
        elif x_at <= y_at:
            i += right
            x_at = ((i + (right > 0)) - x0) * across if i != i_end else 2.0
        else:
            j += down
            y_at = ((j + (down > 0)) - y0) * along if j != j_end else 2.0
    return m, mx, my, xx, xy, yy, size


@compiled
def _before(prefix: Array, left: int, i: int, j: int) -> tuple[float, float, float]:
    """The sums of coverage times 1, x, x^2 over the pixels of row j from the block of `left` to column i, x counted from `left`."""
    block = i // BLOCK
    a0, a1, a2 = _about(prefix[j, i, 0], prefix[j, i, 1], prefix[j, i, 2], float(block * BLOCK - left))
    low, high, sign = (left // BLOCK, block, 1.0) if block >= left // BLOCK else (block, left // BLOCK, -1.0)
    for b in range(low, high):
        end = (b + 1) * BLOCK - 1  # the block's last pixel makes its sums whole
        rho = prefix[j, end, 3]
        e0, e1 = float(BLOCK - 1), float(BLOCK)
        s0 = prefix[j, end, 0] + rho
        s1 = prefix[j, end, 1] + rho * (e1 * e1 - e0 * e0) / 2
        s2 = prefix[j, end, 2] + rho * (e1 * e1 * e1 - e0 * e0 * e0) / 3
        s0, s1, s2 = _about(s0, s1, s2, float(b * BLOCK - left))
        a0, a1, a2 = a0 + sign * s0, a1 + sign * s1, a2 + sign * s2
    return a0, a1, a2


@compiled
def _about(s0: float, s1: float, s2: float, shift: float) -> tuple[float, float, float]:
    """Sums of 1, x, x^2 with every x larger by `shift`."""
    return s0, s1 + shift * s0, s2 + 2 * shift * s1 + shift * shift * s0
