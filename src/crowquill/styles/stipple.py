"""Stippling: equal dots of ink, evenly spaced, as many as the tone needs (weighted Voronoi stippling).

Dots start at equal shares of ink and move to the centroids of their Voronoi cells, weighed by
coverage squared so that tone is kept.
Source: A. Secord, Weighted Voronoi Stippling, NPAR 2002; O. Deussen, S. Hiller, C. van Overveld,
T. Strothotte, Floating Points, Eurographics 2000.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import glyphs as libraries
from crowquill import measure, relax
from crowquill.paths import Array
from crowquill.sheet import Ink, Layer, Marks, Sheet, Step
from crowquill.styles import Choice, Range, Text, Work
from crowquill.tone import Tone

PEN = 0.3  # mm, the commonest technical pen
CAP = 0.97  # coverage that overlapping dots still reach with a fifth more ink than paper

# Coverage that relaxed dots of the shipped libraries really give when their areas sum to this share of
# the paper: below 0.6 they hardly touch. Written by tools/calibrate.py.
NOMINAL = np.array([0.0, 0.2, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4])
RENDERED = np.array([0.0, 0.2001, 0.3998, 0.5004, 0.5998, 0.6971, 0.7847, 0.8581, 0.9155, 0.9525, 0.9761, 0.9902, 0.9979])


@dataclass(frozen=True)
class Plan:
    """How many dots of what diameter, and where they are wanted.

    demand  where dots go, as a tone: coverage before overlap, over its largest possible value
    white   (h, w) pixels that must stay free of dots
    ink     mm^2 asked for, that on white not counted
    """

    demand: Tone
    white: npt.NDArray[np.bool_]
    ink: float
    pen: float
    dots: int


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    pen: Annotated[float | None, Range(0.01, 50, "mm", "dot diameter; decides the number of dots (0.3mm)")] = None,
    dots: Annotated[int | None, Range(1, 100_000_000, "", "number of dots; decides their diameter")] = None,
    glyphs: Annotated[str, Text("library of dots: a name, or an SVG file")] = "nib-03",
    iterations: Annotated[int, Range(0, 100_000, "", "most relaxation steps")] = 30,
    until: Annotated[float, Range(0, 1, "", "stop when dots move less, in spacings; 0 never")] = 0.0,
    step: Annotated[float, Range(0.01, 1.99, "", "how far dots move to their centroids")] = 1.8,
    exponent: Annotated[float, Range(0, 4, "", "cells weigh coverage to this power; 2 keeps tone")] = 2.0,
    start: Annotated[str, Choice(relax.STARTS, "where dots begin")] = "even",
    white: Annotated[float, Range(0, 1, "", "no dots where coverage is below")] = 0.02,
    white_rule: Annotated[str, Choice(("before", "after"), "never place dots on white, or remove them at the end")] = "before",
    min_gap: Annotated[float, Range(0, 100, "mm", "least white between dots; nearer ones are left out")] = 0.0,
    max_dots: Annotated[int, Range(1, 100_000_000, "", "refuse to draw more")] = 2_000_000,
) -> Work:
    """A sheet the tone's size with one layer of black dots; the centre of none on white or outside the canvas.

    pen and dots    either gives the other by the tone's ink; both fix both and let the tone give; neither
                    is a 0.3 mm pen, or one as fine as the canvas is narrow
    ink             the union of the dots covers what is asked up to 0.97, because the number of
                    dots makes up for their overlap; the report has `coverage_missing`
    min_gap         asks for no more coverage than dots so far apart can give, so that tone still rises with tone
    no ink          an empty sheet and a warning. Raises ValueError for more than max_dots, and
                    for a pen wider than the canvas
    """
    clock = Clock()
    library = libraries.load(glyphs)
    plan = planned(tone, pen=pen, dots=dots, white=white, white_rule=white_rule, min_gap=min_gap, max_dots=max_dots)
    yield Step("plan", 0, 1, {"dots": plan.dots, "pen_mm": plan.pen, "seconds": expected_seconds(plan.dots, iterations)})
    chance = rng.spawn(2)
    sites = relax.scatter(plan.demand, plan.dots, chance[0], start)
    yield Step("place", 1, 1, {"dots": len(sites)})
    clock.lap("place")
    energy, movement, done = 0.0, 0.0, 0
    if len(sites):
        banned = plan.white if white_rule == "before" else None
        for state in relax.lloyd(sites, plan.demand, step=step, exponent=exponent, banned=banned):
            sites, energy, movement, done = state.sites, state.energy, state.movement, state.done
            yield Step("relax", done, iterations, {"energy": energy, "movement": movement})
            if done >= iterations or movement < until:
                break
    clock.lap("relax")
    sites, kept = _snapped(sites, tone, plan.white)
    placed = _marks(sites, library.glyphs, plan.pen, chance[1]).take(kept)
    marks = placed.take(_apart(placed, min_gap)) if min_gap else placed
    yield Step("measure", 0, 1)
    ink = measure.ink(marks)
    clock.lap("measure")
    report = {
        **_found(plan, len(sites), len(marks), ink),
        "removed_on_white": int(len(sites) - kept.sum()),
        "removed_for_gap": len(placed) - len(marks),
        "iterations": done,
        "energy": energy,
        "movement": movement,
        "seconds": clock.laps,
        "glyphs": library.name,
        "simulated": bool(library.about.get("simulated", False)),
    }
    return Sheet(tone.size, (Layer(Ink(), marks),), report=report)


def _found(plan: Plan, sites: int, marks: int, ink: float) -> dict[str, Any]:
    """What is reported of dots and ink, and what is to be said of it."""
    asked, warnings = plan.ink, []
    missing = max(0.0, 1 - ink / asked) if asked else 0.0
    if not asked:
        warnings.append("no ink: the picture is white, or lighter than the white cutoff, where it may be drawn on")
    elif not plan.dots:
        warnings.append(f"no dots: all the ink is less than half a dot of {plan.pen:.4g} mm; a finer pen would draw it")
    elif missing > 0.02:
        warnings.append(f"{missing:.1%} of the ink asked for is not reached; a wider pen, more dots or lighter tones would help")
    if sites != plan.dots:
        warnings.append(f"this start gave {sites} dots in place of {plan.dots}; --start even gives any number")
    return {
        "marks": marks,
        "pen_mm": plan.pen,
        "ink_asked_mm2": asked,
        "ink_placed_mm2": ink,
        "coverage_missing": missing,
        "warnings": warnings,
    }


class Clock:
    """Seconds by stage."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._last = time.perf_counter()

    def lap(self, stage: str) -> None:
        """Ends a stage."""
        now = time.perf_counter()
        self.laps[stage] = round(now - self._last, 3)
        self._last = now


def expected_seconds(dots: int, iterations: int) -> float:
    """About how long a drawing will take here, from one small triangulation timed now and the ratios that bench/ prints."""
    from scipy.spatial import Delaunay

    sites = np.random.default_rng(0).random((5000, 2))
    began = time.perf_counter()
    Delaunay(sites)
    unit = 20 * (time.perf_counter() - began)  # about the time of 100 000 sites
    return round(unit * dots / 100_000 * (0.35 * (iterations + 1) + 3) + 1, 1)


def planned(tone: Tone, *, pen: float | None, dots: int | None, white: float, white_rule: str, min_gap: float, max_dots: int) -> Plan:
    """How many dots of what diameter the tone takes, before any is placed."""
    blank = tone.coverage < white
    asked = tone
    if white_rule == "before":
        asked = tone.mapped(lambda c: np.where(blank, 0.0, c))
        blank = blank | (asked.coverage == 0)
    across = float(np.diff(np.array(shapely.bounds(tone.canvas)).reshape(2, 2), axis=0).min())
    width = min(PEN, across) if pen is None else pen
    if pen is not None and pen > across:
        raise ValueError(f"a pen of {pen:g} mm is wider than the canvas of {across:.4g} mm; use a finer pen")
    if dots is not None and pen is None:  # two rounds: how wide a dot is decides how far around it tone is looked at
        for _ in range(2):
            ink = _demand(asked, width, _cap(width, min_gap)).ink * NOMINAL[-1]
            width = min(across, 2 * float(np.sqrt(ink / (np.pi * dots)))) if ink else PEN
    demand = _demand(asked, width, _cap(width, min_gap))
    ink = demand.ink * NOMINAL[-1]
    wanted = round(ink / (np.pi * width**2 / 4)) if dots is None else dots if ink else 0
    if wanted > max_dots:
        raise ValueError(
            f"the picture takes {wanted} dots of {width:g} mm, over the limit of {max_dots}; "
            "draw it smaller, use a wider pen, or raise max-dots"
        )
    return Plan(demand, blank, tone.mapped(lambda c: np.where(blank, 0.0, c)).ink, width, wanted)


def _cap(pen: float, gap: float) -> float:
    """The greatest coverage to ask for.

    Dots that must stay apart cover less: relaxed ones of this width and more than 0.46 of the paper begin to
    break the gap. That many would have to go again, most of them where it is darkest.
    """
    return min(CAP, 0.46 * (pen / (pen + gap)) ** 2) if gap else CAP


def _demand(asked: Tone, pen: float, cap: float) -> Tone:
    """Coverage before overlap, over its largest value.

    How much dots overlap follows the tone around a dot, not under one pixel: fine texture
    keeps its mean.
    """
    from scipy.ndimage import gaussian_filter

    sigma = [pen / side for side in reversed(asked.pixel)]
    around = np.clip(gaussian_filter(np.minimum(asked.coverage, cap), sigma, mode="nearest", truncate=3.0), 1e-6, cap)
    swell = np.interp(around, RENDERED, NOMINAL) / around
    return asked.mapped(lambda c: np.clip(np.minimum(c, cap) * swell / NOMINAL[-1], 0, 1))


def _snapped(sites: Array, tone: Tone, white: npt.NDArray[np.bool_]) -> tuple[Array, npt.NDArray[np.bool_]]:
    """Sites in whole micrometres, and which of them may stay: in the canvas and not on white.

    A site whose nearest micrometre is across a border takes one on its own side.
    """
    best = np.round(sites, 3)
    good = _allowed(best, tone, white)
    for x in (np.floor, np.ceil):
        for y in (np.floor, np.ceil):
            lost = np.flatnonzero(~good)
            other = np.stack([x(sites[lost, 0] * 1000), y(sites[lost, 1] * 1000)], axis=1) / 1000
            mends = _allowed(other, tone, white)
            best[lost[mends]] = other[mends]
            good[lost[mends]] = True
    return best, good


def _allowed(sites: Array, tone: Tone, white: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    return np.asarray(tone.holds(sites) & ~white[tone.under(sites)])


def _marks(sites: Array, glyphs: tuple[Any, ...], pen: float, rng: np.random.Generator) -> Marks:
    """A glyph at each site, turned at random; true diameters keep their spread about the pen's width."""
    glyph = rng.permutation(np.arange(len(sites)) % len(glyphs))  # each as often as any other
    sizes = np.array([glyph.size for glyph in glyphs])[glyph]
    scale = pen * np.sqrt(np.pi) / 2 * sizes / np.sqrt((sizes**2).mean()) if len(sites) else sizes
    return Marks.of(sites, glyphs, scale=scale, angle=rng.uniform(0, 2 * np.pi, len(sites)), glyph=glyph)


def _apart(marks: Marks, gap: float) -> npt.NDArray[np.bool_]:
    """Which marks stay so that no two outlines are nearer than the gap, taking each mark as its circle of reach.

    Of two that are too near, the one with more such neighbours goes, or else the later.
    """
    from scipy.spatial import cKDTree

    reach = np.array([glyph.reach for glyph in marks.glyphs])[marks.glyph] * marks.scale
    stay = np.ones(len(marks), bool)
    if len(marks) < 2:
        return stay
    pairs = cKDTree(marks.xy).query_pairs(2 * reach.max() + gap, output_type="ndarray")
    near = np.hypot(*(marks.xy[pairs[:, 0]] - marks.xy[pairs[:, 1]]).T) < reach[pairs].sum(axis=1) + gap
    pairs = pairs[near]
    crowd = np.bincount(pairs.ravel(), minlength=len(marks))
    pairs = np.sort(pairs, axis=1)
    order = np.lexsort((pairs[:, 1], pairs[:, 0], -crowd[pairs].max(axis=1)))
    for i, j in pairs[order].tolist():
        if stay[i] and stay[j]:
            stay[j if crowd[j] >= crowd[i] else i] = False
    return stay
