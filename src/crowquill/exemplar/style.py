"""What is learned of a hand from a drawing, as plain data: Level, Tile, Hand, Style."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crowquill.marks import Glyph
from crowquill.paths import Array, frozen


@dataclass(frozen=True, eq=False)
class Level:
    """One tone of an example: the share of the ground that marks cover, and how their texture repeats.

    lags         (m,) mm, rising from 0 to four mean spacings, in even steps
    correlation  (m,) of the picture of marks with itself that far off in any direction, 1 at no distance
    """

    coverage: float
    lags: Array
    correlation: Array

    def __post_init__(self) -> None:
        if not 0 < self.coverage < 1:
            raise ValueError(f"coverage is {self.coverage}; it takes a share over 0, under 1")
        object.__setattr__(self, "lags", frozen(self.lags, np.float64, (None,), "lags"))
        object.__setattr__(self, "correlation", frozen(self.correlation, np.float64, self.lags.shape, "correlation"))


@dataclass(frozen=True, eq=False)
class Tile:
    """A square of marks that goes on at its opposite side, for all tones at once: a mark is drawn where more is asked than its threshold.

    side       mm
    xy         (n, 2) mm
    threshold  (n,) rising coverage, what all marks before it cover together
    """

    side: float
    xy: Array
    threshold: Array

    def __post_init__(self) -> None:
        if not 0 < self.side < np.inf:
            raise ValueError(f"side is {self.side} mm; it takes a length over 0")
        object.__setattr__(self, "xy", frozen(self.xy, np.float64, (None, 2), "xy"))
        object.__setattr__(self, "threshold", frozen(self.threshold, np.float64, (len(self.xy),), "threshold"))

    def of(self, coverage: float) -> Array:
        """The marks of a flat tone, (k, 2) mm."""
        return self.xy[self.threshold < coverage]


@dataclass(frozen=True, eq=False)
class Hand:
    """Marks of one ink: their shapes at true size, the tones they were seen in from light use to heavy, and a tile like these."""

    glyphs: tuple[Glyph, ...]
    levels: tuple[Level, ...]
    tile: Tile | None = None

    @property
    def area(self) -> float:
        """The mean area of a mark, mm^2."""
        return float(np.mean([np.pi / 4 * glyph.size**2 for glyph in self.glyphs]))


@dataclass(frozen=True, eq=False)
class Style:
    """A hand's black marks, and its white ones in the darks where the example has any.

    name      of the example
    dpi       of the scan
    sha256    of the example's file, "" for an array
    turnover  coverages between which black marks give way to white ones on black: the darkest tone seen of the ones, the
              lightest of the others; both 1 without white ones
    notes     what is to be said of the example
    """

    name: str
    dpi: float
    sha256: str
    black: Hand
    white: Hand | None = None
    turnover: tuple[float, float] = (1.0, 1.0)
    notes: tuple[str, ...] = ()
