"""Capacity: weights with which the power cells of given sites hold the same ink each, and sites that move to the middle of theirs.

The ink of a cell rises with its site's weight, and falls with its neighbours' by the ink along their border: Newton's method
solves for all weights at once. They are those of the cheapest transport of the ink to the sites.
Source: F. de Goes, K. Breeden, V. Ostromoukhov, M. Desbrun, Blue Noise through Optimal Transport, SIGGRAPH Asia 2012;
J. Kitagawa, Q. Merigot, B. Thibert, Convergence of a Newton Algorithm for Semi-Discrete Optimal Transport, JEMS 21, 2019.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import cells, moments, relax
from crowquill.paths import Array, frozen
from crowquill.tone import Tone

EQUAL = 1e-6  # of the mean: no cell's ink is off by more
NEARLY = 0.03  # of the mean will do while sites still move
ROUNDS = 60  # of Newton's method; 3 to 8 are enough where ink hangs together, some 30 were where it lies in islands
HALVED = 40  # times, at most, that a step is halved

WHITE = 1e-3  # of the mean coverage is reckoned with on white borders, so that islands are tied to their neighbours: half the work
LEAST = 0.02  # of the mean: weights of sites that have moved are given up where they leave a cell less


@dataclass(frozen=True, eq=False)
class Shares:
    """Sites (n, 2), their weights (n,) mm^2, their power cells, and the ink in these.

    error  the greatest |ink of a cell / mean - 1|; 0 without sites or ink
    value  mm^4, greatest where all cells hold the same: what the transport of the ink to the sites costs at least
    """

    sites: Array
    weights: Array
    cells: cells.Cells
    moments: moments.Moments
    error: float
    value: float

    @classmethod
    def of(cls, sites: Array, weights: Array, tone: Tone) -> Shares:
        """The shares that these weights give."""
        parts = cells.power(sites, weights, tone.canvas, joined=False)
        found = moments.of_tone(parts, tone)
        mean = found.mass.sum() / max(1, len(sites))
        error = float(np.abs(found.mass / mean - 1).max()) if mean > 0 else 0.0
        spread = np.trace(found.covariance, axis1=1, axis2=2) + ((found.centroid - sites) ** 2).sum(axis=1)
        return cls(sites, weights, parts, found, error, float((found.mass * spread - (found.mass - mean) * weights).sum()))

    @property
    def short(self) -> Array:
        """What each cell lacks to the mean, mm^2 of ink."""
        return np.asarray(self.moments.mass.mean() - self.moments.mass)


@dataclass(frozen=True, eq=False)
class State(relax.State):
    """Sites after `done` steps, cells and moments those of their shares."""

    shares: Shares


def equal(sites: npt.ArrayLike, tone: Tone, weights: Array | None = None, *, until: float = EQUAL, rounds: int = ROUNDS) -> Shares:
    """The shares of sites (n, 2) mm whose cells hold the same ink, within `until` of the mean, or what so many rounds come to.

    weights  to begin with, such as sites had that have moved a little; all alike when left out

    All sites that differ have such weights, where ink lies in islands too: a cell then has parts on several. Of coincident
    sites all but one have nothing, whatever the weights. Without sites or ink the shares are of no weights.
    """
    sites = frozen(sites, np.float64, (None, 2), "sites")
    now = Shares.of(sites, np.zeros(len(sites)) if weights is None else weights, tone)
    if weights is not None and now.moments.mass.min(initial=np.inf) < LEAST * tone.ink / max(1, len(sites)):
        now = Shares.of(sites, np.zeros(len(sites)), tone)
    least = now.moments.mass.min(initial=np.inf) / 2  # no cell may come to nothing on the way
    for _ in range(rounds):
        if now.error <= until:
            break
        after = _stepped(now, tone, _solved(now, tone), least)
        if after is None:
            break
        now = after
    return now


def relaxed(sites: npt.ArrayLike, tone: Tone, *, step: float = 1.3, banned: npt.NDArray[np.bool_] | None = None) -> Iterator[State]:
    """States of sites that hold the same ink within 3 % and go `step` times the way to its centroid, without end; first as given.

    A site that would leave the canvas or land on a banned pixel (h, w) goes to the centroid, or else stays.
    """
    shares = equal(sites, tone, until=NEARLY, rounds=ROUNDS // 6)
    done = 0
    while True:
        state = State.of(done, shares.sites, shares.cells, shares.moments, shares=shares)
        yield state
        shares = equal(relax.moved(state, tone, step=step, banned=banned), tone, shares.weights, until=NEARLY, rounds=ROUNDS // 6)
        done += 1


def _stepped(now: Shares, tone: Tone, way: Array, least: float) -> Shares | None:
    """The shares as far along a way of weights as they are better: nearer to equal, or of more value; None if they are nowhere.

    Across white the ink of cells does not change with their weights, but the value does.
    """
    reach = float(np.hypot(*np.diff(np.reshape(shapely.bounds(tone.canvas), (2, 2)), axis=0)[0]))
    length = min(1.0, reach**2 / float(np.abs(way).max()))  # further apart weights differ in nothing
    off = float(np.hypot.reduce(now.short))
    for _ in range(HALVED):
        after = Shares.of(now.sites, now.weights + length * way, tone)
        nearer = float(np.hypot.reduce(after.short)) <= (1 - length / 2) * off
        gained = after.value - now.value > 1e-4 * length * float(now.short @ way)
        if after.moments.mass.min() >= least and (nearer or gained):
            return after
        length /= 2
    return None


def _solved(now: Shares, tone: Tone) -> Array:
    """The change of weights that would give each cell what it lacks, if borders were to hold as much ink all the way."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import splu

    n, ((i, j), lines) = len(now.sites), (now.cells.borders[0].T, now.cells.borders[1])
    ink, even = moments.along(tone, lines), tone.ink / shapely.area(tone.canvas)
    ink = np.where(ink > 0, ink, WHITE * even * np.hypot(*(lines[:, 1] - lines[:, 0]).T))
    flow = ink / (2 * np.hypot(*(now.sites[i] - now.sites[j]).T))
    own = np.bincount(i, flow, n) + np.bincount(j, flow, n)
    own += 1e-9 * (own.mean() + even)  # all weights of an island rising together change nothing: of such changes the least is taken
    each = np.arange(n)
    rows, columns = np.concatenate([i, j, each]), np.concatenate([j, i, each])
    table = coo_matrix((np.concatenate([-flow, -flow, own]), (rows, columns)), shape=(n, n)).tocsc()
    # the matrix is symmetric and its diagonal outweighs the rest: no pivots are sought, and so the answer is the same everywhere
    way = splu(table, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve(now.short)
    return np.where(now.cells.areas > 0, way, 0.0)  # a second one of coincident sites has no cell, whatever its weight
