"""Stippling: dots of ink, evenly spaced, as many as the tone needs, of one size or several (weighted Voronoi stippling).

Some dots begin at equal shares of ink and move to the centroids of their Voronoi cells, weighed by coverage squared so that
tone is kept; they become four times as many and move on, until there are enough.
Of several sizes each dot takes the one nearest to the ink of its cell.
Source: A. Secord, Weighted Voronoi Stippling, NPAR 2002; O. Deussen, S. Hiller, C. van Overveld,
T. Strothotte, Floating Points, Eurographics 2000.
"""

from __future__ import annotations

from typing import Annotated

import numpy as np

from crowquill import expense, relax
from crowquill.knobs import Choice, Range
from crowquill.nibs import Dots, Glyphs, MaxDots, MinGap, Nibs, Pen, SizeBy, Sizes, White, inked
from crowquill.sheet import Sheet, Step
from crowquill.stippling import Clock, expected_seconds, planned, settled
from crowquill.styles import Work
from crowquill.tone import Tone

EITHER = ("pen", "dots", "sizes")  # of which one is enough: who types one means to do without what a recipe has of the others


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    pen: Pen = None,
    dots: Dots = None,
    sizes: Sizes = None,
    size_by: SizeBy = "pen",
    glyphs: Glyphs = None,
    iterations: Annotated[int, Range(0, 100_000, "", "most relaxation steps")] = 15,
    until: Annotated[float, Range(0, 1, "", "stop when dots move less, in spacings; 0 never")] = 0.0,
    step: Annotated[float, Range(0.01, 1.99, "", "how far dots move to their centroids")] = 1.8,
    exponent: Annotated[float, Range(0, 4, "", "cells weigh coverage to this power; 2 keeps tone")] = 2.0,
    start: Annotated[str, Choice(relax.STARTS, "where dots begin")] = "levels",
    white: White = 0.02,
    white_rule: Annotated[str, Choice(("before", "after"), "never place dots on white, or remove them at the end")] = "before",
    min_gap: MinGap = 0.0,
    max_dots: MaxDots = 2_000_000,
) -> Work:
    """A sheet the tone's size with a layer of black dots for each nib; the centre of none on white or outside the canvas.

    pen and dots    either gives the other by the tone's ink; both fix both and let the tone give; neither
                    is the pen of the glyphs, or 0.3 mm, or one as fine as the canvas is narrow
    sizes           nibs in place of the pen: the mean area of dots rises with the ink from the smallest's to the
                    largest's; with dots both are fixed, and the tone gives
    size_by         "tone": areas follow the ink of each cell, from the smallest of sizes to the largest, or from
                    0.6 to 1.6 times the pen; what one dot cannot hold the next ones get
    importance      of the tone: dots of several sizes are finer there; of one size, more, and the tone gives
    ink             the union of the dots covers what is asked up to 0.97, because the number of
                    dots makes up for their overlap; the report has `coverage_missing`
    min_gap         presses tones together to what dots so far apart can cover, so that tone still rises with tone
    no ink          an empty sheet and a warning. Raises ValueError for more than max_dots, for more than memory holds, for a
                    pen wider than the canvas, and for pen and sizes together
    """
    clock = Clock()
    nibs = Nibs.of(pen, glyphs, sizes=sizes, size_by=size_by, dots=dots)
    plan = planned(tone, pen=nibs.pen, dots=dots, span=nibs.span, white=white, white_rule=white_rule, min_gap=min_gap, max_dots=max_dots)
    needed = expense.relaxed(plan.dots, tone.shape)
    yield Step("plan", 0, 1, {"dots": plan.dots, "pen_mm": plan.pen, "seconds": expected_seconds(plan.dots, iterations), "bytes": needed})
    expense.afford(needed, f"{plan.dots} dots on {tone.shape[1]} x {tone.shape[0]} pixels take", "draw fewer dots, or of a smaller picture")
    chance = rng.spawn(3)
    state = yield from settled(
        plan.demand, plan.dots, chance[0], clock, start=start, iterations=iterations, until=until, step=step,
        exponent=exponent, banned=plan.white if white_rule == "before" else None,
    )  # fmt: skip
    off = len(state.sites) != plan.dots
    said = [f"this start gave {len(state.sites)} dots in place of {plan.dots}; --start even gives any number"] if off else []
    work = inked(state, plan, tone, nibs, chance[1:], clock, warnings=said)
    del state, plan
    sheet: Sheet = yield from work
    return sheet
