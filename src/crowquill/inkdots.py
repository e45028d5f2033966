"""Scanned dots on the black pixels of a halftone: which lies where, and what tones they give together.

Source: D. Martin, G. Arroyo, M. V. Luzon, T. Isenberg, Scale-dependent and example-based grayscale stippling,
Computers & Graphics 35(1), 2011.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from crowquill import glyphs, raster
from crowquill.greydots import RIM, overlaid, scanned
from crowquill.halftone import halftoned
from crowquill.marks import Glyph, Marks
from crowquill.paths import Array, Index, Paths

PIXEL = 25.4 / 300  # mm: the published sizes are pixels of 300 to the inch
PITCH = 3 * PIXEL  # from candidate to candidate: half the side of a dot's box
JITTER = 1.5 * PIXEL  # each way
SIZES = (0.25, 0.3, 0.35)  # mm: nibs whose ink is that of the published scans with boxes of 4 to 7 pixels
# denser about a half, where dots on a chequerboard overlap least
TONES = np.array([0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.45, 0.48, 0.5, 0.52, 0.55, 0.6, 0.7, 0.8, 0.9, 1.0])
PIXELS = 8  # to a dot's mean diameter, in which scans are cut
SPARSE = 0.3  # of the paper under all candidates: below, rims hardly meet, and cut scans are as dark as outlines
CELLS = 64  # a side of the flat patches measured: 4096 candidates, of whose tone chance moves half a percent


WIDEST = 20  # pitches: dots lie hundreds deep
FAR = 4  # pitches: dots moved further lie no more at random


@dataclass(frozen=True, eq=False)
class Dots:
    """Dots to draw with, by size: the glyphs, scale (n,) mm of each, and start (s + 1,) of each size class among them."""

    glyphs: tuple[Glyph, ...]
    scale: Array
    start: Index

    @classmethod
    def of(cls, library: str | None = None, sizes: Sequence[float] | None = None) -> Dots:
        """Dots of a library, by its name or an SVG file, or of the nib nearest to each size; scans go with them.

        sizes  mm, the mean diameter to which a class is scaled; left out, SIZES of nibs, which are then as large as they were, and
               one class of a library of one's own, each dot as large as it was
        """
        return _nibs(tuple(sizes or ())) if library is None else _gathered([(library, size) for size in sizes or (0.0,)])

    @property
    def mean(self) -> float:
        """The diameter of a dot of the mean area, mm."""
        classes = [float((self.scale[lo:hi] ** 2).mean()) for lo, hi in zip(self.start, self.start[1:], strict=False)]
        return 2 * float(np.sqrt(np.mean(classes) / np.pi))

    def at(self, centres: Array, jitter: float, rng: np.random.Generator) -> Marks:
        """A dot near each centre (n, 2) mm: its size, its scan, its turn and where it lies up to `jitter` mm off each way by chance."""
        n = len(centres)
        size = rng.integers(len(self.start) - 1, size=n)
        glyph = self.start[size] + (rng.random(n) * np.diff(self.start)[size]).astype(np.int64)
        xy = centres + rng.uniform(-jitter, jitter, (n, 2))
        return Marks.of(xy, self.glyphs, scale=self.scale[glyph], angle=rng.uniform(0, 2 * np.pi, n), glyph=glyph)


def _gathered(kinds: Sequence[tuple[str, float]]) -> Dots:
    """Dots of a class for each library and mean diameter, which is 0 where its dots are as large as they were."""
    found: list[Glyph] = []
    scale, start = [np.empty(0)], [0]
    for name, size in kinds:
        every = glyphs.load(name, grey=True).glyphs
        own = np.array([glyph.size for glyph in every])
        found += every
        scale.append(own * np.sqrt(np.pi) / 2 * (size / own.mean() if size else 1.0))
        start.append(len(found))
    return Dots(tuple(found), np.concatenate(scale), np.array(start))


@lru_cache(8)
def _nibs(sizes: tuple[float, ...]) -> Dots:
    """The nibs that come with the package, which do not change."""
    return _gathered([(glyphs.nearest(size), size if sizes else 0.0) for size in sizes or SIZES])


@dataclass(frozen=True, eq=False)
class Reached:
    """What tones dots give, of each of TONES asked for, rising: black and, where they have scans, grey.

    Black ones that have scans are the mean of outlines filled and of scans cut where a single dot has the same area: where dots
    meet their rims add up to black, so that at the darkest a twentieth of the paper parts these two.
    """

    black: Array
    grey: Array | None

    def of(self, form: str) -> Array:
        """The tones of a form, "black" or "grey"; without scans those of black dots."""
        return self.black if form == "black" or self.grey is None else self.grey

    def asked(self, coverage: Array, form: str) -> Array:
        """What to ask for so that a form of the dots gives this coverage; 1 where that is out of reach."""
        return np.asarray(np.interp(coverage, self.of(form), TONES))


def flat(dots: Dots, tone: float, pitch: float, jitter: float, rng: np.random.Generator, cells: int = CELLS) -> Marks:
    """Marks that give one tone to a square of so many candidates a side, from (0, 0) on; others lie around it, as in a picture."""
    over = int(np.ceil((2 * dots.scale.max() + jitter) / pitch)) + 1
    black = halftoned(np.full((cells + 2 * over, cells + 2 * over), tone), rng=rng)
    centres = np.asarray((np.argwhere(black)[:, ::-1] - over + 0.5) * pitch, np.float64)
    return dots.at(centres, jitter, rng)


@lru_cache(8)
def measured(dots: Dots, pitch: float, jitter: float) -> Reached:
    """The tones that dots give at this pitch of candidates, by drawing flat patches, always the same, and measuring them.

    Where a pitch is so wide that dots cannot meet, they are measured closer together. Raises ValueError for dots WIDEST pitches wide.
    """
    widest = float(dots.scale.max())
    if widest > WIDEST * pitch:
        raise ValueError(f"dots of {widest:.3g} mm are over {WIDEST} pitches of {pitch:.3g} mm wide; use a wider pitch, or smaller sizes")
    rng = np.random.default_rng(0)
    jitter = min(jitter, FAR * pitch)
    near = min(pitch, 3 * widest + 2 * jitter)
    lines = int(np.ceil(16 * near / dots.mean))
    sparse = np.pi / 4 * (dots.mean / near) ** 2 < SPARSE
    fine = 1 if sparse else int(np.ceil(PIXELS * near / dots.mean))  # pixels to a candidate
    grid, pixel = (CELLS * fine,) * 2, (near / fine,) * 2
    black, grey = np.zeros(len(TONES)), np.zeros(len(TONES))
    for k, tone in enumerate(TONES):
        marks = flat(dots, tone, near, jitter, rng)
        black[k] = raster.covered(marks, (CELLS, CELLS), pixel=(near, near), lines=lines).mean()
        if scanned(marks):
            taken = overlaid(marks, grid, pixel=pixel)
            grey[k] = taken.mean()
            black[k] = black[k] if sparse else (black[k] + (taken >= RIM).mean()) / 2
    rising = [np.maximum.accumulate(tones) * (near / pitch) ** 2 + 1e-9 * np.arange(len(TONES)) for tones in (black, grey)]
    return Reached(rising[0], rising[1] if grey.any() else None)


def rows_along(lines: Paths, pitch: float) -> Array:
    """Points (n, 2) along open lines, as near to `pitch` mm apart as goes into each; the first begins it, the last ends it."""
    found = [np.empty((0, 2))]
    for line in lines:
        far = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
        at = np.linspace(0, far[-1], max(1, round(far[-1] / pitch)) + 1)
        found.append(np.stack([np.interp(at, far, line[:, 0]), np.interp(at, far, line[:, 1])], axis=1))
    return np.concatenate(found)
