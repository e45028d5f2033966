"""Thresholds that repeat: square tiles of ranks, ordered so that any share of them lies evenly."""

from __future__ import annotations

from functools import cache

import numpy as np

from crowquill.kernel import compiled
from crowquill.paths import Array, Index, frozen

BAYER, VOIDS = 8, 64  # pixels: the sides of the tiles in use
SIGMA = 1.5  # pixels, of the bump by which void-and-cluster finds what is crowded; the paper's
FIRST = 0.1  # of the tile that is dark in the pattern it starts from
SEED = 1993  # of that pattern
UNIT = 1 << 40  # bumps are whole numbers of this part: their sums are exact, and no tie is decided by rounding


@cache
def bayer(side: int = BAYER) -> Array:
    """Thresholds (side, side) by Bayer's recursion, each of side^2 values once, from 0.5 / side^2; side is a power of two.

    Source: B. E. Bayer, An Optimum Method for Two-Level Rendition of Continuous-Tone Pictures, ICC 1973.

    >>> (bayer(2) * 4 - 0.5).astype(int).tolist()
    [[0, 2], [3, 1]]
    """
    ranks = np.zeros((1, 1), np.int64)
    while len(ranks) < side:
        ranks = np.block([[4 * ranks, 4 * ranks + 2], [4 * ranks + 3, 4 * ranks + 1]])
    return frozen((ranks + 0.5) / ranks.size, np.float64, (side, side), "thresholds")


@cache
def void_and_cluster(side: int = VOIDS) -> Array:
    """Thresholds (side, side) without a grain of their own, each of side^2 values once: the same each time.

    Source: R. Ulichney, The Void-and-Cluster Method for Dither Array Generation, SPIE 1913, 1993.
    """
    near = np.minimum(np.arange(side), side - np.arange(side)) ** 2
    bump = np.rint(UNIT * np.exp(-(near[:, None] + near) / (2 * SIGMA**2))).astype(np.int64)
    dark = np.zeros(side * side, np.bool_)
    dark[np.random.default_rng(SEED).permutation(side * side)[: max(1, int(FIRST * side * side))]] = True
    ranks = np.empty(side * side, np.int64)
    _ranked(bump, dark.reshape(side, side), ranks.reshape(side, side))
    return frozen((ranks.reshape(side, side) + 0.5) / ranks.size, np.float64, (side, side), "thresholds")


@compiled
def _ranked(bump: Index, dark: np.typing.NDArray[np.bool_], ranks: Index) -> None:
    """Fills the ranks: each pixel's turn to become dark."""
    side = len(bump)
    crowd = np.zeros((side, side), np.int64)
    n = 0
    for y in range(side):
        for x in range(side):
            if dark[y, x]:
                _add(crowd, bump, y, x, 1)
                n += 1
    moved = True
    while moved:  # the most crowded goes to the greatest void, as long as there is one greater than it leaves
        y, x = _extreme(crowd, dark, True)
        dark[y, x] = False
        _add(crowd, bump, y, x, -1)
        v, u = _extreme(crowd, dark, False)
        moved = crowd[v, u] < crowd[y, x]
        if not moved:
            v, u = y, x
        dark[v, u] = True
        _add(crowd, bump, v, u, 1)
    start, field = dark.copy(), crowd.copy()
    for rank in range(n - 1, -1, -1):
        y, x = _extreme(crowd, dark, True)
        dark[y, x] = False
        _add(crowd, bump, y, x, -1)
        ranks[y, x] = rank
    dark[:], crowd[:] = start, field
    # past a half the paper looks for the most crowded light pixel: that is the greatest void again, as all bumps sum to one height
    for rank in range(n, side * side):
        y, x = _extreme(crowd, dark, False)
        dark[y, x] = True
        _add(crowd, bump, y, x, 1)
        ranks[y, x] = rank


@compiled
def _extreme(crowd: Index, dark: np.typing.NDArray[np.bool_], most: bool) -> tuple[int, int]:
    """The dark pixel that is most crowded, or the light one in the greatest void; of equals the first."""
    found_y, found_x, best = -1, -1, 0
    for y in range(len(crowd)):
        for x in range(len(crowd)):
            if dark[y, x] == most and (found_y < 0 or (crowd[y, x] > best if most else crowd[y, x] < best)):
                found_y, found_x, best = y, x, crowd[y, x]
    return found_y, found_x


@compiled
def _add(crowd: Index, bump: Index, y: int, x: int, sign: int) -> None:
    """Adds a bump at a pixel, or takes it away; the tile goes on at its sides."""
    side = len(bump)
    for v in range(side):
        for u in range(side):
            crowd[v, u] += sign * bump[(v - y) % side, (u - x) % side]
