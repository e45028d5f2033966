"""The Hilbert curve: an order in which neighbours on the page are mostly neighbours in the list."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.kernel import compiled
from crowquill.levels import Levels
from crowquill.paths import Array, Index

BLOCK = 64  # squares to a side of what is gone along at once
SIDE = 4096  # squares to a side when points are ordered


def passed(levels: Levels, shares: Array, split: int = 1) -> Index:
    """Pixels (n, 2), column and row, in which sums of their numbers along the curve pass these shares (n,) of the whole, which rise.

    split  each pixel is so many by so many of the same number

    Where all numbers are 0 it is the first pixel. Takes no memory for the pixels: the curve is gone along twice, block by block.
    """
    h, w = levels.shape[0] * split, levels.shape[1] * split
    side = 1 << max(1, max(h, w) - 1).bit_length()
    places, table = _blocks(h, w, side), np.zeros(1) if levels.table is None else levels.table
    along, found = _orders(min(side, BLOCK)), np.zeros((len(shares), 2), np.int64)

    def gone(at: Array) -> float:
        return float(_gone(levels.codes, table, levels.table is not None, split, places, along, at, found))

    total = gone(np.zeros(0))
    gone(np.minimum(shares * total, np.nextafter(total, 0)))
    return found


def _blocks(h: int, w: int, side: int) -> Index:
    """Squares of BLOCK, or of the side, that touch an (h, w) grid, in the curve's order: (m, 4) column, row, swapped, turned.

    The curve in each is that of a square of its own, columns and rows swapped, then turned by half a turn.
    """
    found = np.zeros((1, 4), np.int64)
    quarter = np.array([(0, 0), (0, 1), (1, 1), (1, 0)])  # right and below, in the curve's order
    while side > BLOCK:
        side //= 2
        column, row, swapped, turned = (np.repeat(part, 4) for part in found.T)
        right, below = np.tile(quarter, (len(found), 1)).T
        x, y = np.where(swapped, below, right) ^ turned, np.where(swapped, right, below) ^ turned
        found = np.stack([column + side * x, row + side * y, swapped ^ (1 - below), turned ^ (right & (1 - below))], axis=1)
        found = found[(found[:, 0] < w) & (found[:, 1] < h)]
    return found


def _orders(side: int) -> Index:
    """The squares of a block in the order of the curve, column and row, (2, 2, side * side, 2): swapped or not, turned or not."""
    row, column = np.divmod(np.arange(side * side), side)
    order = np.argsort(_keys(row, column, side))
    plain = np.stack([column[order], row[order]], axis=1)
    both = np.stack([plain, plain[:, ::-1]])
    return np.stack([both, side - 1 - both], axis=1)


@compiled
def _gone(codes: npt.NDArray[Any], table: Array, coded: bool, split: int, blocks: Index, along: Index, at: Array, found: Index) -> float:
    """The sum of all numbers along the curve; the pixel where it passes each number of `at` is put into `found`."""
    h, w, total, n = codes.shape[0] * split, codes.shape[1] * split, 0.0, 0
    for block in range(len(blocks)):
        left, top, swapped, turned = blocks[block]
        steps = along[swapped, turned]
        for k in range(len(steps)):
            column, row = left + steps[k, 0], top + steps[k, 1]
            if column >= w or row >= h:
                continue
            code = codes[row, column] if split == 1 else codes[row // split, column // split]
            total += table[int(code)] if coded else float(code)
            while n < len(at) and total > at[n]:
                found[n, 0], found[n, 1] = column, row
                n += 1
    return total


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
