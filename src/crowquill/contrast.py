"""Contrast-aware dots in millimetres: on what pixels, how many, and how large they must be for the tone to be kept."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from crowquill import glyphs, measure
from crowquill.grid import Grid
from crowquill.halftone.averages import averaged
from crowquill.halftone.contrast import Diffusing
from crowquill.marks import Marks
from crowquill.paths import Array
from crowquill.sheet import Step
from crowquill.stippling import CAP, cut_white
from crowquill.tone import Tone

JITTER = 0.3  # of a pixel, each way: hides the grid
# of flat patches; lights and darks change most
TONES = np.array([0.02, 0.04, 0.07, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, CAP])
MIDDLE = 0.5
SIDE, EDGE = 56, 8  # pixels of a patch whose ink counts, and to either side of it of the same tone
AREAS, HALVINGS = (0.2, 60.0), 9  # pixels between which the area of a dot is sought, to a hundredth
MOST = 12_000_000  # pixels: two thirds of a gigabyte
ROUNDS, NEAR = 24, 0.01  # of a search for a number of dots: how many, and what error ends it; thousands take two or three
EASED = 4  # rounds, from which on steps are shorter: chance moves small numbers by percents, and whole steps would go in a ring
Bits = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Flat:
    """Of flat tones, each of TONES: share (n,) of pixels that are dots, and area (n,) of a dot in pixels that keeps the tone.

    In lights of which the diffusion leaves too few dots they are no larger than in the mid-tones, and tone is lost.
    """

    share: Array
    area: Array

    def areas(self, coverage: Array) -> Array:
        """The area of a dot on a pixel of each coverage, in pixels."""
        return np.asarray(np.interp(coverage, TONES, self.area))

    def shares(self, coverage: Array) -> Array:
        """The share of pixels that are dots where coverage is as given all around."""
        return np.asarray(np.interp(coverage, np.concatenate([[0.0], TONES]), np.concatenate([[0.0], self.share])))


@lru_cache(64)
def flat(rule: Diffusing, jitter: float = JITTER) -> Flat:
    """What a rule makes of flat tones, by drawing a patch of each, always the same, and measuring the union of its dots."""
    disc = glyphs.load("disc").glyphs
    share, area = np.zeros(len(TONES)), np.ones(len(TONES))
    whole = SIDE + 2 * EDGE
    for n, tone in enumerate(TONES):
        rng = np.random.default_rng(n)
        black = rule.black(np.full((whole, whole), tone), rng)
        share[n] = black[EDGE:-EDGE, EDGE:-EDGE].mean()
        places = np.argwhere(black)[:, ::-1] + 0.5 - EDGE
        places = places + rng.uniform(-jitter, jitter, places.shape)
        low, high = AREAS
        for _ in range(HALVINGS if share[n] else 0):
            area[n] = np.sqrt(low * high)
            marks = Marks.of(places, disc, scale=float(np.sqrt(area[n])))
            if measure.rendered(marks, (SIDE, SIDE), (4, 4), pitch=0.1).mean() < tone:
                low = area[n]
            else:
                high = area[n]
    light = TONES <= MIDDLE
    area[light] = np.minimum.accumulate(area[light][::-1])[::-1]
    return Flat(share, area)


@dataclass(frozen=True, eq=False)
class Texture:
    """A picture (h, w) of any range, high where it is dark, that shows in tones: a tile `width` mm wide, or once over all, and how much."""

    dark: Array
    width: float | None
    strength: float

    def on(self, coverage: Array, grid: Grid) -> Array:
        """Coverage (rows, columns) of a grid with the texture.

        Each cell moves towards black or white by the rank of its texture, at strength 1 so far that mid-tones show all of
        it, and the less the nearer it is to either end: white stays white, black black, and the mean over the texture is the tone.
        """
        from scipy.stats import rankdata

        (h, w), (width, height) = self.dark.shape, grid.tone.size
        wide = max(width, height * w / h) if self.width is None else self.width
        sides = wide * h / w, wide
        places = [(np.arange(n) + 0.5) * grid.cell / side % 1 for n, side in zip((grid.rows, grid.columns), sides, strict=True)]
        counts = [max(1, round(side / grid.cell)) for side in sides]  # cells to a tile, of which the grid may show a part
        ends = [np.arange(min(n, len(place)) + 1) / n for n, place in zip(counts, places, strict=True)]
        tile = averaged(self.dark, ends[1] * w, ends[0] * h)
        rank = (rankdata(tile, axis=None).reshape(tile.shape) - 0.5) / tile.size
        row, column = (np.minimum((place * n).astype(np.int64), len(end) - 2) for place, n, end in zip(places, counts, ends, strict=True))
        return np.asarray(coverage + self.strength * (2 * rank[np.ix_(row, column)] - 1) * np.minimum(coverage, 1 - coverage))


@dataclass(frozen=True, eq=False)
class Wanted:
    """What dots of one ink are to draw: a tone of their own, below what coverage none may lie, and a texture."""

    tone: Tone
    white: float
    texture: Texture | None
    seed: int

    @cached_property
    def asked(self) -> Tone:
        """The tone without what is on white."""
        return cut_white(self.tone, self.white)[0]

    @cached_property
    def ink(self) -> float:
        """mm^2 asked of this ink, that on white not counted."""
        return self.asked.ink

    def expected(self, rule: Diffusing) -> tuple[float, float]:
        """About how many dots there are to a pitch of 1 mm, and the sum of their areas in pixels, as if all were flat."""
        mean, tones = flat(rule), np.minimum(self.asked.coverage, CAP)
        dots = mean.shares(tones) * self.asked.inside * self.tone.pixel[0] * self.tone.pixel[1]
        return float(dots.sum()), float((dots * mean.areas(tones)).sum())


@dataclass(frozen=True, eq=False)
class Set:
    """Dots of one ink on a grid: black (rows, columns) where they are, and the coverage (rows, columns) that they are to give."""

    grid: Grid
    coverage: Array
    black: Bits

    @property
    def at(self) -> tuple[Array, Array]:
        """The middles (n, 2) mm of the dots' pixels, and the coverage (n,) of each."""
        row, column = np.nonzero(self.black)
        return self.grid.centres(row, column), self.coverage[row, column]


@dataclass(frozen=True, eq=False)
class Found:
    """What a search came to: the dots of each ink, the pitch of their pixels in mm, the rule, and how many diffusions it took."""

    sets: tuple[Set, ...]
    pitch: float
    rule: Diffusing
    rounds: int = 1

    @property
    def count(self) -> int:
        """The number of dots of all inks."""
        return sum(int(part.black.sum()) for part in self.sets)


def diffused(wanted: tuple[Wanted, ...], pitch: float, rule: Diffusing) -> Found:
    """The dots of each ink on pixels of this pitch in mm. Raises ValueError for more than MOST of them."""
    width, height = wanted[0].tone.size
    if width * height / pitch**2 > 1.01 * MOST:
        raise ValueError(
            f"pixels of {pitch:.3g} mm are {width * height / pitch**2 / 1e6:.0f} million on this picture, over the limit of "
            f"{MOST // 1_000_000}; draw it smaller, or use a wider pen"
        )
    sets = []
    for part in wanted:
        grid = Grid.of(part.tone, pitch)
        mean, held = grid.whole()
        held &= (mean >= part.white) & (mean > 0)
        coverage = np.minimum(mean.astype(np.float64), CAP)
        coverage = coverage if part.texture is None else part.texture.on(coverage, grid)
        sets.append(Set(grid, coverage, rule.black(coverage, np.random.default_rng(part.seed), held)))
    return Found(tuple(sets), pitch, rule)


def by_pitch(wanted: tuple[Wanted, ...], dots: int, pitch: float, rule: Diffusing) -> Generator[Step, None, Found]:
    """Steps of a search over the pitch for a number of dots, from a guess; the nearest that was found.

    The number goes nearly as one over the pitch squared. No pitch is finer than MOST pixels, none wider than half the canvas.
    """
    width, height = wanted[0].tone.size
    finest, widest = float(np.sqrt(width * height / MOST)), wanted[0].tone.across / 2
    best = None
    for turn in range(ROUNDS):
        pitch = float(np.clip(pitch, finest, max(finest, widest)))
        found = diffused(wanted, pitch, rule)
        best = found if best is None or abs(found.count - dots) < abs(best.count - dots) else best
        yield Step("diffuse", turn + 1, ROUNDS, {"dots": found.count})
        if abs(best.count - dots) <= NEAR * dots or (pitch == finest and found.count < dots) or (pitch == widest and found.count > dots):
            break
        pitch *= float(np.clip((found.count / dots) ** (0.5 if turn < EASED else 0.3), 0.5, 2.0))
    assert best is not None
    return replace(best, rounds=turn + 1)
