"""Blue noise: dots of one size that all stand for the same ink, evenly spaced and in no lattice (optimal transport).

Dots are relaxed a little, shaken where there is white between them, and moved to the centroids of power cells whose weights
give every cell the same share of the ink. At the end the weights of the dots as they are drawn make shares the same to a millionth.
Source: F. de Goes, K. Breeden, V. Ostromoukhov, M. Desbrun, Blue Noise through Optimal Transport, SIGGRAPH Asia 2012; M. Balzer,
T. Schloemer, O. Deussen, Capacity-Constrained Point Distributions, SIGGRAPH 2009.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import numpy as np

from crowquill import capacity, relax
from crowquill.knobs import Range
from crowquill.nibs import Dots, Glyphs, MaxDots, MinGap, Nibs, Pen, White, inked
from crowquill.paths import Array
from crowquill.sheet import Sheet, Step
from crowquill.stippling import Clock, Plan, expected_seconds, planned, settled, snapped, watched
from crowquill.styles import Work
from crowquill.tone import Tone

EITHER = ("pen", "dots")  # of which one is enough: who types one means to do without what a recipe has of the other
FIRST = 9  # steps of Lloyd's relaxation: cheap, and the darks, where dots overlap, need them
SHAKEN = 1.0  # of the white between dots; measured: less leaves more hexagons in the lights, more costs evenness


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    pen: Pen = None,
    dots: Dots = None,
    glyphs: Glyphs = None,
    iterations: Annotated[int, Range(0, 1000, "", "steps to the middles of equal shares; many end in lattices")] = 4,
    white: White = 0.02,
    min_gap: MinGap = 0.0,
    max_dots: MaxDots = 2_000_000,
) -> Work:
    """A sheet the tone's size with a layer of black dots; the centre of none on white or outside the canvas.

    pen and dots  as in stipple; so are ink, importance, min_gap, white paper and what is raised
    shares        of the ink that is asked for, overlap included, cut by power cells; the report has `capacity_error`, the greatest
                  |share / mean - 1| of the dots where they are drawn. Where ink lies in islands a share may be in parts on
                  several; over a millionth, as with coincident dots, is said in a warning
    """
    clock = Clock()
    nibs = Nibs.of(pen, glyphs, dots=dots)
    plan = planned(tone, pen=nibs.pen, dots=dots, white=white, white_rule="before", min_gap=min_gap, max_dots=max_dots)
    yield Step("plan", 0, 1, {"dots": plan.dots, "pen_mm": plan.pen, "seconds": expected_seconds(plan.dots, FIRST + 150 * iterations)})
    chance = rng.spawn(4)
    first = yield from settled(plan.demand, plan.dots, chance[0], clock, start="even", iterations=FIRST, banned=plan.white)
    sites = _shaken(first, plan, chance[1]) if iterations else first.sites
    state = yield from watched(capacity.relaxed(sites, plan.demand, banned=plan.white), iterations, clock)
    drawn, _ = snapped(state.sites, tone, plan.white)
    shares = capacity.equal(drawn, plan.demand, state.shares.weights)
    yield Step("balance", 1, 1, {"capacity_error": shares.error})
    clock.lap("balance")
    said = [f"shares of the ink differ by up to {shares.error:.1e}: it lies in too many islands"] if shares.error > capacity.EQUAL else []
    last = replace(state, sites=drawn, cells=shares.cells, moments=shares.moments)
    sheet: Sheet = yield from inked(last, plan, tone, nibs, chance[2:], clock, capacity_error=shares.error, warnings=said)
    return sheet


def _shaken(state: relax.State, plan: Plan, rng: np.random.Generator) -> Array:
    """Sites moved by chance, as far as there is white between dots: what they have of a lattice is lost, and dark tones stay even."""
    room = np.maximum(0.0, np.sqrt(2 / np.sqrt(3) * state.cells.areas) - plan.pen)
    moved = state.sites + SHAKEN * room[:, None] * rng.standard_normal(state.sites.shape)
    return relax.held(plan.demand, plan.white, moved, state.sites)
