"""Sites as a rule of quadrature: how well their mean stands for an integral over the tone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import shapely
from numpy.polynomial.legendre import leggauss, legvander

from crowquill import moments
from crowquill.cells import Cells
from crowquill.paths import Array, Paths, frozen
from crowquill.tone import Tone

FUNCTIONS = 16  # of each family
FINEST = 512  # parts of a side over which factors are integrated, with three points each
Factors = Callable[[Array], Array]  # of one coordinate in 0 to 1: values (m,) to (functions, m)


@dataclass(frozen=True)
class Quadrature:
    """Errors of means over sites as integrals over a density: root mean square over a family of functions, of the functions' own.

    smooth      bumps a tenth of the canvas wide, products of sines
    edge        half planes
    polynomial  products of Legendre's up to degree 4
    random      what as many sites placed at random would have: three figures in the same order
    """

    smooth: float
    edge: float
    polynomial: float
    random: tuple[float, float, float]


def of(sites: npt.ArrayLike, tone: Tone, *, weights: npt.ArrayLike | None = None) -> Quadrature | None:
    """How well sites (n, 2) stand for the tone's density: None without sites, weight or ink.

    weights   (n,) each site's share, as the ink of its cell; the same for all when left out. `random` is for equal ones.

    Sites off the picture count at its edge. Integrals of coverage times function are exact to rounding for coverage
    constant on each pixel; pixels that the canvas's outline crosses count, but for half planes, as if the ink of their
    part were spread over them.
    """
    sites = frozen(sites, np.float64, (None, 2), "sites")
    share = np.ones(len(sites)) if weights is None else frozen(weights, np.float64, (len(sites),), "weights")
    if not share.sum() > 0 or not tone.ink > 0:
        return None
    share = share / share.sum()
    x, y = np.clip(sites / tone.size, 0, 1).T
    ink = tone.coverage * tone.inside
    ink = ink / ink.sum()
    figures = []
    for across, down in (_smooth(), _polynomials()):
        mean, square = (np.einsum("kh,hk->k", _means(down, ink.shape[0], p), ink @ _means(across, ink.shape[1], p).T) for p in (1, 2))
        figures.append((across(x) * down(y) @ share - mean, mean, square))
    mean, found = _half_planes(sites, share, tone)
    figures.insert(1, (found - mean, mean, mean))
    parts = [(float(np.sqrt((e**2).sum() / s.sum())), float(np.sqrt(max(0.0, (s - m**2).sum()) / s.sum() / len(x)))) for e, m, s in figures]
    (smooth, a), (edge, b), (polynomial, c) = parts
    return Quadrature(smooth, edge, polynomial, (a, b, c))


def _spots(n: int, start: int = 0) -> Array:
    """Places (n, 2) that fill the unit square evenly and line up with no grid."""
    golden = np.array([0.7548776662466927, 0.5698402909980532])  # 1 / g and 1 / g^2, g^3 = g + 1
    return np.asarray((0.5 + np.arange(1 + start, 1 + start + n)[:, None] * golden) % 1)


def _smooth() -> tuple[Factors, Factors]:
    half = FUNCTIONS // 2
    middle, phase, waves = _spots(half), _spots(half, 100), 0.5 + 2.5 * _spots(half, 200)

    def factors(axis: int) -> Factors:
        return lambda t: np.concatenate(
            [
                np.exp(-(((t - middle[:, axis, None]) / 0.1) ** 2) / 2),
                np.sin(2 * np.pi * (waves[:, axis, None] * t + phase[:, axis, None])),
            ]
        )

    return factors(0), factors(1)


def _polynomials() -> tuple[Factors, Factors]:
    degrees = [(a, b) for a in range(5) for b in range(5 - a) if a + b]

    def factors(axis: int) -> Factors:
        return lambda t: legvander(2 * t - 1, 4).astype(np.float64).T[[degree[axis] for degree in degrees]]

    return factors(0), factors(1)


def _means(factors: Factors, parts: int, power: int) -> Array:
    """The mean of each function's power over each of so many parts of 0 to 1, (functions, parts)."""
    node, weight = leggauss(3)
    finer = -(-FINEST // parts)
    at = (np.arange(parts * finer)[:, None] + (1 + node) / 2) / (parts * finer)
    values = factors(at.ravel()).reshape(-1, parts, finer, 3) ** power
    return np.asarray((values @ weight).mean(axis=2) / 2)


def _half_planes(sites: Array, share: Array, tone: Tone) -> tuple[Array, Array]:
    """The share of ink, and of the sites' weights, beyond each of some lines."""
    through, reach = _spots(FUNCTIONS) * tone.size, 4 * float(np.hypot(*tone.size))
    turn = 2 * np.pi * _spots(FUNCTIONS, 300)[:, 0]
    normal, along = np.stack([np.cos(turn), np.sin(turn)], axis=1), np.stack([-np.sin(turn), np.cos(turn)], axis=1)
    corners = [through - reach * along, through - reach * along + reach * normal]
    corners += [through + reach * along + reach * normal, through + reach * along]
    beyond = shapely.intersection(shapely.polygons(np.stack(corners, axis=1)), tone.canvas)
    rings, owner = Paths.of_polygons(beyond)
    parts = Cells(frozen(through, np.float64, (None, 2), "through"), rings, owner, tone.canvas)
    mass = moments.of_tone(parts, tone).mass / tone.ink
    far = ((sites[None] - through[:, None]) * normal[:, None]).sum(axis=2) > 0
    return mass, far @ share
