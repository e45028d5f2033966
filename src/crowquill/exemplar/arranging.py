"""Marks on a torus, moved one at a time wherever that brings pairs of them nearer to what a correlation asks for.

Source: C. L. Y. Yeong, S. Torquato, Reconstructing random media, Physical Review E 57(1), 1998.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from crowquill.exemplar.correlation import FINE, lens, shares
from crowquill.kernel import compiled
from crowquill.paths import Array, Index

SWEEPS = 16  # of proposals; most tones are met in two or three
STRICT = 6  # of them leave older marks where they are
PROPOSED = 2  # places to a mark that may move
NEAR, LOOSE = 0.003, 0.02  # rms by which the correlation may be missed by pairs, and by which older marks begin to slide
LIGHT = 0.2  # coverage below which it may be missed by less: of few marks it is small by itself
IDLE = 0.002  # of proposals: fewer that are taken are an end
LOCAL = (0.5, 0.15)  # of a mark's diameter: how far proposals lie, where they are not anywhere in the square
ROOM = 0.5  # of it: how far an older mark slides from one tone to the next


@dataclass(frozen=True, eq=False)
class Goal:
    """What pairs of marks are to add up to: discs of an area and diameter on a torus of a side, and the correlation of their ink.

    lags, correlation  (m,), see correlation.radial; `coverage` is what the marks cover together
    """

    side: float
    area: float
    diameter: float
    coverage: float
    lags: Array
    correlation: Array

    def sums(self, count: int) -> Array:
        """What pairs of so many marks share at each lag, (m,) mm^2, if none lay on another."""
        density = count / self.side**2
        ink = self.correlation * self.coverage * (1 - self.coverage) + (density * self.area) ** 2
        return np.asarray(self.side**2 / 2 * (ink - density * lens(self.lags, self.diameter)))

    def missed(self, off: Array) -> float:
        """The correlation's error, rms, where sums over pairs are off by this much."""
        return float(np.sqrt(np.mean(off**2)) * 2 / self.side**2 / (self.coverage * (1 - self.coverage)))


def arranged(xy: Array, before: Array, squares: int, goal: Goal, rng: np.random.Generator) -> Array:
    """Places (n, 2) mm of marks moved until pairs give what is asked for, or no more is gained.

    before   (k, 2) mm, where the first k of them were in the lighter tone: each slides ROOM of a diameter at most from there,
             and only if the tone is missed by more than LOOSE without that
    squares  to a side of the torus, which the other marks do not leave
    """
    n, first, side, diameter = len(xy), len(before), goal.side, goal.diameter
    if not n:
        return xy
    table = shares(goal.lags, diameter)
    low = np.argmax(table > 0, axis=1)
    high = np.where((table > 0).any(axis=1), table.shape[1] - np.argmax(table[:, ::-1] > 0, axis=1), 0)
    reach = float(min((len(table) - 1) * diameter / FINE, 0.42 * side))
    bins = int(3 * side / reach)
    x, y = np.ascontiguousarray(xy.T)
    chains = _chained(x, y, side, bins)
    finer = FINE / diameter
    total, wanted = np.zeros(len(goal.lags)), goal.sums(n)
    _summed(x, y, side, bins, *chains, table, low, high, finer, reach, total)
    room = 0.0
    for sweep in range(SWEEPS):
        missed = goal.missed(total - wanted)
        if missed < NEAR * min(1, goal.coverage / LIGHT):
            break
        if sweep >= STRICT and missed > LOOSE:
            room = ROOM * diameter
        free = 0 if room else first
        tries = PROPOSED * (n - free)
        which = free + rng.integers(max(n - free, 1), size=tries)
        local = rng.random(tries) < 0.5
        places = rng.random((tries, 2))
        away = rng.normal(0, 1, (tries, 2)) * diameter * rng.choice(LOCAL, tries)[:, None]
        taken = _moved(
            x, y, before, room, side, bins, *chains, which, local, places, away, squares, table, low, high, finer, reach, total, wanted
        )  # fmt: skip
        if taken < IDLE * tries and sweep >= STRICT:
            break
    return np.stack([x, y], axis=1)


def _chained(x: Array, y: Array, side: float, bins: int) -> tuple[Index, Index, Index]:
    """Marks in squares as chains: the first of each square, and the next and the last before each mark; -1 for none."""
    head, after, before = np.full(bins * bins, -1), np.full(len(x), -1), np.full(len(x), -1)
    _linked(x, y, side, bins, head, after, before)
    return head, after, before


@compiled
def _square(x: float, y: float, side: float, bins: int) -> int:
    return min(int(y / side * bins), bins - 1) * bins + min(int(x / side * bins), bins - 1)


@compiled
def _linked(x: Array, y: Array, side: float, bins: int, head: Index, after: Index, before: Index) -> None:
    for i in range(len(x)):
        at = _square(x[i], y[i], side, bins)
        after[i] = head[at]
        if head[at] >= 0:
            before[head[at]] = i
        head[at] = i


@compiled
def _paired(
    px: float, py: float, own: int, sign: float, x: Array, y: Array, side: float, bins: int, head: Index, after: Index,
    table: Array, low: Index, high: Index, finer: float, reach: float, sums: Array,
) -> None:  # fmt: skip
    """Adds to sums what a mark at a place shares with all others, times a sign."""
    row, column = min(int(py / side * bins), bins - 1), min(int(px / side * bins), bins - 1)
    for down in range(-3, 4):
        for across in range(-3, 4):
            j = head[((row + down) % bins) * bins + (column + across) % bins]
            while j >= 0:
                if j != own:
                    dx, dy = abs(x[j] - px), abs(y[j] - py)
                    dx, dy = min(dx, side - dx), min(dy, side - dy)
                    squared = dx * dx + dy * dy
                    if squared < reach * reach:
                        k = int(np.sqrt(squared) * finer + 0.5)
                        for d in range(low[k], high[k]):
                            sums[d] += sign * table[k, d]
                j = after[j]


@compiled
def _summed(
    x: Array, y: Array, side: float, bins: int, head: Index, after: Index, _before: Index,
    table: Array, low: Index, high: Index, finer: float, reach: float, total: Array,
) -> None:  # fmt: skip
    for i in range(len(x)):
        _paired(x[i], y[i], i, 0.5, x, y, side, bins, head, after, table, low, high, finer, reach, total)


@compiled
def _moved(
    x: Array, y: Array, anchor: Array, room: float, side: float, bins: int, head: Index, after: Index, before: Index, which: Index,
    local: npt.NDArray[np.bool_], places: Array, away: Array, squares: int, table: Array, low: Index, high: Index, finer: float,
    reach: float, total: Array, goal: Array,
) -> int:  # fmt: skip
    """Moves marks to proposed places where that lowers the sum of squares of total - goal; gives how many moved.

    The first, which have an anchor (k, 2), stay within `room` of it, all others in their own squares.
    """
    taken, change = 0, np.empty(len(total))
    width = side / squares
    for t in range(len(which)):
        i = which[t]
        px, py = x[i] + away[t, 0], y[i] + away[t, 1]
        if i < len(anchor):
            if (px - anchor[i, 0]) ** 2 + (py - anchor[i, 1]) ** 2 > room * room or not (0 <= px < side and 0 <= py < side):
                continue
        else:
            left, top = min(int(x[i] / width), squares - 1) * width, min(int(y[i] / width), squares - 1) * width
            if not local[t]:
                px, py = left + places[t, 0] * width, top + places[t, 1] * width
            elif not (left <= px < left + width and top <= py < top + width):
                continue
        change[:] = 0
        _paired(x[i], y[i], i, -1.0, x, y, side, bins, head, after, table, low, high, finer, reach, change)
        _paired(px, py, i, 1.0, x, y, side, bins, head, after, table, low, high, finer, reach, change)
        gain = 0.0
        for d in range(len(total)):
            gain += change[d] * (change[d] + 2 * (total[d] - goal[d]))
        if gain >= 0:
            continue
        taken += 1
        total += change
        old, new = _square(x[i], y[i], side, bins), _square(px, py, side, bins)
        x[i], y[i] = px, py
        if old != new:
            if before[i] >= 0:
                after[before[i]] = after[i]
            else:
                head[old] = after[i]
            if after[i] >= 0:
                before[after[i]] = before[i]
            before[i], after[i] = -1, head[new]
            if head[new] >= 0:
                before[head[new]] = i
            head[new] = i
    return taken
