"""Whether seams can be told from the rest of a drawing: neighbours and spectra of strips along them against strips elsewhere.

Each strip is looked at in its own spacing, so that tone makes no difference. Dots near each other depend on each other, strips far
apart do not: to find how much chance would make of it, strips are dealt out anew, never dots.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from crowquill.paths import Array, Index

LONG, WIDE = 16.0, 6.0  # spacings: a strip along a seam, and across it
AROUND = 2.0  # spacings around a strip where neighbours are looked for
CLOSE = 1.5  # spacings: dots so near to a strip's middle line have their neighbours compared
EVEN = 0.45  # of their mean: the counts of a strip's quarters stray no more, or it lies over an edge of the picture
BINS = 60  # of distances
RINGS = np.arange(0.25, 2.01, 0.25)  # cycles a spacing: the edges of what powers are averaged over
DEALT = 2000  # times that strips are dealt out anew
TRIES = 50  # of places for a strip elsewhere, near and anywhere
FEWEST = 8  # strips of each kind, below which nothing is said


@dataclass(frozen=True)
class Seams:
    """What chance makes of differences as large as those found between strips on seams and elsewhere: p, or None for too few strips.

    nearest   of distances to the nearest dot, in spacings: the greatest distance between their distributions (Kolmogorov-Smirnov)
    spectrum  of power by frequency, along and across: the sum of squares of differences over their spread
    on, off   how many strips lie on seams and elsewhere

    A picture whose own grain or edges lie along the lines makes strips differ too; the same strips of a drawing without tiles tell.
    """

    nearest: float | None
    spectrum: float | None
    on: int
    off: int


@dataclass(frozen=True, eq=False)
class Strip:
    """Distances to the nearest dot in spacings (k,), of dots near the middle line, and the logarithm of power by ring, along and across."""

    nearest: Array
    power: Array


def of(sites: Array, lines: Array, size: tuple[float, float], rng: np.random.Generator, most: int = 400) -> Seams:
    """How well strips along straight lines (k, 2, 2) mm, upright or level, can be told from others, by sites (n, 2) mm in a size.

    most  strips of each kind: on every line in proportion to its length; as many elsewhere, clear of all lines and of each other
    """
    sites = np.array(sites[np.argsort(sites[:, 0], kind="stable")], order="F")  # x by itself, to be searched without a copy
    spacing = float(np.sqrt(size[0] * size[1] / max(1, len(sites))))
    places = _along(lines, LONG * spacing, most)
    beside = _beside(places, lines, spacing, size, rng)
    on = [strip for place in places if (strip := _strip(sites, place, spacing, size)) is not None]
    off = [strip for place in beside if (strip := _strip(sites, place, spacing, size)) is not None]
    if min(len(on), len(off)) < FEWEST:
        return Seams(None, None, len(on), len(off))
    return Seams(_nearest(on, off, rng), _spectrum(on, off, rng), len(on), len(off))


def _along(lines: Array, long: float, most: int) -> list[tuple[Array, int]]:
    """Middles of strips on lines, and the axis that each lies along."""
    found: list[tuple[Array, int]] = []
    total = float(np.hypot(*(lines[:, 1] - lines[:, 0]).T).sum()) if len(lines) else 0.0
    for begin, end in lines:
        length = float(np.hypot(*(end - begin)))
        axis = int(abs(end[1] - begin[1]) > abs(end[0] - begin[0]))
        number = min(int(length / long), max(1, round(most * length / total)))
        found += [(begin + (k + 0.5) / number * (end - begin), axis) for k in range(number)]
    return found


def _beside(
    places: list[tuple[Array, int]], lines: Array, spacing: float, size: tuple[float, float], rng: np.random.Generator
) -> list[tuple[Array, int]]:
    """For each strip one moved elsewhere, clear of all lines, near it if one of some tries is."""
    found: list[tuple[Array, int]] = []
    taken = np.zeros((0, 4))  # middles and half sides of what is found
    for middle, axis in places:
        half = np.where(np.arange(2) == axis, LONG, WIDE) * spacing / 2
        clear = half + (AROUND + 1) * spacing
        low, high = lines.min(axis=1) - clear, lines.max(axis=1) + clear
        near = middle + rng.uniform(-0.25, 0.25, (TRIES, 2)) * size
        others = np.concatenate([near, rng.random((TRIES, 2)) * size])
        free = ((others >= 0) & (others <= size)).all(axis=1)
        free &= ~np.any(np.all((others[:, None] >= low) & (others[:, None] <= high), axis=2), axis=1)
        free &= ~np.any(np.all(np.abs(others[:, None] - taken[:, :2]) < half + taken[:, 2:], axis=2), axis=1)
        for k in np.flatnonzero(free)[:1]:
            found.append((others[k], axis))
            taken = np.concatenate([taken, [[*others[k], *half]]])
    return found


def _strip(sites: Array, place: tuple[Array, int], spacing: float, size: tuple[float, float]) -> Strip | None:
    """What a strip shows; None where it leaves the drawing, or lies over an edge of the picture. Sites are sorted by x."""
    middle, axis = place
    for _ in range(4):  # the spacing of the place itself
        half = np.where(np.arange(2) == axis, LONG, WIDE) * spacing / 2
        inside = _within(sites, middle, half)
        if not len(inside):
            return None
        spacing = float(np.sqrt(4 * half.prod() / len(inside)))
    reach = half + AROUND * spacing
    if (middle - reach < 0).any() or (middle + reach > size).any() or len(inside) < LONG * WIDE / 2:
        return None
    away = (sites[inside] - middle) / half
    quarters = np.bincount((away[:, 0] > 0) + 2 * (away[:, 1] > 0), minlength=4)
    if np.abs(quarters / quarters.mean() - 1).max() > EVEN:
        return None
    around = _within(sites, middle, reach)
    core = inside[np.abs(sites[inside, 1 - axis] - middle[1 - axis]) < CLOSE * spacing]
    nearest = np.asarray(cKDTree(sites[around]).query(sites[core], k=2)[0], np.float64).reshape(-1, 2)[:, 1] / spacing
    return Strip(nearest, _power(away[:, [axis, 1 - axis]]))


def _within(sites: Array, middle: Array, half: Array) -> Index:
    """The sites of a box; sites are sorted by x."""
    lo, hi = np.searchsorted(sites[:, 0], [middle[0] - half[0], middle[0] + half[0]])
    return np.asarray(lo + np.flatnonzero(np.abs(sites[lo:hi, 1] - middle[1]) <= half[1]))


def _power(away: Array) -> Array:
    """The logarithm of mean power in rings of frequency, those more along the strip and those more across it; away is -1 to 1."""
    weight = np.prod(np.cos(np.pi / 2 * away) ** 2, axis=1)
    u, v = np.arange(0, int(2 * LONG) + 1), np.arange(-int(2 * WIDE), int(2 * WIDE) + 1)
    across, along = np.meshgrid(v, u, indexing="ij")
    f = np.hypot(along / LONG, across / WIDE)
    turns = np.exp(-1j * np.pi * np.outer(v, away[:, 1])), np.exp(-1j * np.pi * np.outer(u, away[:, 0]))
    waves = np.einsum("vk,uk,k->vu", *turns, weight)  # so small that a matrix product's threads cost more than they bring
    power = np.abs(waves) ** 2 / (weight**2).sum()
    kind = np.where(np.abs(along) / LONG > np.abs(across) / WIDE, 0, 1)
    ring = np.digitize(f, RINGS) - 1
    rings = len(RINGS) - 1
    good = (ring >= 0) & (ring < rings)
    index = (ring + rings * kind)[good]
    mean = np.bincount(index, power[good], 2 * rings) / np.maximum(1, np.bincount(index, minlength=2 * rings))
    return np.asarray(np.log(mean + 1e-9))


def _nearest(on: list[Strip], off: list[Strip], rng: np.random.Generator) -> float:
    """p of the greatest distance between the distributions of distances to nearest dots."""
    strips = on + off
    edges = np.quantile(np.concatenate([strip.nearest for strip in strips]), np.linspace(0, 1, BINS + 1)[1:-1])
    counts = np.array([np.bincount(np.searchsorted(edges, strip.nearest), minlength=BINS) for strip in strips], np.float64)

    def apart(first: npt.NDArray[np.bool_]) -> Array:
        mine, others = (which.astype(float) @ counts for which in (first, ~first))
        shares = [np.cumsum(part, axis=-1) / part.sum(axis=-1, keepdims=True) for part in (mine, others)]
        return np.asarray(np.abs(shares[0] - shares[1]).max(axis=-1))

    return _chance(apart, len(on), len(strips), rng)


def _spectrum(on: list[Strip], off: list[Strip], rng: np.random.Generator) -> float:
    """p of the sum of squares of differences of power."""
    power = np.array([strip.power for strip in on + off])
    power = (power - power.mean(axis=0)) / np.maximum(power.std(axis=0), 1e-9)

    def apart(first: npt.NDArray[np.bool_]) -> Array:
        means = [(which @ power) / which.sum(axis=-1, keepdims=True) for which in (first.astype(float), (~first).astype(float))]
        return np.asarray(((means[0] - means[1]) ** 2).sum(axis=-1))

    return _chance(apart, len(on), len(power), rng)


def _chance(apart: Any, first: int, every: int, rng: np.random.Generator) -> float:
    """How often strips dealt out anew lie as far apart as the first do from the others."""
    own = np.arange(every) < first
    dealt = rng.permuted(np.tile(own, (DEALT, 1)), axis=1)
    return float((1 + (apart(dealt) >= apart(own) - 1e-12).sum()) / (1 + DEALT))
