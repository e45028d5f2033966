"""Refining: few sites at rest become many that lie like them, each with the ink of one.

On a hexagonal lattice the sites and the middles between neighbours are a lattice of half the pitch. What lies so regularly needs few steps
more, and these steps are on few sites; but few sites know nothing of detail, so that the ink of each new cell says
whether it stays, parts or goes.
"""

from __future__ import annotations

import numpy as np

from crowquill import hilbert, moments
from crowquill.cells import Cells, voronoi
from crowquill.paths import Array
from crowquill.tone import Tone

SHAKEN = 0.1  # spacings, root mean square each way: without it lattices of few sites grow to four times as many
TWINS = 0.01  # where that leaves the ink: sites of one place must not coincide


def refined(cells: Cells, tone: Tone, n: int, rng: np.random.Generator) -> Array:
    """n sites (n, 2) mm, about four times as many as the cells had, in the order of a Hilbert curve, all on pixels with ink.

    Of the cells' sites and the middles between neighbours, strung along the curve, each becomes as many sites as the sum of ink up
    to it passes n-ths of the whole: mostly one, at the centroid of its ink; two part along the cell's long axis. Then all are
    shaken a little. Without ink on the canvas it gives (0, 2).
    """
    between = cells.sites[cells.net.edges[0]].mean(axis=1) if cells.net else np.zeros((0, 2))
    every = np.concatenate([cells.sites, between])
    every = every[_inked(every, tone)]
    every = every[hilbert.of_points(every)]
    new = voronoi(every, tone.canvas)
    found = moments.of_tone(new, tone)
    total = np.cumsum(found.mass)
    if not len(every) or not total[-1] > 0:
        return np.zeros((0, 2))
    passed = np.floor(total / total[-1] * n + 0.5).astype(np.int64)
    number = np.diff(np.minimum(passed, n), prepend=0)
    own = np.repeat(np.arange(len(every)), number)
    place = np.arange(n) - np.repeat(np.cumsum(number) - number, number)
    share = (2 * place + 1) / number[own] - 1  # -1 to 1 along the axis, the middles of as many pieces
    xx, xy, yy = found.covariance[own].reshape(-1, 4)[:, [0, 1, 3]].T
    axis = np.arctan2(2 * xy, xx - yy) / 2
    long = np.sqrt((xx + yy) / 2 + np.hypot((xx - yy) / 2, xy))  # the spread along it
    sites: Array = found.centroid[own] + (share * long)[:, None] * np.stack([np.cos(axis), np.sin(axis)], axis=1)
    shake = np.sqrt(new.areas[own] / number[own])[:, None] * rng.standard_normal((n, 2))
    sites += SHAKEN * shake
    for other in (every[own] + TWINS * shake, every[own]):
        lost = ~_inked(sites, tone)
        sites[lost] = other[lost]
    return sites


def _inked(xy: Array, tone: Tone) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which places lie in the canvas on a pixel with ink."""
    return np.asarray(tone.holds(xy) & (tone.at(xy) > 0))
