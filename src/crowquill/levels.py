"""Levels: the pixels of a tone as numbers, or as codes into a table of numbers, and their sums along rows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.kernel import compiled, shared_out
from crowquill.paths import Array, fixed, frozen

BLOCK = 64  # columns to a block of sums along rows; see sums()
LARGE = 64_000_000  # pixels from which on pictures are kept as codes, and their sums made a band of rows at a time
BAND = 1 << 21  # pixels at a time, where all would take memory
DEPTH = 65535  # codes of numbers that have none of their own
ROWS = 16  # that are worth a thread of their own


@dataclass(frozen=True, eq=False)
class Levels:
    """A number for each pixel, (h, w): the numbers themselves, or codes of 8 or 16 bits into a table of them.

    codes  (h, w) float64 without a table; uint8 or uint16 with one, all below its length
    table  (k,) the number that each code stands for
    """

    codes: npt.NDArray[Any]
    table: Array | None = None

    def __post_init__(self) -> None:
        self.codes.setflags(write=False)

    @classmethod
    def of(cls, values: npt.ArrayLike | Levels, name: str = "coverage") -> Levels:
        """Levels as they are, or those of a copy of an array. Raises ValueError for what does not lie within 0 to 1."""
        found = values if isinstance(values, Levels) else cls(frozen(values, np.float64, (None, None), name))
        found.check(name)
        return found

    @classmethod
    def filled(cls, shape: tuple[int, int], rows: Callable[[int, int], Array]) -> Levels:
        """Levels of this shape whose rows(top, bottom) are asked for by all cores: numbers, or from LARGE pixels on codes of 16 bits."""
        coded = shape[0] * shape[1] >= LARGE
        codes = np.empty(shape, np.uint16 if coded else np.float64)
        every = list(bands(shape))

        def fill(lo: int, hi: int) -> None:
            for top, bottom in every[lo:hi]:
                part = rows(top, bottom)
                codes[top:bottom] = np.rint(part * DEPTH) if coded else part

        shared_out(fill, len(every), 1)
        return cls(codes, np.arange(DEPTH + 1) / DEPTH if coded else None)

    def check(self, name: str) -> None:
        """Raises ValueError where there is none, or one outside 0 to 1."""
        if self.codes.size == 0:
            raise ValueError(f"{name} has no pixels; it takes at least one")
        some = self._met
        if not 0 <= some.min() <= some.max() <= 1:
            raise ValueError(f"{name} runs from {some.min():g} to {some.max():g}; it takes 0 to 1")

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.codes.shape[0], self.codes.shape[1]

    @cached_property
    def counts(self) -> npt.NDArray[np.int64]:
        """How many pixels have each code of the table, (k,)."""
        found = np.zeros(0 if self.table is None else len(self.table), np.int64)
        for top, bottom in bands(self.shape):
            found += np.bincount(self.codes[top:bottom].ravel(), minlength=len(found))
        return found

    @property
    def _met(self) -> Array:
        """All numbers, each once where there are codes."""
        return self.codes if self.table is None else self.table[np.flatnonzero(self.counts)]

    @property
    def most(self) -> float:
        """The greatest number."""
        return float(self._met.max())

    def where(self, test: Callable[[Array], npt.NDArray[np.bool_]]) -> npt.NDArray[np.bool_]:
        """Which pixels, (h, w), have numbers that pass a test: it takes and gives an array, and treats each number by itself."""
        if self.table is None:
            return test(self.codes)
        passed = test(self.table)
        found = np.empty(self.shape, bool)
        for top, bottom in bands(self.shape):
            found[top:bottom] = passed[self.codes[top:bottom]]
        return found

    def rows(self, top: int, bottom: int) -> Array:
        """The numbers of these rows, (bottom - top, w)."""
        codes = self.codes[top:bottom]
        return codes if self.table is None else self.table[codes]

    def whole(self) -> Array:
        """All numbers, (h, w): the array that is kept, or a new one of 8 bytes a pixel."""
        return self.rows(0, len(self.codes))

    def at(self, row: npt.NDArray[np.int64], column: npt.NDArray[np.int64]) -> Array:
        """The numbers of these pixels, (n,)."""
        codes = self.codes[row, column]
        return np.asarray(codes if self.table is None else self.table[codes])

    def cut(self, rows: slice, columns: slice) -> Levels:
        """These rows and columns; the same memory where that is in one piece, or where there are codes."""
        part = self.codes[rows, columns]
        if part.shape == self.shape:
            return self
        return Levels(np.ascontiguousarray(part) if self.table is None else part, self.table)

    def mapped(self, curve: Callable[[Array], Array]) -> Levels:
        """curve(number) for each number; the curve takes and gives an array, and treats each number by itself."""
        if self.table is not None:
            changed = Levels(self.codes, frozen(curve(self.table), np.float64, self.table.shape, "the curve"))
            vars(changed)["counts"] = self.counts
            return changed
        return Levels(frozen(fixed(curve(self.codes)), np.float64, self.codes.shape, "the curve"))

    def percentiles(self, shares: tuple[float, ...]) -> Array:
        """What these shares of 100 of all numbers lie below, as np.percentile has it."""
        if self.table is None:
            return np.asarray(np.percentile(self.codes, shares))
        order = np.argsort(self.table, kind="stable")
        upto = np.cumsum(self.counts[order])
        place = (upto[-1] - 1) * (np.array(shares) / 100)
        low = np.floor(place)
        below, above = (self.table[order[np.searchsorted(upto, np.minimum(at, upto[-1] - 1), side="right")]] for at in (low, low + 1))
        part = place - low
        found: Array = np.where(part < 0.5, below + (above - below) * part, above - (above - below) * (1 - part))
        return found

    def spread(self) -> Levels:
        """The same as numbers, where there are fewer than LARGE: had many times, codes take longer."""
        return self if self.table is None or self.codes.size >= LARGE else Levels(self.whole())

    def sum(self) -> float:
        """The sum of all numbers."""
        return float(self.codes.sum() if self.table is None else (self.table * self.counts).sum())

    def sums(self, top: int, bottom: int) -> Array:
        """(bottom - top, w, 4): for each pixel of these rows the sums of its number times 1, x, x^2 over those before it, and itself.

        The sums run within a block of 64 columns and x counts pixels from the block's left
        edge: over whole rows the second sums grow to 1e10 and leave a cell's covariance no digits.
        """
        bottom = min(bottom, len(self.codes))
        made = np.empty((max(0, bottom - top), self.codes.shape[1], 4))
        i = np.arange(BLOCK)
        powers = np.stack([((i + 1.0) ** (p + 1) - i ** float(p + 1)) / (p + 1) for p in range(3)])

        def fill(lo: int, hi: int) -> None:
            for row in range(lo, hi, ROWS):  # so few that they are still at hand when they are summed
                part = made[row : min(row + ROWS, hi)]
                part[:, :, 3] = self.rows(top + row, top + row + len(part))
                _summed(part, powers)

        shared_out(fill, len(made), ROWS)
        return made


def bands(shape: tuple[int, int], pixels: int | None = None) -> Iterator[tuple[int, int]]:
    """The first row, and the one past the last, of the bands that rows of this shape are had in: of so many pixels, else BAND, or a row."""
    rows = max(1, (pixels or BAND) // max(1, shape[1]))
    return ((top, min(top + rows, shape[0])) for top in range(0, shape[0], rows))


@compiled
def _summed(made: Array, powers: Array) -> None:
    """Fills the first three of (h, w, 4) with the running sums of the fourth times powers (3, BLOCK), block by block."""
    rows, columns = made.shape[0], made.shape[1]
    for row in range(rows):
        for left in range(0, columns, BLOCK):
            s0 = s1 = s2 = 0.0
            for k in range(min(BLOCK, columns - left)):
                at = made[row, left + k]
                at[0], at[1], at[2] = s0, s1, s2
                s0, s1, s2 = s0 + at[3] * powers[0, k], s1 + at[3] * powers[1, k], s2 + at[3] * powers[2, k]
