"""Means of pixels over the squares of another grid, exact to the part of a pixel."""

from __future__ import annotations

import numpy as np

from crowquill.kernel import compiled, shared_out
from crowquill.levels import Levels
from crowquill.paths import Array

ROWS = 16  # at least to a thread


def averaged(values: Array | Levels, x: Array, y: Array) -> Array:
    """Means (m, n) of values (h, w), or levels, each the height of a square, over the boxes between x (n + 1,) and y (m + 1,), both rising.

    x and y count pixels from the first corner, in any part of one; beyond the pixels there is nothing, which counts as 0.

    >>> averaged(np.array([[0.0, 1.0]]), np.array([0.0, 0.5, 1.5, 2.5]), np.array([0.0, 1.0])).tolist()
    [[0.0, 0.5, 0.5]]
    """
    means = np.zeros((len(y) - 1, len(x) - 1))
    if isinstance(values, Levels) and values.table is not None:
        for lo in range(0, len(means), ROWS):  # of codes a band at a time: all of their numbers would be eight times as much
            part = y[lo : lo + ROWS + 1]
            first = min(max(int(part[0]), 0), values.shape[0] - 1)
            _averaged(values.rows(first, max(first + 1, int(np.ceil(part[-1])))), x, part - first, means[lo : lo + ROWS])
        return means
    plain = values.codes if isinstance(values, Levels) else values
    shared_out(lambda lo, hi: _averaged(plain, x, y[lo : hi + 1], means[lo:hi]), len(means), ROWS)
    return means


@compiled
def _averaged(values: Array, x: Array, y: Array, means: Array) -> None:
    h, w = values.shape
    sums = np.empty(w + 1)
    for r in range(len(means)):
        top, bottom = min(max(y[r], 0.0), float(h)), min(max(y[r + 1], 0.0), float(h))
        sums[:] = 0
        for row in range(int(top), int(np.ceil(bottom))):
            part = min(bottom, row + 1.0) - max(top, float(row))
            for c in range(w):
                sums[c + 1] += part * values[row, c]
        for c in range(w):
            sums[c + 1] += sums[c]
        before = _up_to(sums, x[0])
        for c in range(means.shape[1]):
            after = _up_to(sums, x[c + 1])
            means[r, c] = (after - before) / ((y[r + 1] - y[r]) * (x[c + 1] - x[c]))
            before = after


@compiled
def _up_to(sums: Array, x: float) -> float:
    """The sum of all that is left of x."""
    place = min(max(x, 0.0), len(sums) - 1.0)
    whole = min(int(place), len(sums) - 2)
    return float(sums[whole] + (place - whole) * (sums[whole + 1] - sums[whole]))
