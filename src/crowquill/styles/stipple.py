"""Stippling: dots of ink, evenly spaced, as many as the tone needs, of one size or several (weighted Voronoi stippling).

Dots start at equal shares of ink and move to the centroids of their Voronoi cells, weighed by
coverage squared so that tone is kept. Of several sizes each dot takes the one nearest to the ink of its cell.
Source: A. Secord, Weighted Voronoi Stippling, NPAR 2002; O. Deussen, S. Hiller, C. van Overveld,
T. Strothotte, Floating Points, Eurographics 2000.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from crowquill import glyphs as libraries
from crowquill import hilbert, measure, moments, relax
from crowquill.delaunay import triangulated
from crowquill.kernel import compiled
from crowquill.knobs import Choice, Numbers, Range, Text
from crowquill.marks import Marks
from crowquill.paths import Array, Index
from crowquill.sheet import Ink, Layer, Sheet, Step
from crowquill.stippling import NOMINAL, Clock, Plan, allowed, apart, dotted, expected_seconds, found, planned, settled, snapped, together
from crowquill.styles import Work
from crowquill.tone import Tone

EITHER = ("pen", "dots", "sizes")  # of which one is enough: who types one means to do without what a recipe has of the others
SPAN = (0.6, 1.6)  # smallest and largest dots over a pen that follows the tone: areas of 1 to 7
ENLARGED = (0.8, 1.25)  # of their own size, beyond which dots no longer look like ink of their nib
FULL = 0.9  # of the paper that circles fill when they hardly meet: equal ones at best 0.907
ROUNDS = 30  # of pushing; measured on mixes of two nibs, more brought nothing
MIXED = 0.2  # of the way between two nibs' areas in which chance decides; with 0.5 single large dots stood among small ones


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    pen: Annotated[float | None, Range(0.01, 50, "mm", "dot diameter; decides the number of dots (0.3mm)")] = None,
    dots: Annotated[int | None, Range(1, 100_000_000, "", "number of dots; decides their diameter")] = None,
    sizes: Annotated[tuple[float, ...] | None, Numbers(0.01, 50, "mm", "several nibs, small in the lights: 0.2mm,0.3mm,0.5mm")] = None,
    size_by: Annotated[
        str,
        Choice(("pen", "tone"), "dots as wide as pens, or by tone, 0.6 to 1.6 times the pen or between sizes"),
    ] = "pen",
    glyphs: Annotated[str | None, Text("library of dots: a name, or an SVG file (the nib nearest to the pen)", file=True)] = None,
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
    no ink          an empty sheet and a warning. Raises ValueError for more than max_dots, for a
                    pen wider than the canvas, and for pen and sizes together
    """
    clock = Clock()
    fixed = None if glyphs is None else libraries.load(glyphs)
    if fixed and pen is None and dots is None and sizes is None:
        pen = fixed.pen
    pens, span = _pens(pen, sizes, size_by)
    plan = planned(
        tone, pen=pen if sizes is None else max(sizes), dots=dots, span=span,
        white=white, white_rule=white_rule, min_gap=min_gap, max_dots=max_dots,
    )  # fmt: skip
    yield Step("plan", 0, 1, {"dots": plan.dots, "pen_mm": plan.pen, "seconds": expected_seconds(plan.dots, iterations)})
    chance = rng.spawn(3)
    state = yield from settled(
        plan.demand, plan.dots, chance[0], clock, start=start, iterations=iterations, until=until, step=step,
        exponent=exponent, banned=plan.white if white_rule == "before" else None,
    )  # fmt: skip
    sites, nib, width = _sized(state, plan, tone, pens, span, chance[2])
    sites, kept = snapped(sites, tone, plan.white)
    batches = [_batch(pen, sites[nib == k], kept[nib == k], width, fixed, chance[1]) for k, pen in enumerate(pens or (plan.pen,))]
    every = together([batch.marks for batch in batches])
    stay = apart(every, min_gap)
    batches = [replace(batch, marks=batch.marks.take(part)) for batch, part in zip(batches, _parted(stay, batches), strict=True)]
    yield Step("measure", 0, 1)
    ink = measure.ink(every.take(stay))
    clock.lap("measure")
    report = {
        **found(plan, len(sites), int(stay.sum()), ink),
        "removed_on_white": int(len(sites) - kept.sum()),
        "removed_for_gap": int(len(stay) - stay.sum()),
        "iterations": state.done,
        "energy": state.energy,
        "movement": state.movement,
        "seconds": clock.laps,
        **_told(batches),
    }
    report["warnings"] += _enlarged(batches) if pen or sizes or glyphs else []  # who asks for a number of dots asks for no nib
    # the finest first: over a broad nib's wet ink it would drag
    drawn = [batch for batch in batches if len(batch.marks)] or batches[:1]
    layers = tuple(Layer(Ink(), batch.marks, f"{batch.pen:.4g} mm" if len(pens) > 1 else "") for batch in drawn)
    return Sheet(tone.size, layers, report=report)


@dataclass(frozen=True)
class Batch:
    """The dots of one nib: its width in mm, the library they come from, and where they lie."""

    pen: float
    library: libraries.Library
    marks: Marks

    def told(self) -> dict[str, Any]:
        """What is reported of it; ink is the sum of areas, overlap not taken off; pen and scaling of the library where it says its own."""
        own = self.library.pen
        return {
            "pen_mm": self.pen,
            "marks": len(self.marks),
            "ink_mm2": float((self.marks.scale**2).sum()),
            "glyphs": self.library.name,
            "glyph_pen_mm": own,
            "glyph_scaling": self.pen / own if own else None,
        }


def _batch(
    pen: float, sites: Array, kept: npt.NDArray[np.bool_], width: Array | None, fixed: libraries.Library | None, rng: np.random.Generator
) -> Batch:
    """Dots of a nib of this width, or of widths of their own, from the library that is fixed or the nearest."""
    if width is not None and kept.any():
        pen = float(np.sqrt((width[kept] ** 2).mean()))
    library = fixed or libraries.load(libraries.nearest(pen))
    return Batch(pen, library, dotted(sites, library.glyphs, pen if width is None else width, rng).take(kept))


def _told(batches: list[Batch]) -> dict[str, Any]:
    """What is reported of the libraries: all names, and pen and scaling of the one that is scaled most."""
    parts = [batch.told() for batch in batches]
    worst = max(parts, key=lambda part: abs(np.log(part["glyph_scaling"] or 1)))
    return {
        "glyphs": ", ".join(dict.fromkeys(part["glyphs"] for part in parts)),
        "glyph_pen_mm": worst["glyph_pen_mm"],
        "glyph_scaling": worst["glyph_scaling"],
        "simulated": any(bool(batch.library.about.get("simulated", False)) for batch in batches),
        "sizes": parts,
    }


def _enlarged(batches: list[Batch]) -> list[str]:
    """What is to be said of dots that are drawn much larger or smaller than their nib draws them; one shape alone is no nib's."""
    said = []
    for batch in batches:
        part = batch.told()
        scaling = part["glyph_scaling"]
        if part["marks"] and scaling and not ENLARGED[0] <= scaling <= ENLARGED[1] and len(batch.library.glyphs) > 1:
            how = f"enlarged {scaling:.2g} times" if scaling > 1 else f"reduced to {scaling:.2g} of their size"
            said.append(
                f"dots of a {part['glyph_pen_mm']:g} mm nib drawn at {batch.pen:.3g} mm are {how}; ink of such a nib looks otherwise"
            )
    return said


def _pens(pen: float | None, sizes: tuple[float, ...] | None, size_by: str) -> tuple[tuple[float, ...], tuple[float, float]]:
    """The nibs to choose from, none where one will do or sizes are free, and the smallest and largest dots over the pen."""
    if sizes is None:
        return (), SPAN if size_by == "tone" else (1.0, 1.0)
    if pen is not None:
        raise ValueError(f"pen {pen:g} mm and sizes of {len(sizes)} nibs are both given; leave one out")
    nibs = tuple(sorted(set(sizes)))
    return nibs if size_by == "pen" and len(nibs) > 1 else (), (nibs[0] / nibs[-1], 1.0)


def _sized(
    state: relax.State, plan: Plan, tone: Tone, pens: tuple[float, ...], span: tuple[float, float], rng: np.random.Generator
) -> tuple[Array, Index, Array | None]:
    """Where dots go, the number of each one's nib, and its diameter in mm where that is free; one nib has all, where they are.

    Each dot's due is the ink of its cell. Dots are gone through along a Hilbert curve; what a dot takes less or more
    than is due is due to the next.
    """
    sites, nib = state.sites, np.zeros(len(state.sites), np.int64)
    if span[0] == span[1]:
        return sites, nib, None
    due = moments.of_tone(state.cells, plan.nominal).mass * NOMINAL[-1]
    order = np.flatnonzero(allowed(sites, tone, plan.white))
    order = order[hilbert.of_points(sites[order])]
    area = np.full(len(sites), np.pi / 4 * plan.largest**2)
    if not pens:
        _followed(due, order, np.pi / 4 * (plan.largest * span[0] / span[1]) ** 2, area)
        return sites, nib, 2 * np.sqrt(area / np.pi)
    areas = np.pi / 4 * np.array(pens) ** 2
    _handed_out(due, order, areas, 0.5 + MIXED * (rng.random(len(sites)) - 0.5), nib)
    fill = plan.nominal.at(sites) * NOMINAL[-1]
    return _eased(sites, np.array(pens)[nib] / 2, fill, tone, plan.white), nib, None


@compiled
def _handed_out(due: Array, order: Index, areas: Array, between: Array, nib: Index) -> None:
    """Gives each dot the nib nearest to its due; `between` is the share of the way from one area to the next where the next begins.

    No more than the area of the largest is carried on: what is not reached in one place must not show in another.
    """
    owed = 0.0
    for i in order:
        owed += due[i]
        k = 0
        while k + 1 < len(areas) and owed > areas[k] + between[i] * (areas[k + 1] - areas[k]):
            k += 1
        nib[i] = k
        owed = min(max(owed - areas[k], -areas[-1]), areas[-1])


@compiled
def _followed(due: Array, order: Index, least: float, area: Array) -> None:
    """Gives each dot its due as its area, from `least` to the area that it had; no more than that is carried on."""
    owed = 0.0
    for i in order:
        most = area[i]
        owed += due[i]
        area[i] = min(max(owed, least), most)
        owed = min(max(owed - area[i], -most), most)


def _eased(sites: Array, radius: Array, fill: Array, tone: Tone, banned: npt.NDArray[np.bool_]) -> Array:
    """Sites moved so that dots of unlike sizes share the room among them: the larger have more of it.

    Dots were relaxed as if they were equal. Each pushes its neighbours to where circles around them, grown or shrunk
    until they would fill 0.9 of the paper, hardly meet: then they overlap no more than equal dots do.

    radius  mm; fill the share of paper that such dots take up around each
    banned  (h, w) pixels that none may move onto; at their border and the canvas's, where nothing pushes back, dots nearly stay
    """
    if len(sites) < 2:
        return sites
    wide = radius * np.sqrt(FULL / np.maximum(fill, 1e-6))
    most = 0.8 * wide
    for turn in np.arange(8) * np.pi / 4:
        around = sites + 1.5 * wide[:, None] * (np.cos(turn), np.sin(turn))
        most = np.where(allowed(around, tone, banned), most, np.minimum(most, 0.1 * wide))
    low, high = sites.min(axis=0), sites.max(axis=0)
    moved = sites
    for round_ in range(ROUNDS):
        if round_ % 10 == 0:  # neighbours change little in ten rounds
            pairs, _ = triangulated(moved, (low + high) / 2, float(np.hypot(*(high - low)))).edges
        way = moved[pairs[:, 0]] - moved[pairs[:, 1]]
        length = np.maximum(np.hypot(*way.T), 1e-9)
        push = (np.maximum(wide[pairs].sum(axis=1) - length, 0) / 4 / length)[:, None] * way
        sums = [np.bincount(pairs[:, 0], part, len(sites)) - np.bincount(pairs[:, 1], part, len(sites)) for part in push.T]
        gone = moved + np.stack(sums, axis=1) - sites
        gone *= np.minimum(1, most / np.maximum(np.hypot(*gone.T), 1e-12))[:, None]
        moved = np.where(allowed(sites + gone, tone, banned)[:, None], sites + gone, moved)
    return moved


def _parted(stay: npt.NDArray[np.bool_], batches: list[Batch]) -> list[npt.NDArray[np.bool_]]:
    """A mask of all marks as one of each batch."""
    return np.split(stay, np.cumsum([len(batch.marks) for batch in batches])[:-1])
