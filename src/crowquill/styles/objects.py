"""Objects: a drawing of small shapes in place of dots, moved and turned until they lie evenly, larger and closer where it is darker.

Objects begin at equal shares of ink, and each moves to the centroid of the places nearest to its outline and turns as those lie.
Of these places each takes the ink as its own.
Source: S. Hiller, H. Hellwig, O. Deussen, Beyond Stippling, Computer Graphics Forum 22(3), 2003.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt

from crowquill import field as fields
from crowquill import likeness, moments, relax, shapes, vector
from crowquill.inertia import pooled
from crowquill.knobs import Choice, Flag, Range, Text
from crowquill.objects import Objects
from crowquill.paths import Array
from crowquill.settling import State
from crowquill.shapes import Library, clearance
from crowquill.shapes import ink as inks
from crowquill.sheet import Sheet, Step
from crowquill.stippling import CAP, NOMINAL, RENDERED, Clock, allowed, cut_white, expected_seconds, importance, widest
from crowquill.styles import Work
from crowquill.tone import Tone

INKS = False  # shapes make room for each other by their outlines, which moved dots would not
SIZE = 2.0  # mm
SPAN = (0.6, 1.4)  # smallest and largest objects over the size
GAP = 0.03  # of the size, between objects side by side
STAGES = (0.5, 0.8, 1.0)  # of their size that objects have while they settle: small ones untangle, large ones share the room
ALONG = 0.7  # of the size, over which the way of the picture is taken
SAMPLED = 0.3  # of the root of the mean area, between samples of outlines: coarser ones let others in between
FINER = 4  # pixels to a spacing, where tone is compared
PUSHED = 12  # rounds of making room
EVENED = 5  # rounds in which neighbours take over what an object cannot hold, each of so much over it had
EASE = (0.7, 1.4)
LIMITS = (0.3, 1.7)  # of its planned area, beyond which an object is not made smaller or larger
SHRUNK = 0.9  # of the length planned; below it is said
FINEST = 0.05  # of the size; smaller ones are left out
PAIRS = 1e7  # of objects within reach of each other; ticks have ten each
LEAST = 0.07  # mm^2 of ink, a dot of 0.3 mm, from which on there is an object
INK = 0.12  # grains side by side cover two thirds of the paper, and a ramp to 0.9 asks for more


def draw(
    tone: Tone,
    rng: np.random.Generator,
    *,
    objects: Annotated[str, Text("library of objects: a name, or an SVG file of shapes", file=True)] = "grains",
    size: Annotated[float | None, Range(0.05, 500, "mm", "mean length of objects; decides their number (2mm)")] = None,
    dots: Annotated[int | None, Range(1, 100_000_000, "", "number of objects; decides their size")] = None,
    size_by: Annotated[str, Choice(("tone", "drawn"), "larger where it is darker, or all as large as they were drawn")] = "tone",
    turn: Annotated[
        str, Choice(("field", "region", "free", "keep"), "along the picture, into their room, by chance, or as drawn")
    ] = "field",
    field: Annotated[str | None, Text("an SVG file of strokes laid over the drawing, along which objects turn", file=True)] = None,
    overlap: Annotated[bool, Flag("let objects overlap, so that they reach the darkest tones")] = False,
    min_gap: Annotated[float | None, Range(0, 100, "mm", "least white between objects (0.03 of the size)")] = None,
    inside: Annotated[str, Choice(("whole", "centre"), "what of an object must lie in the canvas")] = "whole",
    pen: Annotated[float, Range(0.01, 50, "mm", "width of the lines of objects that have lines")] = 0.2,
    iterations: Annotated[int, Range(0, 100_000, "", "most relaxation steps")] = 40,
    white: Annotated[float, Range(0, 1, "", "no objects where coverage is below")] = 0.02,
    max_dots: Annotated[int, Range(1, 100_000_000, "", "refuse to draw more")] = 200_000,
) -> Work:
    """A sheet the tone's size with a layer of marks for objects of one outline, and layers of paths for others and for lines.

    objects     see shapes.load; each is used as often as any other, and keeps its size beside the others'
    size_by     "tone": lengths follow the ink, about 0.6 to 1.4 times the size; "drawn": only their number does
    turn        "field": along the strokes of `field`, or without them the way in which the picture's tone changes least;
                "region", as published: each along the room it has
    overlap     left out, objects nowhere come nearer than min_gap: what then is too dark for them is `coverage_missing`
    inside      "whole" brings objects in that hang over, or makes them smaller; "centre" lets them
    importance  of the tone: objects are finer there; not with size_by="drawn"
    no ink      or less than a dot of 0.3 mm, an empty sheet and a warning. What finds no room at all is left out and
                counted in `removed`. Raises ValueError for size with dots, a field without turn="field", and over max_dots
    """
    clock = Clock()
    if size is not None and dots is not None:
        raise ValueError(f"size {size:g} mm and dots {dots} are both given; leave one out")
    if field is not None and turn != "field":
        raise ValueError(f"field {field!r} is of no use with turn {turn!r}; add --turn field, or leave it out")
    plan = _planned(tone, shapes.load(objects), size, dots, size_by == "tone", overlap, pen, white, min_gap)
    if plan.dots > max_dots:
        raise ValueError(f"the picture takes {plan.dots} objects, over the limit of {max_dots}; draw larger ones, or raise max-dots")
    if (plan.dots * plan.size) ** 2 > PAIRS * max(plan.asked.ink, LEAST):
        raise ValueError(
            f"{plan.dots} objects of {plan.size:.3g} mm are too thin for their length to be kept apart; give broader ones, or fewer"
        )
    yield Step("plan", 0, 1, {"dots": plan.dots, "size_mm": plan.size, "seconds": expected_seconds(24 * plan.dots, iterations)})
    chance = rng.spawn(2)
    sites = relax.scatter(plan.demand, plan.dots, chance[0])
    towards = _towards(tone, plan.size, field) if turn in ("region", "field") and len(sites) else None
    begun = _placed(plan, sites, turn, towards, chance[1])
    yield Step("place", 1, 1, {"dots": len(sites)})
    clock.lap("place")
    state, settled = yield from _settled(plan, begun, turn, towards if turn == "field" else None, iterations)
    clock.lap("relax")
    yield Step("fit", 0, 1)
    skirt = None if overlap else (GAP * plan.size if min_gap is None else min_gap) + plan.line
    settled = _roomy(settled, plan, skirt, inside == "whole")
    fitted = _sized(settled, _due(state, plan), plan, skirt, inside == "whole")
    fitted = fitted.take(fitted.scale > plan.least)
    clock.lap("fit")
    yield Step("measure", 0, 1)
    report: dict[str, Any] = {**_measured(fitted, plan), "removed": len(settled) - len(fitted)}
    clock.lap("measure")
    energy = float((state.moments.mass * np.trace(state.moments.covariance, axis1=1, axis2=2)).sum())
    report |= {"iterations": state.done, "energy": energy, "movement": state.movement, "seconds": clock.laps}
    report["warnings"] = _warnings(report, plan, overlap)
    return Sheet(tone.size, inks.layers(fitted, plan.library.motifs, pen), report=report)


@dataclass(frozen=True, eq=False)
class Plan:
    """Which objects, how many, and where they are wanted how large.

    asked   the ink that is wanted; `reached` is what of it objects can give, and `white` (h, w) are pixels that stay free of centres
    demand  where objects go, as a tone over its densest
    area    (h, w) mm^2 of a mean object at each pixel; share (k,) of that by object of the library
    size    mm, the mean length; least the scale of objects that are too small to be drawn
    """

    library: Library
    asked: Tone
    reached: Tone
    white: npt.NDArray[np.bool_]
    demand: Tone
    area: Array
    share: Array
    size: float
    least: float
    dots: int
    by_tone: bool
    pen: float

    @property
    def line(self) -> float:
        """The width of lines, mm; 0 where no object has any."""
        return self.pen if any(len(motif.lines) for motif in self.library.motifs) else 0.0

    def areas(self, objects: Objects) -> Array:
        """The area planned for each object where it lies, mm^2."""
        return np.asarray(self.area[self.demand.under(objects.xy)] * self.share[objects.shape])

    def of_ink(self, objects: Objects, ink: Array) -> Objects:
        """The objects, each with so many mm^2 of ink."""
        return inks.given(objects, self.library.motifs, self.pen, ink, self.least)


def _planned(
    tone: Tone,
    library: Library,
    size: float | None,
    dots: int | None,
    by_tone: bool,
    overlap: bool,
    pen: float,
    white: float,
    gap: float | None,
) -> Plan:
    """How many objects the tone takes: its coverage over the area of a mean object, which follows the tone around it."""
    from scipy.ndimage import gaussian_filter

    asked, blank = cut_white(tone, white)
    long = float(np.mean([motif.across for motif in library.motifs]))
    width = widest(tone, None, SIZE) if size is None else size
    wish = importance(tone) if by_tone else None
    for _ in range(3 if dots is not None else 1):
        each = np.array([motif.ink(width / long, pen) for motif in library.motifs])
        room = min(1.0, width * (1 + GAP) / (width + (gap or 0.0))) ** 2
        cap = CAP if overlap else clearance.packed(library.motifs, width / long, pen) * room
        sigma = [width / side for side in reversed(asked.pixel)]
        near = np.clip(gaussian_filter(np.minimum(asked.coverage, cap), sigma, mode="nearest", truncate=3.0), 1e-4, cap)
        swell = np.interp(near, RENDERED, NOMINAL) / near if overlap else 1.0
        grown = SPAN[0] ** 2 + (SPAN[1] ** 2 - SPAN[0] ** 2) * near / cap if by_tone else np.ones_like(near)
        area = each.mean() * grown / (1.0 if wish is None else wish**2)
        crowd = np.minimum(asked.coverage, cap) * swell / area
        most = max(float(crowd.max()), float(np.finfo(float).tiny))
        demand = Tone(crowd / most, asked.size, asked.canvas)
        wanted = demand.ink * most
        width *= float(np.sqrt(wanted / dots)) if dots is not None and wanted else 1.0
    count = 0 if asked.ink < LEAST else max(1, round(wanted)) if dots is None else dots
    reached = asked.mapped(lambda c: np.minimum(c, cap))
    area *= wanted / max(count, 1)
    return Plan(library, asked, reached, blank, demand, area, each / each.mean(), width, FINEST * width / long, count, by_tone, pen)


def _towards(tone: Tone, size: float, file: str | None) -> Callable[[Array], Array]:
    """Directions for places: along the strokes of a file, or along the picture."""
    drawn = None if file is None else fields.strokes(vector.contents(Path(file)), file, tone.size)
    found = drawn or fields.along(tone, ALONG * size).eased(ALONG * size)
    return lambda xy: found.at(xy)[0]


def _placed(plan: Plan, sites: Array, turn: str, towards: Callable[[Array], Array] | None, rng: np.random.Generator) -> Objects:
    """An object at each site, each as often as any other; turned by chance, as drawn, or one way or the other along the field."""
    motifs, n = plan.library.motifs, len(sites)
    shape = rng.permutation(np.arange(n) % len(motifs))
    angle = rng.uniform(0, 2 * np.pi, n)
    if turn == "keep":
        angle = np.array([motif.turn for motif in motifs])[shape]
    elif towards is not None:
        angle = towards(sites) + np.pi * rng.integers(0, 2, n)
    begun = Objects.of(sites, tuple(motif.shape for motif in motifs), angle=angle, shape=shape)
    return plan.of_ink(begun, plan.areas(begun))


def _settled(
    plan: Plan, objects: Objects, turn: str, towards: Callable[[Array], Array] | None, iterations: int
) -> Generator[Step, None, tuple[State, Objects]]:
    """Steps of objects that settle and, between stages, grow or shrink as their regions ask; the last state, and all off the white."""
    turns = 0.0 if turn in ("free", "keep") else 1.0
    done, area = 0, plan.areas(objects)
    fine = SAMPLED * float(np.sqrt(np.median(area))) if len(area) else None
    for stage, share in enumerate(STAGES, 1):
        full = plan.of_ink(objects, area)
        objects = replace(full, scale=share * full.scale)
        for state in relax.settle(objects, plan.demand, turn=turns, towards=towards, sampling=fine):
            state = replace(state, done=done + state.done)
            good = allowed(state.objects.xy, plan.asked, plan.white)
            objects = replace(state.objects, xy=np.where(good[:, None], state.objects.xy, objects.xy))
            yield Step("relax", state.done, iterations, {"movement": state.movement, "turning": state.turning})
            if state.done >= iterations * stage // len(STAGES) or state.at_rest or not len(objects):
                break
        done, area = state.done, _due(state, plan)
    return state, objects


def _due(state: State, plan: Plan) -> Array:
    """The ink of each object's region, mm^2, and no more or less of what was planned than LIMITS say."""
    planned = plan.areas(state.objects)
    if not plan.by_tone:
        return planned
    ink = pooled(moments.of_tone(state.cells, plan.reached), state.owner, len(planned), state.objects.xy).mass
    return np.clip(ink, LIMITS[0] * planned, LIMITS[1] * planned)


def _roomy(objects: Objects, plan: Plan, skirt: float | None, whole: bool) -> Objects:
    """The objects moved apart that are nearer than the skirt, and into the canvas: none further than half its length."""
    begun = objects.xy
    most = 0.5 * np.array([motif.across for motif in plan.library.motifs])[objects.shape] * objects.scale
    for _ in range(PUSHED if len(objects) else 0):
        way = objects.xy - begun
        way += clearance.pushed(objects, skirt) if skirt is not None else 0.0
        way += clearance.brought_in(objects, plan.asked.canvas) if whole else 0.0
        way *= np.minimum(1, most / np.maximum(np.hypot(*way.T), 1e-12))[:, None]
        good = allowed(begun + way, plan.asked, plan.white)
        objects = replace(objects, xy=np.where(good[:, None], begun + way, objects.xy))
    return objects


def _sized(objects: Objects, due: Array, plan: Plan, skirt: float | None, whole: bool) -> Objects:
    """The objects as large as the ink that is due to each, or as there is room for; what one cannot hold its neighbours take."""
    from scipy.ndimage import gaussian_filter

    if not len(objects):
        return objects
    tone = plan.reached
    spacing = float(np.sqrt(max(tone.ink, LEAST) / tone.coverage.max() / len(objects)))
    h, w = (int(np.clip(np.ceil(FINER * side / spacing), 1, 3000)) for side in reversed(tone.size))
    sigma = [spacing * h / tone.size[1], spacing * w / tone.size[0]]
    wanted = gaussian_filter(likeness.asked(tone, (h, w)), sigma, mode="constant")
    ink = due
    for _ in range(EVENED):
        fitted = plan.of_ink(objects, ink)
        if whole:
            fitted = replace(fitted, scale=np.maximum(clearance.held(fitted, tone.canvas, plan.line / 2), plan.least))
        if skirt is not None:
            fitted = replace(fitted, scale=np.maximum(clearance.clear(fitted, skirt), plan.least))
        if not plan.by_tone:
            break
        there = gaussian_filter(inks.covered(fitted, plan.library.motifs, plan.pen, tone.size, (h, w)), sigma, mode="constant")
        more = np.clip(wanted / np.maximum(there, 1e-6), *EASE)
        ink = np.clip(ink * fields.between(more, tone.size, objects.xy), LIMITS[0] * due, LIMITS[1] * due)
    return fitted


def _measured(objects: Objects, plan: Plan) -> dict[str, Any]:
    """What is reported of objects, of the ink they put on the paper together, and of what of it lies on other ink."""
    motifs = plan.library.motifs
    pairs, lost = inks.overlaps(objects, motifs, plan.pen)
    placed, asked = float(inks.of_each(objects, motifs, plan.pen).sum()) - lost, plan.asked.ink
    return {
        "marks": len(objects),
        "objects": plan.library.name,
        "size_mm": inks.length(objects, motifs) or plan.size,
        "size_planned_mm": inks.length(plan.of_ink(objects, plan.areas(objects)), motifs) or plan.size,
        "ink_asked_mm2": asked,
        "ink_placed_mm2": placed,
        "coverage_missing": max(0.0, 1 - placed / asked) if asked else 0.0,
        "overlaps": pairs,
        "overlap_mm2": lost,
    }


def _warnings(report: dict[str, Any], plan: Plan, overlap: bool) -> list[str]:
    """What is to be said of the library, the ink and the room."""
    said = list(plan.library.notes)
    if not plan.asked.ink:
        said.append("no ink: the picture is white, or lighter than the white cutoff, where it may be drawn on")
    elif not report["marks"]:
        said.append(f"no objects: all the ink is less than a dot of 0.3 mm, or there is no room for objects of {plan.size:.4g} mm")
    elif (missing := report["coverage_missing"]) > 0.02:
        wish = "objects of other shapes or lighter tones would help" if overlap else "--overlap or lighter tones would help"
        said.append(f"{missing:.1%} of the ink asked for is not reached; {wish}")
    if report["size_mm"] < SHRUNK * report["size_planned_mm"]:
        said.append(f"objects are {report['size_mm']:.3g} mm long in the mean, not {report['size_planned_mm']:.3g} as planned, to fit")
    if report["overlaps"] and not overlap:
        said.append(f"{report['overlaps']} pairs of objects overlap, by {report['overlap_mm2']:.3g} mm2; fewer or smaller ones would not")
    if report["removed"]:
        said.append(f"{report['removed']} objects found no room and were left out; fewer or smaller ones would")
    if plan.asked.importance is not None and not plan.by_tone:
        said.append("importance is not heeded: objects as large as drawn leave nothing to choose; size-by tone heeds it")
    return said
