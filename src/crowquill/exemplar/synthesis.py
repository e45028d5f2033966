"""A tile of marks whose texture, tone by tone, is that of an example.

Marks are added from the lightest tone to the darkest, so that a mark of a light tone is there in all darker ones. They are
arranged so that pairs of marks give what the example's correlation asks for. Where new marks alone cannot give it, older ones
slide: dots that keep apart in each of two tones cannot all keep their places. What overlap hides is made up for in rounds:
the tile is drawn, and its own correlation corrects what is asked for.

Source: S. Kim, R. Maciejewski, T. Isenberg, W. M. Andrews, W. Chen, M. C. Sousa, D. S. Ebert, Stippling by Example, NPAR 2009.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from crowquill import measure
from crowquill.exemplar.arranging import LIGHT, Goal, arranged
from crowquill.exemplar.correlation import radial
from crowquill.exemplar.style import Hand, Level, Tile
from crowquill.marks import Marks
from crowquill.paths import Array
from crowquill.sheet import Step

ROUNDS = 5  # of drawing a tone and correcting what is asked for
MET = 0.01  # rms by which the correlation of the tile drawn may be missed
RIGHT = 0.005  # of its coverage by which a tone may be missed
SQUARE = 6.0  # mean spacings: the side of squares that have equal numbers of marks, and that none leaves
PIXELS = 7  # to a mark's diameter, where a tile is drawn
FINE = 0.06  # of coverage: tones between are measured no further apart
LEAST = 12  # diameters to the side of a tile
LEAP = 1e-6  # of coverage, at least, from tone to tone


@dataclass
class _Marks:
    """Marks under way on a torus of a side in mm; `mean` is the mean area, of discs of this diameter."""

    xy: Array
    side: float
    hand: Hand

    @property
    def diameter(self) -> float:
        return 2 * float(np.sqrt(self.hand.area / np.pi))

    def drawn(self, count: int) -> npt.NDArray[np.bool_]:
        """The first so many marks as pixels of ink, each shape of the bank in turn."""
        glyphs = self.hand.glyphs
        edge = 2 * max(glyph.size for glyph in glyphs)
        which = np.arange(count)
        own = self.xy[:count]
        parts, glyph = [own], [which]
        for axis in (0, 1):
            xy, index = np.concatenate(parts), np.concatenate(glyph)
            for shift, near in ((self.side, xy[:, axis] < edge), (-self.side, xy[:, axis] > self.side - edge)):
                offset = np.zeros(2)
                offset[axis] = shift
                parts.append(xy[near] + offset)
                glyph.append(index[near])
        index = np.concatenate(glyph)
        kind = index % len(glyphs)
        scale = np.array([shape.size for shape in glyphs])[kind] * np.sqrt(np.pi) / 2
        marks = Marks.of(np.concatenate(parts), glyphs, scale=scale, angle=index * 2.399963, glyph=kind)
        pixels = int(np.ceil(self.side / self.diameter * PIXELS))
        return np.asarray(measure.rendered(marks, (self.side, self.side), (pixels, pixels), pitch=self.diameter / PIXELS / 4) >= 0.5)


def tiled(hand: Hand, top: float, count: int, rng: np.random.Generator, stage: str) -> Generator[Step, None, Hand]:
    """A Step of a stage for each tone, and returns the hand with a tile of its tones, and on to a coverage of `top`.

    count  of marks, about; darker than the darkest level they are added at random, evenly
    """
    levels = sorted((level for level in hand.levels if level.coverage < top), key=lambda level: level.coverage)
    diameter = 2 * np.sqrt(hand.area / np.pi)
    side = max(np.sqrt(count * hand.area / -np.log1p(-top)), LEAST * diameter)
    if levels:
        side = max(side, 2.5 * (max(level.lags[-1] for level in levels) + diameter))
    marks = _Marks(np.empty((0, 2)), float(side), hand)
    ends, reached, tones, places = [0], [0.0], [0.0], [marks.xy]
    for k, level in enumerate([*levels, None]):
        yield Step(stage, k, len(levels) + 1)
        covers = _darker(marks, level.coverage if level else top, level, rng)
        first, parts = len(places[-1]), max(2, int(np.ceil((covers - reached[-1]) / FINE)))
        for share in np.arange(1, parts) / parts:  # marks that slide are on their way
            on_way = places[-1] + share * (marks.xy[:first] - places[-1])
            ends.append(round(first + share * (len(marks.xy) - first)))
            between = replace(marks, xy=np.concatenate([on_way, marks.xy[first:]]))
            reached.append(max(float(between.drawn(ends[-1]).mean()), reached[-1]))
        ends.append(len(marks.xy))
        reached.append(max(covers, reached[-1]))
        tones.append(max(reached[-1], tones[-1] + LEAP))
        places.append(marks.xy)
    threshold = np.interp(np.arange(len(marks.xy)) + 0.5, ends, reached)
    every = [marks.xy]
    for lighter in reversed(places[1:-1]):
        every.append(np.concatenate([lighter, every[-1][len(lighter) :]]))
    return replace(hand, tile=Tile(marks.side, threshold, np.array(tones[1:]), np.array(every[::-1])))


def _darker(marks: _Marks, coverage: float, level: Level | None, rng: np.random.Generator) -> float:
    """Adds marks up to a coverage, and arranges them as the level's correlation asks for; gives the coverage that is reached.

    As few are added as reach it: at first as many as if none lay on another, but by chance without a level.
    """
    area, side, before = marks.hand.area, marks.side, marks.xy
    asked = None if level is None else level.correlation
    count = round((coverage if level else -np.log1p(-coverage)) * side**2 / area)
    covers = 0.0
    for _ in range(ROUNDS):
        count = max(len(before), count)
        squares = max(1, int(side / (SQUARE * np.sqrt(area / coverage))))
        if count > len(marks.xy):
            marks.xy = np.concatenate([marks.xy, _added(marks.xy, side, squares, count - len(marks.xy), rng)])
        else:
            marks.xy = np.concatenate([marks.xy[: len(before)], rng.permutation(marks.xy[len(before) :])[: count - len(before)]])
        if level is not None and asked is not None:
            goal = Goal(side, area, marks.diameter, coverage, level.lags, asked)
            marks.xy = arranged(marks.xy, before, squares, goal, rng)
        ink = marks.drawn(len(marks.xy))
        covers = float(ink.mean())
        right = abs(covers - coverage) <= RIGHT * coverage
        if level is None or asked is None:
            if right:
                break
        else:
            off = radial(ink, level.lags, side / len(ink)) - level.correlation
            if right and np.sqrt(np.mean(off[level.lags > marks.diameter / 3] ** 2)) < MET * min(1, coverage / LIGHT):
                break
            asked = asked - off
        more = np.log1p(-coverage) / np.log1p(-min(max(covers, 1e-6), 0.999))
        count = round(len(marks.xy) * float(np.clip(more, 0.5, 2)))
    return covers


def _added(xy: Array, side: float, squares: int, count: int, rng: np.random.Generator) -> Array:
    """So many places by chance in squares, in those that have the fewest marks."""
    column, row = (np.minimum((part * squares / side).astype(np.int64), squares - 1) for part in xy.T)
    have = np.bincount(row * squares + column, minlength=squares**2)
    low, high = 0, int(have.max(initial=0)) + count
    while low < high:  # the least number that all squares can be filled up to
        middle = (low + high) // 2
        low, high = (low, middle) if np.maximum(middle - have, 0).sum() >= count else (middle + 1, high)
    short = np.maximum(low - have, 0)
    chosen = np.sort(rng.permutation(np.repeat(np.arange(squares**2), short))[:count])
    corner = np.stack([chosen % squares, chosen // squares], axis=1)
    return np.asarray(rng.permutation((corner + rng.random((count, 2))) * side / squares))
