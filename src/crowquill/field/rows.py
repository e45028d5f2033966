"""Rows: lines at even distances from others, along which dots and tiles are laid."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.field.reach import Distances
from crowquill.paths import Array, Paths


@dataclass(frozen=True, eq=False)
class Rows:
    """The lines that lie `first` mm and any number of times `pitch` mm more from what distances are taken from."""

    far: Distances
    pitch: float
    first: float = 0.0

    def off(self, xy: npt.ArrayLike) -> Array:
        """How far points (n, 2) are from the nearest row, mm, (n,)."""
        return self._off(self.far.at(xy))

    def share(self, width: float) -> Array:
        """The share of each square that rows of this width cover, (h, w), their borders a square wide."""
        h, w = self.far.mm.shape
        square = np.sqrt(self.far.size[0] * self.far.size[1] / (h * w))
        return np.asarray(np.clip((width / 2 - self._off(self.far.mm)) / square + 0.5, 0, 1))

    def lines(self, most: float = np.inf) -> Paths:
        """The rows nearer than `most` mm as open lines, the nearest first; those that close end where they begin."""
        from contourpy import contour_generator

        (h, w), (width, height) = self.far.mm.shape, self.far.size
        x, y = (np.arange(w) + 0.5) * width / w, (np.arange(h) + 0.5) * height / h
        contours: Any = contour_generator(x=x, y=y, z=self.far.mm)
        levels = np.arange(self.first, min(most, float(self.far.mm.max())), self.pitch)
        return Paths.of([line for level in levels for line in contours.lines(level)], closed=False)

    def _off(self, mm: Array) -> Array:
        turn = np.maximum((mm - self.first) / self.pitch, 0)
        return np.asarray(np.abs(mm - self.first - self.pitch * np.round(turn)))


def weighed(several: Sequence[tuple[Distances, float]]) -> Distances:
    """How far each square is from the source that counts there: the one whose distance over its weight is least.

    Where a source counts, distances are its own, so that rows lie as far apart around a light one as around a heavy one.
    """
    mm = np.stack([far.mm for far, _ in several])
    nearest = np.argmin(mm / np.array([weight for _, weight in several])[:, None, None], axis=0)
    return Distances(np.take_along_axis(mm, nearest[None], axis=0)[0], several[0][0].size)
