"""First sites, and how they move: scatter() and lloyd(); settle() for objects that turn as well."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Any, Self

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import cells, hilbert, moments, refining
from crowquill.cells import Cells
from crowquill.halftone import METHODS, halftoned
from crowquill.halftone.averages import averaged
from crowquill.moments import Moments
from crowquill.paths import Array, Index, frozen
from crowquill.settling import settle
from crowquill.tone import Tone

__all__ = ["STARTS", "State", "lloyd", "scatter", "settle"]

STARTS = ("levels", "even", "random", *(method for method in METHODS if method != "random"))
STEP = 1.8  # of the way to the centroid
LEAST = 64  # sites of the coarsest level, from which on there is a coarser one
LEVELS = (20, 4)  # steps on the coarsest level, and on each of the next
PIXELS_ENOUGH = 16  # to a site, on all levels but the finest
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
        x, y = (sums.centroid - sites).T
        way, area = x * x + y * y, parts.areas
        energy = float((sums.mass * (sums.covariance[:, 0, 0] + sums.covariance[:, 1, 1] + way)).sum())
        gone = np.sqrt(way / np.where(area > 0, area, np.inf))
        return cls(done, sites, parts, sums, energy, float(gone.mean()) if len(gone) else 0.0, **more)


Lead = Callable[[State], Array]


def scatter(tone: Tone, n: int, rng: np.random.Generator, how: str = "even") -> Array:
    """First sites (n, 2) mm in the tone's canvas, in proportion to coverage.

    levels    some sites at rest that become four times as many, again and again (see refining): what 30 steps make of
              `even`, 15 make of these, and making them costs about 4
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
    if how == "levels":
        return _by_levels(tone, n, rng)
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


def _by_levels(tone: Tone, n: int, rng: np.random.Generator) -> Array:
    """n sites of a start by levels, or fewer where the tone has not so many places with ink."""
    wanted = [n]
    while wanted[0] >= 4 * LEAST:
        wanted.insert(0, wanted[0] // 4)
    level = _coarser(tone, wanted[0]) if wanted[1:] else tone
    sites = scatter(level, wanted[0], rng)
    for done, count in enumerate(wanted[1:] or [0]):
        states = _states(sites, level, level.mapped(np.square), STEP, level.levels.where(lambda c: c == 0))
        state = next(islice(states, LEVELS[min(done, 1)], None))
        if not count:
            return state.sites
        level = _coarser(tone, count) if count < n else tone.holding(tone.levels)
        sites = refining.refined(state.cells, level, count, rng)
    return sites


def _coarser(tone: Tone, n: int) -> Tone:
    """The tone on fewer pixels, where it has many more than n sites need."""
    h, w = tone.shape
    over = int(np.sqrt(h * w / (PIXELS_ENOUGH * n)))
    if over < 2:
        return tone.holding(tone.levels)  # whose sums go with it
    rows, columns = -(-h // over), -(-w // over)
    fewer = averaged(tone.levels, np.linspace(0, w, columns + 1), np.linspace(0, h, rows + 1))
    return Tone(np.clip(fewer, 0, 1), tone.size, tone.canvas)


def lloyd(
    sites: npt.ArrayLike,
    tone: Tone,
    *,
    step: float = STEP,
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
    weight = tone.mapped(lambda coverage: coverage**exponent)
    return _states(frozen(sites, np.float64, (None, 2), "sites"), tone, weight, step, refused, lead)


def _states(
    sites: Array, tone: Tone, weight: Tone, step: float, banned: npt.NDArray[np.bool_] | None, lead: Lead | None = None
) -> Iterator[State]:
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


def moved(state: State, tone: Tone, *, step: float = STEP, banned: npt.NDArray[np.bool_] | None = None, lead: Lead | None = None) -> Array:
    """Where the sites of a state are a step later."""
    centroid, sites = state.moments.centroid, state.sites
    return held(tone, banned, sites + step * (centroid - sites) if lead is None else lead(state), centroid, sites)


def held(tone: Tone, banned: npt.NDArray[np.bool_] | None, *places: Array) -> Array:
    """For each site the first of these places (n, 2) that may have one: in the canvas, on no banned pixel; or else the last."""
    target = np.array(places[0])
    lost = np.flatnonzero(~_may_hold(target, tone, banned))
    for other in places[1:]:
        target[lost] = other[lost]
        lost = lost[~_may_hold(target[lost], tone, banned)]
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
