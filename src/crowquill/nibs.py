"""Nibs: which pen draws which dot, of one width, of several, or as wide as the tone asks; and the sheet that comes of it.

What all styles of dots end with: dots kept off white and apart, measured, and told.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from crowquill import glyphs as libraries
from crowquill import hilbert, measure, moments, relax
from crowquill.delaunay import triangulated
from crowquill.kernel import compiled
from crowquill.knobs import Choice, Numbers, Range, Text
from crowquill.marks import Marks, together
from crowquill.paths import Array, Index
from crowquill.sheet import Ink, Layer, Sheet, Step
from crowquill.stippling import NOMINAL, Clock, Plan, allowed, apart, dotted, found, snapped
from crowquill.tone import Tone

SPAN = (0.6, 1.6)  # smallest and largest dots over a pen that follows the tone: areas of 1 to 7
ENLARGED = (0.8, 1.25)  # of their own size, beyond which dots no longer look like ink of their nib
NOTHING = Tone(np.zeros((1, 1)), (1.0, 1.0))
FULL = 0.9  # of the paper that circles fill when they hardly meet: equal ones at best 0.907
ROUNDS = 30  # of pushing; measured on mixes of two nibs, more brought nothing
MIXED = 0.2  # of the way between two nibs' areas in which chance decides; with 0.5 single large dots stood among small ones

# knobs that all styles of dots have
Pen = Annotated[float | None, Range(0.01, 50, "mm", "dot diameter; decides the number of dots (0.3mm)")]
Dots = Annotated[int | None, Range(1, 100_000_000, "", "number of dots; decides their diameter")]
Sizes = Annotated[tuple[float, ...] | None, Numbers(0.01, 50, "mm", "several nibs, small in the lights: 0.2mm,0.3mm,0.5mm")]
SizeBy = Annotated[str, Choice(("pen", "tone"), "dots as wide as pens, or by tone, 0.6 to 1.6 times the pen or between sizes")]
Glyphs = Annotated[str | None, Text("library of dots: a name, or an SVG file (the nib nearest to the pen)", file=True)]
White = Annotated[float, Range(0, 1, "", "no dots where coverage is below")]
MinGap = Annotated[float, Range(0, 100, "mm", "least white between dots; nearer ones are left out")]
MaxDots = Annotated[int, Range(1, 100_000_000, "", "refuse to draw more")]


@dataclass(frozen=True)
class Nibs:
    """What dots are drawn with.

    pen    mm, the widest dot that is asked for; None leaves it to the number of dots
    mixed  mm, the nibs to choose from, the finest first; none where one will do or sizes are free
    span   diameters of the smallest and the largest dots over `pen`
    fixed  the library of dots that is asked for; None takes the nearest to each nib
    asked  whether a nib or a library is asked for at all: who asks for a number of dots asks for no nib
    """

    pen: float | None
    mixed: tuple[float, ...]
    span: tuple[float, float]
    fixed: libraries.Library | None
    asked: bool

    @classmethod
    def of(
        cls, pen: float | None, glyphs: str | None, *, sizes: tuple[float, ...] | None = None, size_by: str = "pen", dots: int | None = None
    ) -> Nibs:
        """As the knobs of a style say. Raises ValueError for pen and sizes together, and for a library that there is not."""
        fixed = None if glyphs is None else libraries.load(glyphs)
        asked = bool(pen or sizes or glyphs)
        if sizes is None:
            pen = fixed.pen if fixed and pen is None and dots is None else pen
            return cls(pen, (), SPAN if size_by == "tone" else (1.0, 1.0), fixed, asked)
        if pen is not None:
            raise ValueError(f"pen {pen:g} mm and sizes of {len(sizes)} nibs are both given; leave one out")
        several = tuple(sorted(set(sizes)))
        mixed = several if size_by == "pen" and len(several) > 1 else ()
        return cls(several[-1], mixed, (several[0] / several[-1], 1.0), fixed, asked)


def inked(
    state: relax.State, plan: Plan, tone: Tone, nibs: Nibs, chance: list[np.random.Generator], clock: Clock, **facts: Any
) -> Generator[Step, None, Sheet]:
    """A Step, and a sheet with a layer of dots for each nib at the sites of a last state, off the plan's white and its gap apart.

    Who lets go of the state and the plan has their memory back before the dots are measured.

    chance  one for glyphs and turns, one for sizes
    facts   what else the report is to have; `warnings` are added to the others
    """
    sites, nib, width = _sized(state, plan, tone, nibs, chance[1])
    sites, kept = snapped(sites, tone, plan.white)
    plan = replace(plan, demand=NOTHING, nominal=NOTHING, white=np.zeros((1, 1), bool))
    moving = {"iterations": state.done, "energy": state.energy, "movement": state.movement}
    del state
    pens, removed = nibs.mixed or (plan.pen,), int(len(sites) - kept.sum())
    parts = ((pen, nib == k) for k, pen in enumerate(pens)) if nibs.mixed else ((plan.pen, slice(None)),)
    batches = [_batch(pen, sites[part], kept[part], width, nibs.fixed, chance[0]) for pen, part in parts]
    del sites, nib, kept, width
    stay = apart(together([batch.marks for batch in batches]), plan.gap)
    batches = [replace(batch, marks=batch.marks.take(part)) for batch, part in zip(batches, _parted(stay, batches), strict=True)]
    yield Step("measure", 0, 1)
    ink = measure.ink(together([batch.marks for batch in batches]))
    clock.lap("measure")
    told = found(plan, int(stay.sum()), ink)
    told["warnings"] += facts.pop("warnings", []) + (_enlarged(batches) if nibs.asked else [])
    report = {
        **told,
        "removed_on_white": removed,
        "removed_for_gap": int(len(stay) - stay.sum()),
        **moving,
        **facts,
        "seconds": clock.laps,
        **_told(batches),
    }
    # the finest first: over a broad nib's wet ink it would drag
    drawn = [batch for batch in batches if len(batch.marks)] or batches[:1]
    layers = tuple(Layer(Ink(), batch.marks, f"{batch.pen:.4g} mm" if nibs.mixed else "") for batch in drawn)
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


def _sized(state: relax.State, plan: Plan, tone: Tone, nibs: Nibs, rng: np.random.Generator) -> tuple[Array, Index, Array | None]:
    """Where dots go, the number of each one's nib, and its diameter in mm where that is free; one nib has all, where they are.

    Each dot's due is the ink of its cell. Dots are gone through along a Hilbert curve; what a dot takes less or more
    than is due is due to the next.
    """
    sites, nib = state.sites, np.zeros(len(state.sites), np.int64)
    (small, large), pens = nibs.span, nibs.mixed
    if small == large:
        return sites, nib, None
    due = moments.of_tone(state.cells, plan.nominal).mass * NOMINAL[-1]
    order = np.flatnonzero(allowed(sites, tone, plan.white))
    order = order[hilbert.of_points(sites[order])]
    area = np.full(len(sites), np.pi / 4 * plan.largest**2)
    if not pens:
        _followed(due, order, np.pi / 4 * (plan.largest * small / large) ** 2, area)
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
