"""How evenly sites lie, and how evenly they share the ink: distances, gaps, hexagons, capacity, and all figures in one."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import moments, quadrature, spectrum
from crowquill.cells import Cells, voronoi
from crowquill.marks import Marks
from crowquill.paths import Array, Index, frozen
from crowquill.tone import Tone

HEXAGONAL = 2 / np.sqrt(3)  # the square of the distance of a hexagonal lattice's points, in areas of its cells
ALIKE = 1e-9  # of its area: what a cell that has not been cut may differ by, from sums in another order
FLAT = 1e-4  # mm that an outline strays from its curve when gaps are measured
PIXELS = 256  # of the longer side of a canvas that is no rectangle
CLOSE = 0.5  # spacings: sites of an even set are further apart
AT_ONCE = 2000  # pairs of outlines measured before looking whether the rest can be nearer


@dataclass(frozen=True)
class Spacing:
    """All figures of a set of sites, as plain numbers; None where there is none, and `notes` say why.

    The curves that some are read from stand behind them: radial power, and distance in spacings and pair correlation.

    n                 sites
    nearest           mean distance to the nearest other site, mm
    nearest_least     the least of them, mm
    nearest_cv        their spread over their mean
    gap               the least distance between outlines of marks, mm; 0 where any meet
    evenness          rho: see evenness()
    alpha             least distance in hexagonal distances: see alpha()
    hexagons          share of cells with six sides, of those that the outline does not cut
    capacity_cv       spread of the ink of a cell over its mean
    capacity_error    its square
    frequency         of the ring of most power, cycles a spacing
    power             there; 1 is random's, 1.5 to 3 lightly relaxed, above 4 crystals
    low_power         mean power below half a cycle a spacing
    anisotropy        dB, of the ring of most power; -10 log10(patches) and what overlap adds is none
    patches           squares that the power is the mean of
    patched           share of the sites in them
    pairs_close       pair correlation below half a spacing: 0 for sites apart, 1 for random ones, more for clumps
    pair_distance     where it is greatest further off, in spacings
    pair_peak         and how great; 1 is random's
    quadrature        errors on smooth functions, half planes, polynomials, over their own root mean square
    random            the errors that as many random sites would have
    regular           the errors of about as many on a square grid, each with the ink of its place
    """

    n: int
    nearest: float | None
    nearest_least: float | None
    nearest_cv: float | None
    gap: float | None
    evenness: float | None
    alpha: float | None
    hexagons: float | None
    capacity_cv: float | None
    capacity_error: float | None
    frequency: float | None
    power: float | None
    low_power: float | None
    anisotropy: float | None
    patches: int
    patched: float
    pairs_close: float | None
    pair_distance: float | None
    pair_peak: float | None
    quadrature: tuple[float, float, float] | None
    random: tuple[float, float, float] | None
    regular: tuple[float, float, float] | None
    notes: tuple[str, ...]
    radial: spectrum.Radial | None = field(repr=False, default=None)
    pair_curve: tuple[Array, Array] | None = field(repr=False, default=None)

    def figures(self) -> dict[str, Any]:
        """The plain numbers by their names, without curves and notes."""
        return {part.name: getattr(self, part.name) for part in fields(self) if part.repr and part.name != "notes"}


def of(
    sites: npt.ArrayLike, where: Tone | shapely.Geometry, *, marks: Marks | None = None, weights: npt.ArrayLike | None = None
) -> Spacing:
    """Every figure of sites (n, 2) mm on a tone, whose coverage their density is to follow, or evenly on a canvas.

    marks    what stands at the sites, when gaps between outlines are wanted
    weights  (n,) each site's share as a sample, such as its dot's area; the same for all when left out

    What too few, coincident or collinear sites leave open is None. Raises ValueError for sites that are not finite,
    and for a canvas without area.
    """
    sites = frozen(sites, np.float64, (None, 2), "sites")
    tone, corner = (where, np.zeros(2)) if isinstance(where, Tone) else _even(where)
    sites = sites - corner
    cells, near = voronoi(sites, tone.canvas), nearest(sites)
    some = near[np.isfinite(near)]
    six, capacity, errors = hexagons(cells), capacity_error(cells, tone), quadrature.of(sites, tone, weights=weights)
    power, (distance, pairs) = spectrum.of_patches(sites, tone), spectrum.pair_correlation(sites, tone)
    top = None if power is None else int(np.argmax(power.power))
    far = distance > CLOSE
    return Spacing(
        n=len(sites),
        nearest=float(some.mean()) if len(some) else None,
        nearest_least=float(some.min()) if len(some) else None,
        nearest_cv=float(some.std() / some.mean()) if len(some) and some.mean() > 0 else None,
        gap=None if marks is None else gap(marks),
        evenness=evenness(cells, near),
        alpha=alpha(sites, tone, near),
        hexagons=six,
        capacity_cv=None if capacity is None else float(np.sqrt(capacity)),
        capacity_error=capacity,
        frequency=None if power is None or top is None else float(power.frequency[top]),
        power=None if power is None or top is None else float(power.power[top]),
        low_power=None if power is None else float(power.power[power.frequency < 0.5].mean()),
        anisotropy=None if power is None or top is None else float(power.anisotropy[top]),
        patches=0 if power is None else power.patches,
        patched=0.0 if power is None else power.share,
        pairs_close=float(np.average(pairs[~far], weights=distance[~far])) if len(pairs) else None,
        pair_distance=float(distance[far][np.argmax(pairs[far])]) if len(pairs) else None,
        pair_peak=float(pairs[far].max()) if len(pairs) else None,
        quadrature=None if errors is None else (errors.smooth, errors.edge, errors.polynomial),
        random=None if errors is None else errors.random,
        regular=_regular(len(sites), tone),
        notes=_notes(len(sites), tone.ink > 0, six is not None, power is not None, len(pairs) > 0),
        radial=power,
        pair_curve=(distance, pairs) if len(pairs) else None,
    )


def _regular(n: int, tone: Tone) -> tuple[float, float, float] | None:
    """The errors of quadrature of about n sites on a square grid in the canvas, weighed by coverage."""
    if not n:
        return None
    step = np.sqrt(shapely.area(tone.canvas) / n)
    x, y = (np.arange(step / 2, side, step) for side in tone.size)
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    grid = grid[tone.holds(grid)]
    found = quadrature.of(grid, tone, weights=tone.at(grid))
    return None if found is None else (found.smooth, found.edge, found.polynomial)


def _notes(n: int, ink: bool, inner: bool, level: bool, deep: bool) -> tuple[str, ...]:
    """Why there are figures that are None."""
    said = {
        "no two sites: there are no distances": n > 1,
        "no ink: nothing says how dense sites should be": ink,
        "the outline cuts every cell: there is no evenness and no share of hexagons": inner,
        "fewer than 256 sites, or no part of them level in tone and on the canvas whole: there is no spectrum": level,
        "no site has three spacings of canvas around it: there is no pair correlation": deep,
    }
    return tuple(note for note, good in said.items() if not good)


def _even(canvas: shapely.Geometry) -> tuple[Tone, Array]:
    """An even tone on a canvas, moved to the origin, and where its corner was."""
    if not shapely.area(canvas) > 0:
        raise ValueError(f"canvas is a {canvas.geom_type} without area; give a polygon in mm")
    low, high = np.reshape(shapely.bounds(canvas), (2, 2))
    size = high - low
    moved = shapely.transform(canvas, lambda xy: xy - low)
    whole = shapely.area(canvas) >= size.prod() * (1 - 1e-12)  # rounding of one product
    shape = (1, 1) if whole else tuple(np.maximum(1, np.ceil(PIXELS * size[::-1] / size.max())).astype(int))
    return Tone(np.ones(shape), (float(size[0]), float(size[1])), None if whole else moved), low


def nearest(sites: npt.ArrayLike) -> Array:
    """The distance of each site (n, 2) to the nearest other, (n,) mm: 0 for coincident ones, inf for one alone."""
    return _beside(frozen(sites, np.float64, (None, 2), "sites"))[1]


def _beside(sites: Array) -> tuple[Index, Array]:
    """Which other site is nearest to each, its own index where there is none, and how far off it is."""
    from scipy.spatial import cKDTree

    index, distance = np.arange(len(sites)), np.full(len(sites), np.inf)
    order = np.lexsort(sites.T)
    twin = (sites[order[1:]] == sites[order[:-1]]).all(axis=1)
    first = order[np.flatnonzero(~np.concatenate([[False], twin]))] if len(sites) else order
    if len(first) > 1:  # a heap of coincident sites would be one leaf of the tree, each asking all
        near, which = cKDTree(sites[first]).query(sites[first], [2])
        index[first], distance[first] = first[np.asarray(which)[:, 0]], np.asarray(near)[:, 0]
    for one, other in ((order[1:][twin], order[:-1][twin]), (order[:-1][twin], order[1:][twin])):
        index[one], distance[one] = other, 0.0
    return index, distance


def whole(cells: Cells) -> npt.NDArray[np.bool_]:
    """Which sites have their cell as it would be on an endless canvas, (n,): not cut by the outline, nor handed a part."""
    found = np.zeros(len(cells.sites), bool)
    if cells.net is None:
        return found
    endless = cells.net.rings().areas
    area = cells.areas[cells.net.unique]
    found[cells.net.unique] = (np.diff(cells.first)[cells.net.unique] == 1) & (np.abs(area - endless) <= ALIKE * endless)
    return found


def evenness(cells: Cells, near: Array | None = None) -> float | None:
    """The mean of each site's distance to its nearest, over what a hexagonal lattice of cells as large as its own has.

    1 for that lattice. Cells that the outline cuts, and second ones of coincident sites, do not count; None where no
    others are.

    near  nearest(sites), if it is known
    """
    kept = np.flatnonzero(whole(cells))
    if len(kept) == 0 or len(cells.sites) < 2:
        return None
    near = nearest(cells.sites) if near is None else near
    area = cells.areas
    return float((near[kept] / np.sqrt(HEXAGONAL * area[kept])).mean())


def alpha(sites: npt.ArrayLike, tone: Tone, near: Array | None = None) -> float | None:
    """The least distance to a nearest site, over that of a hexagonal lattice as dense as the tone asks there.

    On an even tone that is dmin / sqrt(2 A / (sqrt(3) n)). Sites on white paper have no density, and do not count; None
    where no other two are.
    Source: A. Lagae, P. Dutre, A Comparison of Methods for Generating Poisson Disk Distributions, 2008.
    """
    sites = frozen(sites, np.float64, (None, 2), "sites")
    asked = spectrum.Density.of(tone, len(sites)).around(sites)[0]
    near = nearest(sites) if near is None else near
    kept = (asked > 0) & np.isfinite(near)
    return float((near[kept] * np.sqrt(asked[kept] / HEXAGONAL)).min()) if kept.any() else None


def hexagons(cells: Cells) -> float | None:
    """The share of six-sided cells among those that the outline does not cut; None where it cuts all."""
    kept = np.flatnonzero(whole(cells))
    sides = np.diff(cells.rings.start)[cells.first[kept]]  # cocircular sites share a corner: no side has length 0
    return float((sides == 6).mean()) if len(kept) else None


def capacity_error(cells: Cells, tone: Tone) -> float | None:
    """The mean of (ink of a cell over the mean ink - 1)^2, cut cells and all: 0 when all have as much.

    Second ones of coincident sites have none. None without sites or ink.
    Source: M. Balzer, T. Schloemer, O. Deussen, Capacity-Constrained Point Distributions, 2009.
    """
    mass = moments.of_tone(cells, tone).mass
    return float(((mass / mass.mean() - 1) ** 2).mean()) if mass.sum() > 0 else None


def gap(marks: Marks) -> float | None:
    """The least distance between the outlines of two closed marks, mm: 0 where any meet, None for fewer than two.

    Within 2e-4 mm, what curves lose as polygons, or 2e-5 of the largest mark. Marks of no size do not count. Circles around
    and inside marks say which may be nearest; shapely measures those, the likeliest first.
    """
    marks = marks.take(marks.scale > 0)
    if len(marks) < 2:
        return None
    xy, outer = marks.xy, np.array([glyph.reach for glyph in marks.glyphs])[marks.glyph] * marks.scale
    beside = np.stack([np.arange(len(xy)), _beside(xy)[0]], axis=1)
    least = _least(marks, beside, outer, np.inf)
    if least == 0:
        return 0.0
    low, high = xy - outer[:, None], xy + outer[:, None]
    around = shapely.box(*(low - least).T, *(high + least).T)
    pairs = shapely.STRtree(shapely.box(*low.T, *high.T)).query(around).T
    return _least(marks, pairs[pairs[:, 0] < pairs[:, 1]], outer, least)


def _least(marks: Marks, pairs: npt.NDArray[np.integer], outer: Array, least: float) -> float:
    """The least distance of the outlines of these pairs (m, 2), or `least`: pairs whose circles are further apart are skipped."""
    apart = np.hypot(*(marks.xy[pairs[:, 0]] - marks.xy[pairs[:, 1]]).T) - outer[pairs].sum(axis=1)
    order = np.argsort(apart, kind="stable")
    flat = max(FLAT, 1e-5 * float(marks.scale.max()))
    for begin in range(0, len(order), AT_ONCE):
        some = order[begin : begin + AT_ONCE]
        if least <= max(0.0, apart[some[0]]):
            break
        one, other = (marks.take(pairs[some, k]).outlines().flat(flat).polygons() for k in (0, 1))
        least = min(least, float(shapely.distance(one, other).min()))
    return least
