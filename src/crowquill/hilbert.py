"""The Hilbert curve: an order in which neighbours on the page are mostly neighbours in the list."""

from __future__ import annotations

import numpy as np

from crowquill.kernel import compiled
from crowquill.paths import Array, Index

SIDE = 4096  # squares to a side when points are ordered


def of_grid(h: int, w: int) -> Index:
    """The pixels of an (h, w) picture, as indices into its flat form, in the order of the curve."""
    row, column = np.divmod(np.arange(h * w), w)
    return np.argsort(_keys(row, column, 1 << max(1, max(h, w) - 1).bit_length()), kind="stable")


def of_points(xy: Array) -> Index:
    """The points (n, 2) in the order of the curve over their box; points of one square stay in their order."""
    if not len(xy):
        return np.zeros(0, np.int64)
    low = xy.min(axis=0)
    span = max(float(np.ptp(xy, axis=0).max()), np.finfo(float).tiny)
    column, row = np.minimum((xy - low) / span * SIDE, SIDE - 1).astype(np.int64).T
    return np.argsort(_keys(row, column, SIDE), kind="stable")


def _keys(row: Index, column: Index, side: int) -> Index:
    """The place of each square along the curve over side by side squares; side is a power of two."""
    key = np.empty(len(row), np.int64)
    _fill(row, column, side, key)
    return key


@compiled
def _fill(row: Index, column: Index, side: int, key: Index) -> None:
    for k in range(len(key)):
        x, y, d, s = column[k], row[k], 0, side // 2
        while s > 0:
            right, below = 1 if x & s else 0, 1 if y & s else 0
            d += s * s * ((3 * right) ^ below)
            x, y = x & (s - 1), y & (s - 1)
            if not below:
                if right:
                    x, y = s - 1 - x, s - 1 - y
                x, y = y, x
            s //= 2
        key[k] = d
