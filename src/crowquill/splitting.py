"""Splitting: sites that part in two where a cell holds too much ink, and go where it holds too little, until the number is right.

Source: O. Deussen, M. Spicker, Q. Zheng, Weighted Linde-Buzo-Gray Stippling, SIGGRAPH Asia 2017; Y. Linde, A. Buzo, R. Gray,
An Algorithm for Vector Quantizer Design, IEEE Trans. Communications 28, 1980.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from crowquill import moments, relax
from crowquill.paths import Array, Index, frozen
from crowquill.tone import Tone

GONE = 0.3  # of the sites, at most, go in one step: from one site on, cells all fall short together, and without a bound all go
APART = 0.5  # of the radius of a circle as large as the cell: how far from the middle either half begins
SHAKEN = 0.02  # of that radius, so that halves of halves do not line up


@dataclass(frozen=True, eq=False)
class State(relax.State):
    """Sites after `done` steps, cells and moments of the ink; how many of them will part, and how many go, in the next step."""

    parting: int
    going: int


def divided(
    sites: npt.ArrayLike,
    tone: Tone,
    share: float,
    rng: np.random.Generator,
    *,
    band: tuple[float, float] = (0.5, 0.05),
    step: float = 1.8,
    exponent: float = 2.0,
    exact: bool = True,
    banned: npt.NDArray[np.bool_] | None = None,
) -> Iterator[State]:
    """States of sites that become as many as there are shares in the ink, the sites as they were given first.

    sites     (n, 2) mm in the canvas, one at least; halves of one that parts follow each other in its place
    share     mm^2 of the tone's ink that is one site's
    band      how far cells may be off: half of it, in shares, either way; and by how much it widens a step
    exact     of those over the band and under it as many part and go as make the number right, and states have no end. Without it
              all do until none is left, which is the published rule: from one site on with a band of (0.6, 0.01), step 1 and
              exponent 1. Cells of two thirds of a share stay, and so it ends with up to a third too many
    exponent  sites move by coverage to this power, as in relax.lloyd; so do step and banned

    Raises ValueError for a share that is not over 0.
    """
    if not share > 0:
        raise ValueError(f"share is {share} mm2 of ink; it takes a number over 0")
    return _states(frozen(sites, np.float64, (None, 2), "sites"), tone, share, rng, band, step, exponent, exact, banned)


def _states(
    sites: Array,
    tone: Tone,
    share: float,
    rng: np.random.Generator,
    band: tuple[float, float],
    step: float,
    exponent: float,
    exact: bool,
    banned: npt.NDArray[np.bool_] | None,
) -> Iterator[State]:
    weight = tone if exponent == 1 else tone.mapped(lambda coverage: coverage**exponent)
    done = 0
    while True:
        now = relax.measured(sites, tone, tone, done=done, banned=banned)
        sites, ink = now.sites, now.moments
        middle = ink if weight is tone else moments.of_tone(now.cells, weight)
        parting, going = _chosen(ink.mass / share, band[0] + band[1] * done, round(tone.ink / share) if exact else None)
        yield State.of(done, sites, now.cells, ink, parting=len(parting), going=len(going))
        if not exact and not len(parting) and not len(going):
            return
        moved = relax.moved(replace(now, moments=middle), tone, step=step, banned=banned)
        halves = [relax.held(tone, banned, half, sites[parting]) for half in _halves(middle, now.cells.areas, parting, rng)]
        moved[parting] = halves[0]
        order = np.argsort(np.concatenate([np.arange(len(sites)), parting]), kind="stable")
        stay = np.ones(len(order), bool)
        stay[going] = False
        every = np.concatenate([moved, halves[1]])
        sites, done = every[order[stay[order]]], done + 1


def _chosen(shares: Array, band: float, wanted: int | None) -> tuple[Index, Index]:
    """Which sites part and which go, by the shares of ink in their cells: the fullest and the emptiest.

    wanted  how many there shall be. Were they too many, fewer part, and then more go; were they too few, fewer go, and then more part
    """
    n, order = len(shares), np.argsort(shares, kind="stable")
    parting = int((shares >= 1 + band / 2).sum())
    going = min(int((shares < 1 - band / 2).sum()), int(GONE * n))
    if wanted is not None:
        over = n + parting - going - wanted
        if over > 0:
            parting, going = max(parting - over, 0), min(going + max(over - parting, 0), n - 1)
        else:
            parting, going = min(parting + max(-over - going, 0), n), max(going + over, 0)
    return np.sort(order[n - parting :]), np.sort(order[:going])


def _halves(middle: moments.Moments, areas: Array, which: Index, rng: np.random.Generator) -> tuple[Array, Array]:
    """Where the halves of these cells begin: off their centroids along their long axes, and a little by chance."""
    centroid, covariance = middle.centroid[which], middle.covariance[which]
    axis = np.arctan2(2 * covariance[:, 0, 1], covariance[:, 0, 0] - covariance[:, 1, 1]) / 2
    radius = np.sqrt(areas[which] / np.pi)[:, None]
    way = APART * radius * np.stack([np.cos(axis), np.sin(axis)], axis=1)
    chance = SHAKEN * radius * rng.uniform(-1, 1, (2, len(which), 2))
    return centroid + way + chance[0], centroid - way + chance[1]
