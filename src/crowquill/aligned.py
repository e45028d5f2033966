"""Dots along rows: how many, where they settle between evenness and the rows, and how large they are, clear of lines.

Source: D. Kim, M. Son, Y. Lee, H. Kang, S. Lee, Feature-Guided Image Stippling, Computer Graphics Forum 27(4), 2008.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill import glyphs as libraries
from crowquill import measure, moments, relax
from crowquill.field import Rows, Sight, between
from crowquill.halftone.averages import averaged
from crowquill.marks import Glyph, Marks
from crowquill.paths import Array
from crowquill.sheet import Step
from crowquill.stippling import CAP, NOMINAL, RENDERED, Clock, Plan, cut_white, dotted, expected_seconds, found, planned, snapped
from crowquill.tone import Tone

SPAN = (0.4, 1.4)  # smallest and largest dots over the pen: rows lie evenly where sizes, not numbers, make the tone
FREE = 5  # steps by the tone alone
LED = 20  # steps after them, every other one towards the rows, the last among these
STEP = 1.8  # how far the free ones go
REACH = 20.0  # pitches from a line within which its rows count
FINE = 4  # squares to a pitch
MOST = 4_000_000  # squares
WIDE = 1 / 3  # of a pitch: the width of a row
ROWED = 1.05  # of the root of the area to a dot: at 0.93, a triangular lattice, the next dot is as near across rows as along them
NEAR = 1.5  # pitches over which ink is handed on
SMALL = 0.5  # of the smallest dot; one with less room is left out
ROUNDS = 3
CLOSE = 1e-3  # of the ink; nearer, sizes are right

Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Setting:
    """What dots along rows begin with: the tone asked for, how many dots it takes alone, the dots' shapes, and the limits."""

    asked: Tone
    alone: Plan
    glyphs: tuple[Glyph, ...]
    white: float
    most: int

    @classmethod
    def of(cls, tone: Tone, *, pen: float | None, dots: int | None, glyphs: str | None, white: float, most: int) -> Setting:
        """The setting for a tone and the knobs of a style; raises what `stippling.planned` raises."""
        library = None if glyphs is None else libraries.load(glyphs)
        pen = library.pen if library and pen is None and dots is None else pen
        asked, _ = cut_white(tone, white)
        alone = _planned(asked, pen, dots, white, most)
        library = library or libraries.load(libraries.nearest(alone.largest / SPAN[1]))
        return cls(asked, alone, library.glyphs, white, most)

    @property
    def pen(self) -> float:
        """The pen's width, of which dots are 0.4 to 1.4 times, mm."""
        return self.alone.largest / SPAN[1]

    @cached_property
    def pitch(self) -> float:
        """How far apart rows are to lie, mm: a little more than dots are, where they are as dense as around half of them."""
        demand = self.alone.demand
        many = np.sort((demand.coverage * self.alone.dots / (demand.ink or 1.0)).ravel())
        total = np.cumsum(many)
        return ROWED / float(np.sqrt(many[np.searchsorted(total, total[-1] / 2)])) if total[-1] > 0 else self.pen

    def foretold(self, iterations: int) -> Step:
        """The first Step of work that takes as long as stippling with so many iterations."""
        dots = self.alone.dots
        return Step("plan", 0, 1, {"dots": dots, "pen_mm": self.pen, "seconds": expected_seconds(dots, iterations)})

    def planned(self, demand: Tone, dots: int | None) -> Plan:
        """How many dots a demand takes, or how large so many are."""
        return _planned(demand, self.pen, dots, 0.0, self.most)

    def evened(self, sight: Sight) -> Tone:
        """The picture evened out along its flow, on squares fine enough for rows: nothing below white, and the same ink."""
        asked, side = self.asked, self.pitch / FINE
        wish = None if asked.importance is None else squared(Tone(asked.importance, asked.size), side).coverage
        tone = replace(squared(sight.smoothed(), side), canvas=asked.canvas, importance=wish)
        tone, _ = cut_white(tone, self.white)
        return tone.mapped(lambda c: np.minimum(c * asked.ink / (tone.ink or 1.0), 1))


def _planned(tone: Tone, pen: float | None, dots: int | None, white: float, most: int) -> Plan:
    """How many dots of what diameter the tone takes, their sizes following it."""
    return planned(tone, pen=pen, dots=dots, span=SPAN, white=white, white_rule="before", min_gap=0.0, max_dots=most)


def radius(coverage: Array, pen: float) -> Array:
    """How large a dot is to be where so much of the paper is to be covered, mm: as it is planned for sizes by tone."""
    least = (SPAN[0] / SPAN[1]) ** 2
    share = np.interp(coverage, RENDERED, NOMINAL) / np.interp(CAP, RENDERED, NOMINAL)
    return np.asarray(pen * SPAN[1] / 2 * np.sqrt(np.minimum(least + (1 - least) * share, 1)))


def squared(tone: Tone, side: float) -> Tone:
    """The tone on squares of so many mm or somewhat less, but no more than MOST: exact means; finer squares have their pixel's tone.

    Importance and colours are left behind.
    """
    h, w = tone.coverage.shape
    side = max(side, float(np.sqrt(tone.size[0] * tone.size[1] / MOST)))
    m, n = (max(1, int(np.ceil(length / side))) for length in reversed(tone.size))
    means = averaged(tone.coverage, np.linspace(0, w, n + 1), np.linspace(0, h, m + 1))
    return Tone(np.clip(means, 0, 1), tone.size, tone.canvas)


def handed_on(asked: Tone, spent: Array, free: Mask, reach: float) -> Tone:
    """What is asked of dots once lines have spent ink (h, w): nothing where no dots may lie, and what is missing or too much there, nearby.

    free   where dots may lie
    reach  mm over which ink is handed on, to places in proportion to what they have, or have room for
    """
    from scipy.ndimage import uniform_filter

    box = [2 * int(reach / side) + 1 for side in reversed(asked.pixel)]

    def around(values: Array) -> Array:
        return np.asarray(uniform_filter(uniform_filter(values, box, mode="constant"), box, mode="constant"))

    want = asked.coverage - spent
    given, rest = np.where(free, want, 0.0), np.where(free, 0.0, want)
    base = np.where(free, asked.coverage, 0.0)
    for _ in range(ROUNDS):
        kept = np.clip(given, 0, CAP)
        given, rest = kept, (rest + given - kept) * asked.inside
        if np.abs(rest).sum() <= CLOSE * asked.coverage.sum():
            break
        for sign, room in ((1, base * (CAP - given)), (-1, given)):
            part, near = np.maximum(sign * rest, 0), around(room * asked.inside)
            some = near > 1e-6
            given = given + sign * room * around(np.where(some, part / np.where(some, near, 1), 0))
            rest = rest - sign * np.where(some, part, 0)
    return asked.holding(np.clip(given, 0, 1))


@dataclass(frozen=True, eq=False)
class Laid:
    """Dots along rows, and how they came there.

    off  the median distance from the nearest row in pitches, of dots within half the reach: a quarter were they anywhere
    """

    marks: Marks
    plan: Plan
    state: relax.State
    off: float


def laid(
    plan: Plan,
    rows: Rows,
    glyphs: tuple[Glyph, ...],
    rng: np.random.Generator,
    clock: Clock,
    *,
    reach: float,
    room: Array | None = None,
    lost: Callable[[Marks], float] = lambda _: 0.0,
) -> Generator[Step, None, Laid]:
    """Steps of dots being placed, relaxed, led to rows and sized; returns them.

    reach  mm; at a distance d from what rows go along a dot goes by d / reach to its cell's centroid, and for the rest to the
           centroid of what rows cover of it; 0 leads none
    room   (h, w) mm that dots may reach from each square; those with less than half the smallest dot's go
    lost   of some dots, how many mm^2 lie on black and do not count
    """
    chance = rng.spawn(2)
    state = yield from _settled(plan, rows, reach, chance[0], clock)
    yield Step("size", 0, 1)
    sites, kept = snapped(state.sites, plan.demand, plan.white)
    limit = np.full(len(sites), np.inf) if room is None else between(room, plan.demand.size, sites)
    marks = dotted(sites, glyphs, np.ones(len(sites)), chance[1])
    near = rows.far.at(sites) < reach / 2
    off = float(np.median(rows.off(sites[near]))) / rows.pitch if near.any() else 0.25
    sized = _sized(state, plan, marks, np.where(kept, limit, 0), lost)
    clock.lap("size")
    return Laid(sized, plan, state, off)


def _settled(plan: Plan, rows: Rows, reach: float, rng: np.random.Generator, clock: Clock) -> Generator[Step, None, relax.State]:
    """Steps of sites being placed, relaxed, and led to rows; returns the last state, that of no sites where there are none."""
    tone = plan.demand
    sites = relax.scatter(tone, plan.dots, rng)
    yield Step("place", 1, 1, {"dots": len(sites)})
    clock.lap("place")
    banded = tone.holding(tone.coverage**2 * rows.share(WIDE * rows.pitch))

    def lead(state: relax.State) -> Array:
        free = state.moments.centroid
        if not reach or state.done < FREE or (state.done - FREE) % 2 == 0:
            return state.sites + STEP * (free - state.sites)
        on = moments.of_tone(state.cells, banded)
        part = np.where(on.mass > 0, np.minimum(rows.far.at(free) / reach, 1), 1)[:, None]
        return np.asarray(part * free + (1 - part) * on.centroid)

    for state in relax.lloyd(sites, tone, banned=plan.white, lead=lead):
        if not len(sites):
            break
        yield Step("relax", state.done, FREE + LED, {"energy": state.energy, "movement": state.movement})
        if state.done >= FREE + LED:
            break
    clock.lap("relax")
    return state


def _sized(state: relax.State, plan: Plan, marks: Marks, limit: Array, lost: Callable[[Marks], float]) -> Marks:
    """Marks whose areas are the ink of their cells, times one number so that together they cover what is asked.

    limit  (n,) mm that each may reach from its site
    """
    due = moments.of_tone(state.cells, plan.nominal).mass * NOMINAL[-1]
    most = np.pi / 4 * plan.largest**2
    least = most * (SPAN[0] / SPAN[1]) ** 2
    reach = np.array([glyph.reach for glyph in marks.glyphs])[marks.glyph]
    top = np.minimum(most, (np.maximum(limit, 0) / reach) ** 2)
    top[top < SMALL**2 * least] = 0
    grow = 1.0
    for _ in range(ROUNDS):
        marks = replace(marks, scale=np.sqrt(np.minimum(np.clip(grow * due, least, most), top)))
        ink = measure.ink(marks) - lost(marks)
        if not ink or abs(ink / plan.ink - 1) < CLOSE:
            break
        grow *= plan.ink / ink
    return marks.take(top > 0)


def told(parts: Sequence[Laid], asked: float, ink: float, rows: Rows, clock: Clock) -> dict[str, Any]:
    """What is reported of dots along rows, of black ones first and then of white ones, and of all ink, mm^2."""
    first, states = parts[0].plan, [part.state for part in parts]
    count, scales = sum(len(state.sites) for state in states), np.concatenate([part.marks.scale for part in parts])
    pen = 2 * float(np.sqrt((scales**2).mean() / np.pi)) if len(scales) else first.pen
    return {
        **found(replace(first, dots=sum(part.plan.dots for part in parts), ink=asked, pen=pen), len(scales), ink),
        "left_out": count - len(scales),
        "rows_mm": rows.pitch,
        "rows_off": max(parts, key=lambda part: len(part.marks)).off,
        "iterations": max(state.done for state in states),
        "energy": sum(state.energy for state in states),
        "movement": max(state.movement for state in states),
        "seconds": clock.laps,
    }
