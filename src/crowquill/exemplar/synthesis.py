"""A tile of marks whose texture, tone by tone, is that of an example.

Marks are added from the lightest tone to the darkest, so that a mark of a light tone stays in all darker ones. Those of a tone
are moved, one at a time, wherever that brings pairs of marks nearer to what the example's correlation asks for. What overlap
hides is made up for in rounds: the tile is drawn, and its own correlation corrects what is asked for.

Source: S. Kim, R. Maciejewski, T. Isenberg, W. M. Andrews, W. Chen, M. C. Sousa, D. S. Ebert, Stippling by Example, NPAR 2009.
Moving points towards a correlation: C. L. Y. Yeong, S. Torquato, Reconstructing random media, Physical Review E 57(1), 1998.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from crowquill import measure
from crowquill.exemplar.correlation import FINE, lens, radial, shares
from crowquill.exemplar.style import Hand, Level, Tile
from crowquill.kernel import compiled
from crowquill.marks import Marks
from crowquill.paths import Array, Index

ROUNDS = 5  # of drawing a tone and correcting what is asked for
SWEEPS = 12  # of proposals in a round, PROPOSED to a mark; most tones are met in two or three
PROPOSED = 4
NEAR, MET = 0.003, 0.01  # rms by which the correlation may be missed, by pairs in a round and by the tile drawn
LIGHT = 0.2  # coverage below which it may be missed by less: of few marks it is small by itself
RIGHT = 0.005  # of its coverage by which a tone may be missed
SQUARE = 6.0  # mean spacings: the side of squares that have equal numbers of marks, and that none leaves
SPREAD = 0.5  # of a mark's diameter: how far half of the proposals lie
PIXELS = 7  # to a mark's diameter, where a tile is drawn
LEAST = 12  # diameters to the side of a tile


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


def tiled(hand: Hand, top: float, count: int, rng: np.random.Generator) -> Generator[tuple[int, int], None, Hand]:
    """Yields how many tones of how many are done, and returns the hand with a tile of its tones, and on to a coverage of `top`.

    count  of marks, about; darker than the darkest level they are added at random, evenly
    """
    levels = sorted((level for level in hand.levels if level.coverage < top), key=lambda level: level.coverage)
    diameter = 2 * np.sqrt(hand.area / np.pi)
    side = max(np.sqrt(count * hand.area / -np.log1p(-top)), LEAST * diameter)
    if levels:
        side = max(side, 2.5 * (max(level.lags[-1] for level in levels) + diameter))
    marks = _Marks(np.empty((0, 2)), float(side), hand)
    ends, reached = [0], [0.0]
    for k, level in enumerate([*levels, None]):
        yield k, len(levels) + 1
        covers = _darker(marks, level.coverage if level else top, level, rng)
        half = (ends[-1] + len(marks.xy)) // 2
        if half > ends[-1]:
            ends.append(half)
            reached.append(max(float(marks.drawn(half).mean()), reached[-1]))
        ends.append(len(marks.xy))
        reached.append(max(covers, reached[-1]))
    threshold = np.interp(np.arange(len(marks.xy)) + 0.5, ends, reached)
    return replace(hand, tile=Tile(marks.side, marks.xy, threshold))


def _darker(marks: _Marks, coverage: float, level: Level | None, rng: np.random.Generator) -> float:
    """Adds marks up to a coverage, and arranges them as the level's correlation asks for; gives the coverage that is reached."""
    area, side = marks.hand.area, marks.side
    first, kept = len(marks.xy), marks.xy
    wanted = None if level is None else np.log(np.maximum(1 + level.correlation * coverage / (1 - coverage), 0.02))
    asked = wanted
    count = max(first, round(-np.log1p(-coverage) * side**2 / area))
    covers = 0.0
    for _ in range(ROUNDS):
        squares = max(1, int(side / (SQUARE * np.sqrt(area / coverage))))
        if count > len(marks.xy):
            marks.xy = np.concatenate([marks.xy, _added(marks.xy, side, squares, count - len(marks.xy), rng)])
        else:
            marks.xy = np.concatenate([kept, rng.permutation(marks.xy[first:])[: max(count - first, 0)]])
        if level is not None and asked is not None and wanted is not None:
            _arranged(marks, first, squares, level.lags, asked, coverage, rng)
        ink = marks.drawn(len(marks.xy))
        covers = float(ink.mean())
        right = abs(covers - coverage) <= RIGHT * coverage
        if level is not None and asked is not None and wanted is not None:
            pixel = side / len(ink)
            found = radial(ink, level.lags, pixel)
            far = level.lags > marks.diameter / 3
            if right and np.sqrt(np.mean((found - level.correlation)[far] ** 2)) < MET * min(1, coverage / LIGHT):
                break
            asked = asked + wanted - np.log(np.maximum(1 + found * coverage / (1 - coverage), 0.02))
        elif right:
            break
        more = np.log1p(-coverage) / np.log1p(-min(max(covers, 1e-6), 0.999))
        count = max(first, round(len(marks.xy) * float(np.clip(more, 0.5, 2))))
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


def _arranged(marks: _Marks, first: int, squares: int, lags: Array, asked: Array, coverage: float, rng: np.random.Generator) -> None:
    """Moves the marks from `first` on until pairs give the covariance that is asked for, or no more is gained.

    asked  (m,) ln of 1 + correlation * coverage / (1 - coverage), which of discs that lie by chance is their covariance itself
    """
    n, side, diameter = len(marks.xy), marks.side, marks.diameter
    fresh = n - first
    if not fresh:
        return
    table = shares(lags, diameter)
    density = n / side**2
    goal = side**2 / 2 * (asked + (density * marks.hand.area) ** 2 - density * lens(lags, diameter))
    low = np.argmax(table > 0, axis=1)
    high = np.where((table > 0).any(axis=1), table.shape[1] - np.argmax(table[:, ::-1] > 0, axis=1), 0)
    reach = float(min((len(table) - 1) * diameter / FINE, 0.42 * side))
    bins = int(3 * side / reach)
    x, y = np.ascontiguousarray(marks.xy.T)
    chains = _chained(x, y, side, bins)
    total = np.zeros(len(lags))
    _summed(x, y, side, bins, *chains, table, low, high, FINE / diameter, reach, total)
    scale = 2 / side**2 * (1 - coverage) / coverage  # from sums over pairs to a correlation
    for _ in range(SWEEPS):
        if np.sqrt(np.mean((total - goal) ** 2)) * scale < NEAR * min(1, coverage / LIGHT):
            break
        tries = PROPOSED * fresh
        which = first + rng.integers(fresh, size=tries)
        local = rng.random(tries) < 0.5
        places = rng.random((tries, 2))
        away = rng.normal(0, SPREAD * diameter, (tries, 2))
        taken = _moved(
            x, y, side, bins, *chains, which, local, places, away, squares, table, low, high, FINE / diameter, reach, total, goal
        )  # fmt: skip
        if taken < 0.002 * tries:
            break
    marks.xy = np.stack([x, y], axis=1)


def _chained(x: Array, y: Array, side: float, bins: int) -> tuple[Index, Index, Index]:
    """Marks in squares as chains: the first of each square, and the next and the last before each mark; -1 for none."""
    head, after, before = np.full(bins * bins, -1), np.full(len(x), -1), np.full(len(x), -1)
    _linked(x, y, side, bins, head, after, before)
    return head, after, before


@compiled
def _square(x: float, y: float, side: float, bins: int) -> int:
    return min(int(y / side * bins), bins - 1) * bins + min(int(x / side * bins), bins - 1)


@compiled
def _linked(x: Array, y: Array, side: float, bins: int, head: Index, after: Index, before: Index) -> None:
    for i in range(len(x)):
        at = _square(x[i], y[i], side, bins)
        after[i] = head[at]
        if head[at] >= 0:
            before[head[at]] = i
        head[at] = i


@compiled
def _paired(
    px: float, py: float, own: int, sign: float, x: Array, y: Array, side: float, bins: int, head: Index, after: Index,
    table: Array, low: Index, high: Index, finer: float, reach: float, sums: Array,
) -> None:  # fmt: skip
    """Adds to sums what a mark at a place shares with all others, times a sign."""
    row, column = min(int(py / side * bins), bins - 1), min(int(px / side * bins), bins - 1)
    for down in range(-3, 4):
        for across in range(-3, 4):
            j = head[((row + down) % bins) * bins + (column + across) % bins]
            while j >= 0:
                if j != own:
                    dx, dy = abs(x[j] - px), abs(y[j] - py)
                    dx, dy = min(dx, side - dx), min(dy, side - dy)
                    squared = dx * dx + dy * dy
                    if squared < reach * reach:
                        k = int(np.sqrt(squared) * finer + 0.5)
                        for d in range(low[k], high[k]):
                            sums[d] += sign * table[k, d]
                j = after[j]


@compiled
def _summed(
    x: Array, y: Array, side: float, bins: int, head: Index, after: Index, _before: Index,
    table: Array, low: Index, high: Index, finer: float, reach: float, total: Array,
) -> None:  # fmt: skip
    for i in range(len(x)):
        _paired(x[i], y[i], i, 0.5, x, y, side, bins, head, after, table, low, high, finer, reach, total)


@compiled
def _moved(
    x: Array, y: Array, side: float, bins: int, head: Index, after: Index, before: Index, which: Index, local: npt.NDArray[np.bool_],
    places: Array, away: Array, squares: int, table: Array, low: Index, high: Index, finer: float, reach: float, total: Array, goal: Array,
) -> int:  # fmt: skip
    """Moves marks to proposed places in their own squares where that lowers the sum of squares of total - goal; gives how many moved."""
    taken, change = 0, np.empty(len(total))
    width = side / squares
    for t in range(len(which)):
        i = which[t]
        left, top = min(int(x[i] / width), squares - 1) * width, min(int(y[i] / width), squares - 1) * width
        if local[t]:
            px, py = x[i] + away[t, 0], y[i] + away[t, 1]
            if not (left <= px < left + width and top <= py < top + width):
                continue
        else:
            px, py = left + places[t, 0] * width, top + places[t, 1] * width
        change[:] = 0
        _paired(x[i], y[i], i, -1.0, x, y, side, bins, head, after, table, low, high, finer, reach, change)
        _paired(px, py, i, 1.0, x, y, side, bins, head, after, table, low, high, finer, reach, change)
        gain = 0.0
        for d in range(len(total)):
            gain += change[d] * (change[d] + 2 * (total[d] - goal[d]))
        if gain >= 0:
            continue
        taken += 1
        total += change
        old, new = _square(x[i], y[i], side, bins), _square(px, py, side, bins)
        x[i], y[i] = px, py
        if old != new:
            if before[i] >= 0:
                after[before[i]] = after[i]
            else:
                head[old] = after[i]
            if after[i] >= 0:
                before[after[i]] = before[i]
            before[i], after[i] = -1, head[new]
            if head[new] >= 0:
                before[head[new]] = i
            head[new] = i
    return taken
