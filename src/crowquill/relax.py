"""First sites, and how they move: scatter() and lloyd(); settle() for objects that turn as well."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import cells, hilbert, moments
from crowquill.cells import Cells
from crowquill.halftone import METHODS, halftoned
from crowquill.halftone.averages import averaged
from crowquill.moments import Moments
from crowquill.paths import Array, Index, frozen
from crowquill.settling import settle
from crowquill.tone import Tone

__all__ = ["STARTS", "State", "lloyd", "scatter", "settle"]

STARTS = ("even", "random", *(method for method in METHODS if method != "random"))
PIXELS_A_SITE = 4  # pixels are split until there are so many: inside one pixel sites fall at random
SQUARES = 40_000_000  # of a halftone's grid
GOLDEN = np.pi * (3 - np.sqrt(5))  # rad; multiples of it never line up


@dataclass(frozen=True, eq=False)
class State:
    """Sites after `done` steps, their cells and moments, and how good they are.

    energy    sum over cells of the integral of weight times squared distance to the site, mm^4
    movement  mean distance from site to centroid, in square roots of the cell's area
    """

    done: int
    sites: Array
    cells: Cells
    moments: Moments
    energy: float
    movement: float

    @classmethod
    def of(cls, done: int, sites: Array, parts: Cells, sums: Moments, **more: Any) -> Self:
        """The state of sites with these cells and moments of the weight."""
        way = sums.centroid - sites
        spread = sums.covariance[:, 0, 0] + sums.covariance[:, 1, 1] + (way**2).sum(axis=1)
        area = parts.areas
        gone = np.hypot(*way.T) / np.sqrt(np.where(area > 0, area, np.inf))
        return cls(done, sites, parts, sums, float((sums.mass * spread).sum()), float(gone.mean()) if len(gone) else 0.0, **more)


Lead = Callable[[State], Array]


def scatter(tone: Tone, n: int, rng: np.random.Generator, how: str = "even") -> Array:
    """First sites (n, 2) mm in the tone's canvas, in proportion to coverage.

    even      equal ink: pixels are strung along a Hilbert curve, the string is cut into n
              lengths of equal ink, and each gets one site at random
    random    each site by itself
    a method  of halftoning, by its name: one site for every black pixel of a halftone whose grid makes
              them about n, in rows: within 4 % from a thousand on where the method keeps tone, and never none.
              The grid has forty million squares at most, which on a nearly white picture makes them fewer

    No ink, or n of 0, gives (0, 2). Raises ValueError for an unknown start or negative n.
    """
    if how not in STARTS:
        raise ValueError(f"no start {how!r}; there are {', '.join(STARTS)}")
    if n < 0:
        raise ValueError(f"n is {n}; it takes 0 or more")
    if n == 0 or not tone.ink > 0:
        return np.zeros((0, 2))
    if how in METHODS and how != "random":
        return _halftoned(tone, n, how, rng)
    split = int(np.ceil(np.sqrt(max(1.0, PIXELS_A_SITE * n / np.prod(tone.shape)))))
    if split > 1 and not (how == "even" and tone.is_rectangle):
        finer: Array = np.kron(tone.coverage, np.ones((split, split))).astype(np.float64)
        tone, split = Tone(finer, tone.size, tone.canvas), 1
    ink = tone.inked
    if how == "even":
        place = hilbert.passed(ink, (np.arange(n) + rng.random(n)) / n, split)
    else:
        total = np.cumsum(ink.whole().ravel())
        found = np.searchsorted(total, np.minimum(rng.random(n) * total[-1], np.nextafter(total[-1], 0)), side="right")
        place = np.stack(np.divmod(found, ink.shape[1])[::-1], axis=1)
    size = tone.size[0] / (ink.shape[1] * split), tone.size[1] / (ink.shape[0] * split)
    return _placed(tone, place, np.array(size), rng)


def lloyd(
    sites: npt.ArrayLike,
    tone: Tone,
    *,
    step: float = 1.8,
    exponent: float = 2.0,
    banned: npt.ArrayLike | None = None,
    lead: Lead | None = None,
) -> Iterator[State]:
    """States of Lloyd's relaxation without end, the sites as they were given first.

    sites     (n, 2) mm in the canvas; keep their order and number
    step      a site moves by step times the way to its cell's centroid: 1 is Lloyd's own, up to 2 still falls
    exponent  cells weigh coverage ** exponent. Equal dots at rest lie as the square root of the
              weight: 2 keeps tone, 1 (the published method) slowly flattens it, 0 is uniform
    banned    (h, w) pixels of the tone that no site may move onto
    lead      where the sites of a state go next, (n, 2), in place of that way to their centroids

    A site that would leave the canvas or land on a banned pixel goes to the centroid instead, or
    else stays. A cell without ink keeps its site. Coincident sites are parted.
    Raises ValueError for a step outside 0 to 2 or an exponent outside 0 to 4.

    Source: S. Lloyd, Least Squares Quantization in PCM, 1982; A. Secord, NPAR 2002; Q. Du, V. Faber,
    M. Gunzburger, Centroidal Voronoi Tessellations, 1999, for the rule of the square root.
    """
    if not 0 < step < 2:
        raise ValueError(f"step {step} is outside 0 to 2")
    if not 0 <= exponent <= 4:
        raise ValueError(f"exponent {exponent} is outside 0 to 4")
    refused = None if banned is None else np.asarray(banned, bool)
    if refused is not None and refused.shape != tone.shape:
        raise ValueError(f"banned has shape {refused.shape}; it takes the tone's {tone.shape}")
    return _states(frozen(sites, np.float64, (None, 2), "sites"), tone, step, exponent, refused, lead)


def _states(
    sites: Array, tone: Tone, step: float, exponent: float, banned: npt.NDArray[np.bool_] | None, lead: Lead | None
) -> Iterator[State]:
    weight = tone.mapped(lambda coverage: coverage**exponent)
    state = measured(sites, tone, weight, banned=banned)
    while True:
        yield state
        sites = moved(state, tone, step=step, banned=banned, lead=lead)
        state = measured(sites, tone, weight, done=state.done + 1, banned=banned, last=state.cells)


def measured(
    sites: Array,
    tone: Tone,
    weight: Tone,
    *,
    canvas: shapely.Geometry | None = None,
    done: int = 0,
    banned: npt.NDArray[np.bool_] | None = None,
    last: Cells | None = None,
) -> State:
    """The state of sites as they are, their cells weighed by `weight`, those without a cell parted from their twins.

    canvas  in place of the tone's
    last    the cells of the same sites before they moved: the same answer sooner
    """
    canvas = tone.canvas if canvas is None else canvas
    parts = cells.voronoi(sites, canvas, last)
    if (np.diff(parts.first) == 0).any():
        sites = parted(sites, parts, tone, banned)
        parts = cells.voronoi(sites, canvas)
    return State.of(done, sites, parts, moments.of_tone(parts, weight))


def moved(state: State, tone: Tone, *, step: float = 1.8, banned: npt.NDArray[np.bool_] | None = None, lead: Lead | None = None) -> Array:
    """Where the sites of a state are a step later."""
    centroid, sites = state.moments.centroid, state.sites
    return held(tone, banned, sites + step * (centroid - sites) if lead is None else lead(state), centroid, sites)


def held(tone: Tone, banned: npt.NDArray[np.bool_] | None, *places: Array) -> Array:
    """For each site the first of these places (n, 2) that may have one: in the canvas, on no banned pixel; or else the last."""
    target = places[0]
    for other in places[1:]:
        target = np.where(_may_hold(target, tone, banned)[:, None], target, other)
    return target


def _may_hold(sites: Array, tone: Tone, banned: npt.NDArray[np.bool_] | None) -> npt.NDArray[np.bool_]:
    """Whether each place may have a site."""
    good = tone.holds(sites)
    return good if banned is None else good & ~banned[tone.under(sites)]


def parted(sites: Array, parts: Cells, tone: Tone, banned: npt.NDArray[np.bool_] | None) -> Array:
    """Sites without a cell moved off their twins by a thousandth of the spacing, each its own way round."""
    spacing = np.sqrt(shapely.area(tone.canvas) / len(sites))
    lost = np.flatnonzero(np.diff(parts.first) == 0)
    turn = GOLDEN * lost
    moved = sites.copy()
    moved[lost] += 1e-3 * spacing * np.sqrt(1 + np.arange(len(lost)))[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return held(tone, banned, moved, sites)


def _placed(tone: Tone, pixel: Index, size: Array, rng: np.random.Generator) -> Array:
    """One site at random in each pixel (column, row) of this size, inside the canvas."""
    sites = (pixel + rng.random(pixel.shape)) * size
    out = np.flatnonzero(~tone.holds(sites))
    for _ in range(32):
        if not len(out):
            return sites
        sites[out] = (pixel[out] + rng.random((len(out), 2))) * size
        out = out[~tone.holds(sites[out])]
    low = pixel[out] * size
    scraps = shapely.intersection(shapely.box(*low.T, *(low + size).T), tone.canvas)
    sites[out] = shapely.get_coordinates(shapely.point_on_surface(scraps))
    return sites


def _halftoned(tone: Tone, n: int, method: str, rng: np.random.Generator) -> Array:
    """Sites on the grid that comes nearest to n: each next one is as much finer as the last was short of it."""
    area = tone.size[0] * tone.size[1]
    best, cells_wanted = np.zeros((0, 2)), min(float(n), SQUARES * tone.ink / area)
    for chance in rng.spawn(8):
        sites = _black_pixels(tone, np.sqrt(tone.ink / cells_wanted), method, chance)
        if len(sites) and (not len(best) or abs(len(sites) - n) < abs(len(best) - n)):
            best = sites
        if abs(len(best) - n) <= 0.002 * n:
            break
        cells_wanted *= min(2.0, n / max(1, len(sites)))
        if area / tone.ink * cells_wanted > SQUARES:
            break
    if len(best):
        return best
    darkest = np.unravel_index(np.argmax(tone.coverage * tone.inside), tone.coverage.shape)
    return _placed(tone, np.array([darkest[::-1]]), np.array(tone.pixel), rng)


def _black_pixels(tone: Tone, pitch: float, method: str, rng: np.random.Generator) -> Array:
    """The middles of the black pixels of the tone's halftone on a grid of this pitch in mm, those in the canvas."""
    columns = max(1, round(tone.size[0] / pitch))
    rows = max(1, round(tone.size[0] * tone.size[1] / pitch**2 / columns))  # so that both together come near
    h, w = tone.coverage.shape
    grid = averaged(tone.coverage * tone.inside, np.linspace(0, w, columns + 1), np.linspace(0, h, rows + 1))
    row, column = np.nonzero(halftoned(np.clip(grid, 0, 1), method, rng=rng))
    sites = (np.stack([column, row], axis=1) + 0.5) * np.array(tone.size) / (columns, rows)
    kept: Array = sites[tone.holds(sites)]
    return kept
