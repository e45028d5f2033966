"""What is learned of a hand from a drawing, as plain data: Level, Tile, Hand, Style."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from crowquill.marks import Glyph
from crowquill.paths import Array, Index, frozen


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
    threshold  (n,) rising coverage, what all marks before it cover together
    tones      (t,) rising coverages, t > 0
    xy         (t, n, 2) mm, where each mark lies in each of them; one that comes later is where it will come
    """

    side: float
    threshold: Array
    tones: Array
    xy: Array

    def __post_init__(self) -> None:
        if not 0 < self.side < np.inf:
            raise ValueError(f"side is {self.side} mm; it takes a length over 0")
        object.__setattr__(self, "threshold", frozen(self.threshold, np.float64, (None,), "threshold"))
        object.__setattr__(self, "tones", frozen(self.tones, np.float64, (None,), "tones"))
        object.__setattr__(self, "xy", frozen(self.xy, np.float64, (len(self.tones), len(self.threshold), 2), "xy"))

    @property
    def stray(self) -> float:
        """How far any mark is ever from where it lies in the darkest tone, mm."""
        return float(np.hypot(*(self.xy - self.xy[-1]).T).max(initial=0.0))

    def laid(self, mirrored: bool, turned: bool, shift: Array) -> Tile:
        """The tile seen in a mirror or turned over, and moved by shares of its side, (2,): in its darkest tone all marks lie in it."""
        xy = self.xy[..., ::-1] if turned else self.xy
        xy = xy * (-1 if mirrored else 1, 1) + shift * self.side
        return replace(self, xy=xy - np.floor(xy[-1] / self.side) * self.side)

    def at(self, which: Index, coverage: Array) -> Array:
        """Where some marks (k,) lie, each in a tone of its own (k,): (k, 2) mm, on the straight way between two tones."""
        low = np.clip(np.searchsorted(self.tones, coverage, side="right") - 1, 0, len(self.tones) - 1)
        high = np.minimum(low + 1, len(self.tones) - 1)
        share = np.clip((coverage - self.tones[low]) / np.where(high > low, self.tones[high] - self.tones[low], 1.0), 0, 1)
        one, other = self.xy[low, which], self.xy[high, which]
        return np.asarray(one + share[:, None] * (other - one))

    def of(self, coverage: float) -> Array:
        """The marks of a flat tone, (k, 2) mm."""
        which = np.arange(np.searchsorted(self.threshold, coverage))
        return self.at(which, np.full(len(which), coverage))


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
    turnover  coverages between which black marks give way to white ones on black, about half way from the darkest tone seen of
              the ones to the lightest of the others; both 1 without white ones
    notes     what is to be said of the example
    """

    name: str
    dpi: float
    sha256: str
    black: Hand
    white: Hand | None = None
    turnover: tuple[float, float] = (1.0, 1.0)
    notes: tuple[str, ...] = ()
