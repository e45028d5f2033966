"""Moments: mass, centroid and covariance, in closed form, of rings alone or of the tone inside them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from crowquill.cells import Cells
from crowquill.kernel import compiled, shared_out
from crowquill.paths import Array, Index, Paths, frozen
from crowquill.tone import BLOCK, Tone

NOTHING = 1e-14  # of the sum of absolute parts: a mass below is rounding, and the cell is without ink
GAUSS = 0.5 / np.sqrt(3.0)  # two points at 1/2 -+ this are exact to degree 3, all that is met here


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
    n = len(cells.sites)
    sums, about, box = np.zeros((n, 7)), np.zeros((n, 2)), np.zeros((n, 4))
    xy = cells.rings.xy / (dx, dy)
    shared_out(lambda lo, hi: _edges(tone.prefix, xy, cells.rings.start, cells.first, sums, about, box, lo, hi), n)
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
def _edges(prefix: Array, xy: Array, start: Index, first: Index, sums: Array, about: Array, box: Array, lo: int, hi: int) -> None:
    """Sums of sites lo to hi, in pixels about the corner of the first pixel of their cells, put in `about`, and the cells' boxes.

    Six integrals each, and the sum of the absolute parts of the first.
    """
    for site in range(lo, hi):
        begin, end = start[first[site]], start[first[site + 1]]
        if begin == end:
            continue
        left, top, right, bottom = xy[begin, 0], xy[begin, 1], xy[begin, 0], xy[begin, 1]
        for k in range(begin, end):
            left, top = min(left, xy[k, 0]), min(top, xy[k, 1])
            right, bottom = max(right, xy[k, 0]), max(bottom, xy[k, 1])
        box[site, 0], box[site, 1], box[site, 2], box[site, 3] = left, top, right, bottom
        left = min(max(np.floor(left), 0.0), prefix.shape[1] - 1.0)
        top = min(max(np.floor(top), 0.0), prefix.shape[0] - 1.0)
        about[site, 0], about[site, 1] = left, top
        for ring in range(first[site], first[site + 1]):
            last = start[ring + 1] - 1
            for k in range(start[ring], last + 1):
                after = start[ring] if k == last else k + 1
                _edge(prefix, int(left), int(top), xy[k, 0], xy[k, 1], xy[after, 0], xy[after, 1], sums[site])


@compiled
def _edge(prefix: Array, left: int, top: int, x0: float, y0: float, x1: float, y1: float, out: Array) -> None:
    """Adds one edge's part of the sums, pixel by pixel along it."""
    dx, dy = x1 - x0, y1 - y0
    if dy == 0:
        return  # along a row there is nothing to integrate
    rows, columns = prefix.shape[0], prefix.shape[1]
    i = min(max(int(np.floor(x0)), 0), columns - 1)
    j = min(max(int(np.floor(y0)), 0), rows - 1)
    i_end = min(max(int(np.floor(x1)), 0), columns - 1)
    j_end = min(max(int(np.floor(y1)), 0), rows - 1)
    right, down = 1 if dx > 0 else -1, 1 if dy > 0 else -1
    # where along the edge, 0 to 1, it crosses into the next column and the next row
    x_at = ((i + (right > 0)) - x0) / dx if i != i_end else 2.0
    y_at = ((j + (down > 0)) - y0) / dy if j != j_end else 2.0
    t = 0.0
    while True:
        until = min(x_at, y_at, 1.0)
        if until > t:
            _piece(prefix, left, top, i, j, x0 + t * dx, y0 + t * dy, x0 + until * dx, y0 + until * dy, out)
            t = until
        if i == i_end and j == j_end:
            if t >= 1.0:
                break
            x_at = y_at = 2.0
        elif x_at <= y_at:
            i += right
            x_at = ((i + (right > 0)) - x0) / dx if i != i_end else 2.0
        else:
            j += down
            y_at = ((j + (down > 0)) - y0) / dy if j != j_end else 2.0


@compiled
def _piece(prefix: Array, left: int, top: int, i: int, j: int, x0: float, y0: float, x1: float, y1: float, out: Array) -> None:
    """Adds the part of an edge that lies in pixel (j, i): the coverage to its left times dy.

    a0, a1, a2 are the sums of coverage times 1, x, x^2 over the pixels from the block of
    `left` to i, x counted from `left`; where that block starts is one and the same for a row, and cancels round a ring.
    """
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
    rho, edge = prefix[j, i, 3], float(i - left)
    dy = (y1 - y0) / 2
    for sign in (-1.0, 1.0):
        t = 0.5 + sign * GAUSS
        x, y = x0 + t * (x1 - x0) - left, y0 + t * (y1 - y0) - top
        r0 = a0 + rho * (x - edge)
        r1 = a1 + rho * (x * x - edge * edge) / 2
        r2 = a2 + rho * (x * x * x - edge * edge * edge) / 3
        out[0] += dy * r0
        out[6] += abs(dy * r0)
        out[1] += dy * r1
        out[2] += dy * r0 * y
        out[3] += dy * r2
        out[4] += dy * r1 * y
        out[5] += dy * r0 * y * y


@compiled
def _about(s0: float, s1: float, s2: float, shift: float) -> tuple[float, float, float]:
    """Sums of 1, x, x^2 with every x larger by `shift`."""
    return s0, s1 + shift * s0, s2 + 2 * shift * s1 + shift * shift * s0
