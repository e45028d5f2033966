"""A step of some of a drawing's dots by what lies around them alone, and how far they had to look for it to be that of the whole."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import relax
from crowquill.kernel import compiled
from crowquill.paths import Array, Index
from crowquill.tone import Tone

GRAIN = 0.5  # spacings: ink is looked for in squares of this side


@dataclass(frozen=True, eq=False)
class Window:
    """What a worker needs to move a tile's sites by a step. Nothing else is read.

    demand  (h, w) of the whole's demand, its first pixel at `corner` (left, top), in pixels of `pixel` mm
    canvas  well-known bytes of the canvas in the window, mm of the whole; None for all of it
    sites   (m, 2) mm of the whole: all that lie in `known`, the tile's own `own` first
    known   left, top, right, bottom in mm: beyond, sites are not known; infinite where the page ends
    avoid   no site may move onto pixels without demand
    """

    demand: Array
    corner: tuple[int, int]
    pixel: tuple[float, float]
    canvas: bytes | None
    sites: Array
    own: int
    known: tuple[float, float, float, float]
    step: float
    exponent: float
    avoid: bool


@dataclass(frozen=True, eq=False)
class Moved:
    """What comes of a window: where its own sites go (n, 2) mm, how far they looked, and the sums of relax.State over them.

    looked  (4,) mm beyond their box to the left, top, right and bottom
    """

    places: Array
    looked: Array
    energy: float
    movement: float


def moved(window: Window) -> Moved:
    """One step of a window's own sites: that of the whole, where they looked no farther than is known.

    Movement is over cells that may end with the window, where they reach far into white; places do not depend on that.
    """
    corner, demand, own = np.array(window.corner) * window.pixel, np.asarray(window.demand), window.own
    size = demand.shape[1] * window.pixel[0], demand.shape[0] * window.pixel[1]
    canvas = None if window.canvas is None else shapely.transform(shapely.from_wkb(window.canvas), lambda xy: xy - corner)
    tone, weight = Tone(demand, size, canvas), Tone(demand**window.exponent, size)
    state = relax.measured(window.sites - corner, tone, weight)
    places = relax.moved(state, tone, step=window.step, banned=demand == 0 if window.avoid else None)
    reach = 2 * _farthest_ink(state, weight, own, np.array(window.known) - np.tile(corner, 2))
    sites, sums = state.sites[:own], state.moments
    low, high = sites.min(axis=0), sites.max(axis=0)
    looked = np.concatenate([(reach[:, None] - (sites - low)).max(axis=0), (reach[:, None] - (high - sites)).max(axis=0)])
    way, area = sums.centroid[:own] - sites, state.cells.areas[:own]
    spread = sums.covariance[:own, 0, 0] + sums.covariance[:own, 1, 1] + (way**2).sum(axis=1)
    gone = np.hypot(*way.T) / np.sqrt(np.where(area > 0, area, np.inf))
    return Moved(places[:own] + corner, np.maximum(looked, 0.0), float((sums.mass[:own] * spread).sum()), float(gone.sum()))


def _farthest_ink(state: relax.State, weight: Tone, own: int, known: Array) -> Array:
    """How far ink of each own site's cell may be from it, (own,) mm; only where its cell's corners are too far is ink looked for."""
    cells, (dx, dy) = state.cells, weight.pixel
    grain = GRAIN * math.sqrt(weight.size[0] * weight.size[1] / len(state.sites))
    rows, columns = max(1, int(grain / dy)), max(1, int(grain / dx))
    h, w = weight.coverage.shape
    pixels = np.zeros((-(-h // rows) * rows, -(-w // columns) * columns), bool)
    pixels[:h, :w] = weight.coverage > 0
    inked = np.asarray(pixels.reshape(len(pixels) // rows, rows, -1, columns).any(axis=(1, 3)))
    found = np.zeros(own)
    _farthest(cells.rings.xy, cells.rings.start, cells.first, state.sites, known, inked, columns * dx, rows * dy, found)
    return found


@compiled
def _farthest(
    xy: Array,
    start: Index,
    first: Index,
    sites: Array,
    known: Array,
    inked: npt.NDArray[np.bool_],
    width: float,
    height: float,
    found: Array,
) -> None:
    """The farthest corner of each cell, or, where twice that is beyond what is known, the farthest square with ink that it may reach."""
    half = np.hypot(width, height) / 2
    for site in range(len(found)):
        begin, end, x, y = start[first[site]], start[first[site + 1]], sites[site, 0], sites[site, 1]
        left, top, right, bottom, far = x, y, x, y, 0.0
        for k in range(begin, end):
            left, top, right, bottom = min(left, xy[k, 0]), min(top, xy[k, 1]), max(right, xy[k, 0]), max(bottom, xy[k, 1])
            far = max(far, np.hypot(xy[k, 0] - x, xy[k, 1] - y))
        if x - 2 * far < known[0] or y - 2 * far < known[1] or x + 2 * far > known[2] or y + 2 * far > known[3]:
            far = 0.0
            for j in range(max(0, int(top / height) - 1), min(inked.shape[0], int(bottom / height) + 2)):
                for i in range(max(0, int(left / width) - 1), min(inked.shape[1], int(right / width) + 2)):
                    u, v = (i + 0.5) * width, (j + 0.5) * height
                    away = np.hypot(u - x, v - y) + half
                    if inked[j, i] and away > far and _reaches(xy, start, first[site], first[site + 1], u, v, half):
                        far = away
        found[site] = far


@compiled
def _reaches(xy: Array, start: Index, lo: int, hi: int, u: float, v: float, near: float) -> bool:
    """Whether the place (u, v) is in the rings lo to hi, or so near to one."""
    inside = False
    for ring in range(lo, hi):
        for k in range(start[ring], start[ring + 1]):
            after = start[ring] if k + 1 == start[ring + 1] else k + 1
            ax, ay, bx, by = xy[k, 0] - u, xy[k, 1] - v, xy[after, 0] - u, xy[after, 1] - v
            dx, dy = bx - ax, by - ay
            length = dx * dx + dy * dy
            t = min(1.0, max(0.0, -(ax * dx + ay * dy) / length)) if length > 0 else 0.0
            if np.hypot(ax + t * dx, ay + t * dy) <= near:
                return True
            if (ay > 0) != (by > 0) and ax - ay * dx / dy > 0:
                inside = not inside
    return inside
