"""Adaptive: dots that part in two where there is too much ink for one, and go where there is too little (Linde-Buzo-Gray stippling).

Their number follows from the pen and the tone. Of one size each stands for its own ink; sizes that follow the tone are the ink of
each dot's cell.
Source: O. Deussen, M. Spicker, Q. Zheng, Weighted Linde-Buzo-Gray Stippling, SIGGRAPH Asia 2017.
"""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from crowquill import expense, relax, splitting
from crowquill.knobs import Choice, Range
from crowquill.nibs import Glyphs, MaxDots, MinGap, Nibs, Pen, SizeBy, Sizes, White, inked
from crowquill.sheet import Sheet, Step
from crowquill.stippling import Clock, expected_seconds, planned, watched
from crowquill.styles import Work
from crowquill.tone import Tone

EITHER = ("pen", "sizes")  # of which one is enough: who types one means to do without what a recipe has of the other
ITERATIONS, PUBLISHED = 20, 50


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    pen: Pen = None,
    sizes: Sizes = None,
    size_by: SizeBy = "pen",
    glyphs: Glyphs = None,
    schedule: Annotated[str, Choice(("exact", "published"), "the number exact, or the paper's own rule, often too many")] = "exact",
    iterations: Annotated[int | None, Range(0, 1000, "", "most steps of parting and moving (20; 50 as published)")] = None,
    white: White = 0.02,
    min_gap: MinGap = 0.0,
    max_dots: MaxDots = 2_000_000,
) -> Work:
    """A sheet the tone's size with a layer of black dots for each nib; the centre of none on white or outside the canvas.

    pen, sizes, size_by  as in stipple; so are ink, importance, min_gap, white paper and what is raised
    schedule             "exact": from equal shares of ink on, and as many part as go; "published": from one dot on, until none
                         parts or goes. Dots stay whose cells hold two thirds of their ink, and so there may be a third too many:
                         a warning says how many would be right
    """
    clock, exact = Clock(), schedule == "exact"
    nibs = Nibs.of(pen, glyphs, sizes=sizes, size_by=size_by)
    plan = planned(tone, pen=nibs.pen, dots=None, span=nibs.span, white=white, white_rule="before", min_gap=min_gap, max_dots=max_dots)
    most = iterations if iterations is not None else ITERATIONS if exact else PUBLISHED
    needed = expense.relaxed(plan.dots, tone.shape)
    yield Step("plan", 0, 1, {"dots": plan.dots, "pen_mm": plan.pen, "seconds": expected_seconds(plan.dots, most), "bytes": needed})
    expense.afford(needed, f"{plan.dots} dots on {tone.shape[1]} x {tone.shape[0]} pixels take", "draw fewer dots, or of a smaller picture")
    chance = rng.spawn(4)
    sites = relax.scatter(plan.demand, plan.dots if exact else min(1, plan.dots), chance[0])
    yield Step("place", 1, 1, {"dots": len(sites)})
    clock.lap("place")
    rule: dict[str, Any] = {} if exact else {"band": (0.6, 0.01), "step": 1.0, "exponent": 1.0}
    share = plan.demand.ink / plan.dots if plan.dots else 1.0
    states = splitting.divided(sites, plan.demand, share, chance[1], exact=exact, banned=plan.white, **rule)
    state = yield from watched(states, most, clock)
    off = len(state.sites) != plan.dots
    said = [f"the schedule gave {len(state.sites)} dots in place of {plan.dots}; --schedule exact gives the number"] if off else []
    sheet: Sheet = yield from inked(state, plan, tone, nibs, chance[2:], clock, warnings=said)
    return sheet
