"""Drawings in several inks, and reversed ones: any style's dots, an ink at a time, that keep clear of each other.

The picture is separated into a tone an ink, the style draws each, and its dots are moved apart; a screen's lattice stays, and is
turned instead, as presses do. Nothing is known here of how a style draws: marks are moved, all else stays.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Annotated, Any, TypeVar

import numpy as np
import shapely

from crowquill import inks as named
from crowquill import knobs, measure, mingling, reversal, separation, styles
from crowquill.knobs import Choice, Range, Text
from crowquill.marks import Marks, together
from crowquill.paths import Array
from crowquill.separation import DARK, Separation
from crowquill.sheet import Ink, Layer, Sheet, Step
from crowquill.stippling import PEN, Clock
from crowquill.styles import Work
from crowquill.tone import Tone

Values = Mapping[str, Any]
Curve = Callable[[Array], Array]
Found = TypeVar("Found")
Begin = Callable[[], Generator[Step, None, Found]]

SHARED = {"style", "version", "seed", "art_mm", "seconds", "warnings"}  # of all inks' reports
TURNS = (0.0, 30.0, -30.0, 45.0, 15.0, -15.0, 22.5, -22.5)  # degrees, of the darkest ink's screen and on to the lightest's
LIMIT = 3.0  # sheets of paper: what presses take
UNLIKE = 0.03  # of the light, on the mean: what is said of an error of colour
WHITE_SEED = 1000  # from the seed of black dots to that of white ones


def steps(
    style: str,
    tone: Tone,
    seed: int = 0,
    chosen: Values | None = None,
    curve: Curve | None = None,
    *,
    inks: Annotated[str | None, Text("draw in these: C,M,Y,K, or spot inks and colours: ochre=#c8922b,black; up to 8")] = None,
    ink_match: Annotated[str | None, Choice(("colour", "lightness"), "what inks shall match of the picture (colour)")] = None,
    ink_limit: Annotated[float | None, Range(0.5, 8, "", "most ink at one place, in sheets of paper (3)")] = None,
    black_for: Annotated[
        str | None, Choice(("darks", "greys"), "the darkest ink where lighter ones would meet, or greys in it alone (darks)")
    ] = None,
    reverse_from: Annotated[float | None, Range(0.2, 1, "", "white dots on solid ink where coverage is over this, such as 0.6")] = None,
) -> Work:
    """A style at work in several inks, or with reversed darks, or as by itself where neither is asked for; returns the Sheet.

    inks          a layer an ink, the lightest below, the others overprint; dots of one keep clear of those of others
    ink_match     "colour", in linear light; "lightness", whatever the colour: duotones, whose light inks carry the lights
    black_for     see separation.of_colour
    reverse_from  there each ink is solid, and the style's dots are holes in it
    chosen        knobs of the style; a number of dots is shared out by ink. curve is put on each ink's coverage

    The report has `inks`, what came of each, and of the colours `colour_error`, the mean in linear light, and `colour_lost`, the
    share of the drawing where it is over a tenth. An ink that finds nothing to draw has no layer, and that is said; so is it
    where no ink is dark, or colours are out of their reach. Raises ValueError for styles that cannot, and settings of no use.
    """
    given = {"ink_match": ink_match, "ink_limit": ink_limit, "black_for": black_for}
    own = knobs.checked(knobs.of(steps), {"inks": inks, "reverse_from": reverse_from, **given}, "inks")
    values = dict(chosen or {})
    if inks is None:
        for key, value in given.items():
            if value is not None:
                raise ValueError(f"{key.replace('_', '-')} is given for no inks; add inks, or leave it out")
        if reverse_from is None:
            return styles.steps(style, tone, seed=seed, **values)
    if not styles.says(style, "INKS", True) or styles.coloured(style):
        raise ValueError(f"style {style} draws in one way alone; leave out {'reverse-from' if inks is None else 'inks'}, or use stipple")
    if ink_match == "lightness" and (ink_limit is not None or black_for is not None):
        raise ValueError("ink-limit and black-for are for colours; leave them out, or match colour")
    if inks is not None:
        named.several(inks)
    styles.steps(style, tone, seed=seed, **values).close()  # all is checked before any work
    return _worked(style, tone, seed, values, curve, own)


@dataclass(frozen=True, eq=False)
class Drawn:
    """What a style drew in one ink: its sheet, and the tone that its dots draw, on the part of the canvas where they lie."""

    sheet: Sheet
    tone: Tone

    @property
    def marks(self) -> Marks:
        """All dots, in the order of their layers. Raises ValueError where the style drew something else."""
        found = [layer.art for layer in self.sheet.layers if isinstance(layer.art, Marks)]
        if not found:
            style = self.sheet.recipe["style"]
            raise ValueError(
                f"style {style} drew no dots: they alone keep clear of other inks, or turn white; choose a form, or a style, of dots"
            )
        return together(found)

    def moved(self, marks: Marks) -> Drawn:
        """The same with its dots where these are, and as large."""
        layers, at = [], 0
        for layer in self.sheet.layers:
            if isinstance(layer.art, Marks):
                part = slice(at, at := at + len(layer.art))
                layer = replace(layer, art=replace(layer.art, xy=marks.xy[part], scale=marks.scale[part]))
            layers.append(layer)
        dots_alone = all(isinstance(layer.art, Marks) for layer in layers)
        rest = 0.0 if dots_alone else self.sheet.report["ink_placed_mm2"] - measure.ink(self.marks)
        report = _filled({**self.sheet.report, "ink_placed_mm2": measure.ink(marks) + rest})
        return replace(self, sheet=replace(self.sheet, layers=tuple(layers), report=report))


def _worked(style: str, tone: Tone, seed: int, chosen: Values, curve: Curve | None, own: Values) -> Work:
    """The work of steps(), once all is checked."""
    dot = chosen.get("pen") or max(chosen.get("sizes") or (PEN,))
    if own["inks"] is None:
        (alone,) = yield from _in_turn({"": _work(style, tone, seed, chosen, own["reverse_from"], dot)})
        return _recorded(alone.sheet, style, seed, chosen, own)
    inks, turned, clock = named.several(own["inks"]), styles.says(style, "turned", None), Clock()
    parts = _separated(tone, inks, own, apart=turned is None)
    clock.lap("separate")
    tones = [part if curve is None else part.mapped(curve) for part in parts.tones]
    each = _dealt(chosen, [part.ink for part in tones])
    if turned is not None:
        each = [turned(one, turn) for one, turn in zip(each, reversed(TURNS[: len(inks)]), strict=True)]
    works = [_work(style, part, seed + k, one, own["reverse_from"], dot) for k, (part, one) in enumerate(zip(tones, each, strict=True))]
    found = yield from _in_turn(dict(zip([ink.name for ink in inks], works, strict=True)))
    last = Clock()
    if turned is None:
        gap = float(chosen.get("min_gap") or 0.0)
        marks = yield from mingling.mingled([one.marks for one in found], [one.tone for one in found], tone.canvas, gap)
        found = [one.moved(part) for one, part in zip(found, marks, strict=True)]
        last.lap("mingle")
    sheet = _together(inks, [one.sheet for one in found], parts)
    seconds = {**sheet.report["seconds"], **clock.laps, **last.laps}
    return _recorded(replace(sheet, report={**sheet.report, "seconds": seconds}), style, seed, chosen, own)


def _together(inks: Sequence[Ink], sheets: Sequence[Sheet], parts: Separation) -> Sheet:
    """The sheets of all inks as one: every layer in its ink, of which all but the lowest overprint, and one report."""
    layers = [_inked(layer, ink) for ink, sheet in zip(inks, sheets, strict=True) for layer in sheet.layers if len(layer.art)]
    layers = [replace(layer, ink=replace(layer.ink, overprint=layer.ink.name != layers[0].ink.name)) for layer in layers]
    reports = [sheet.report for sheet in sheets]
    report = {**_summed(reports), "colour_error": parts.error, "colour_lost": parts.lost, "warnings": _warnings(inks, reports, parts)}
    own = [{key: value for key, value in one.items() if key not in SHARED} for one in reports]
    report["inks"] = [{"ink": ink.name, **one} for ink, one in zip(inks, own, strict=True)]
    return replace(sheets[0], layers=tuple(layers), report=report)


def _separated(tone: Tone, inks: Sequence[Ink], own: Values, *, apart: bool) -> Separation:
    """What is asked of each ink."""
    if own["ink_match"] == "lightness":
        return separation.of_lightness(tone, inks, apart=apart)
    limit = LIMIT if own["ink_limit"] is None else own["ink_limit"]
    return separation.of_colour(tone, inks, limit=limit, apart=apart, greys=own["black_for"] == "greys")


def _work(style: str, tone: Tone, seed: int, chosen: Values, dark_from: float | None, dot: float) -> Begin[Drawn]:
    """How a style's work at one tone is begun, whose darks are reversed where it has any."""
    parts = None if dark_from is None else reversal.parted(tone, dark_from, dot)
    if parts is not None and parts.dark is not None:
        return partial(_reversed, style, parts, seed, chosen, dot)
    said = [] if parts is None else [f"nothing is reversed: no part a few dots wide covers over {dark_from:g}"]
    return partial(_plain, style, tone, seed, chosen, said)


def _plain(style: str, tone: Tone, seed: int, chosen: Values, said: list[str]) -> Generator[Step, None, Drawn]:
    """Steps of a style as it is, of which there is more to be said; returns what it drew."""
    sheet = yield from styles.steps(style, tone, seed=seed, **chosen)
    return Drawn(replace(sheet, report={**sheet.report, "warnings": [*sheet.report["warnings"], *said]}), tone)


def _reversed(style: str, parts: reversal.Parted, seed: int, chosen: Values, dot: float) -> Generator[Step, None, Drawn]:
    """Steps of a style at the dark and at the light part of a tone; returns what both together are."""
    assert parts.dark is not None
    halves = [(parts.dark, seed + WHITE_SEED), *([(parts.light, seed)] if parts.light else [])]
    each = _dealt(chosen, [half.ink for half, _ in halves])
    works = [partial(styles.steps, style, half, seed=at, **one) for (half, at), one in zip(halves, each, strict=True)]
    white, *black = yield from _in_turn(dict(zip(("white", "black"), works, strict=False)))
    holes = Drawn(white, parts.dark).marks
    area = reversal.cut(parts, holes, dot)
    nothing = replace(white, layers=(Layer(Ink(), holes.take(slice(0))),))
    rest = Drawn(black[0], halves[1][0]) if black else Drawn(nothing, parts.dark)
    told = _summed([sheet.report for sheet in (*black, white)])
    asked = float(shapely.area(parts.area)) - white.report["ink_asked_mm2"] + sum(sheet.report["ink_asked_mm2"] for sheet in black)
    told = {**rest.sheet.report, **told, "white_marks": len(holes), "ink_asked_mm2": asked}
    told["ink_placed_mm2"] = reversal.ink(area, rest.marks)
    layers = (Layer(Ink(), reversal.rings(area), "solid"), *(layer for layer in rest.sheet.layers if len(layer.art)))
    return Drawn(replace(rest.sheet, layers=layers, report=_filled(told)), rest.tone)


def _in_turn(works: Mapping[str, Begin[Found]]) -> Generator[Step, None, list[Found]]:
    """Steps of several works, one after another, by their names; what they foretell comes first, together. Returns what they return."""
    facts = {"dots": 0.0, "seconds": 0.0}
    for begin in works.values():
        work = begin()
        foretold = next(work).facts
        facts = {key: sum_ + foretold.get(key, 0.0) for key, sum_ in facts.items()}
        work.close()
    yield Step("plan", 0, 1, facts)
    found = []
    for name, begin in works.items():
        work = begin()  # anew: its clock does not run while others are at work
        while True:
            try:
                step = next(work)
            except StopIteration as stop:
                found.append(stop.value)
                break
            yield replace(step, stage=f"{name} {step.stage}".strip())
    return found


def _dealt(chosen: Values, inks: Sequence[float]) -> list[Values]:
    """The knobs of a style for each of several tones of so much ink, among which a number of dots is shared out."""
    if chosen.get("dots") is None:
        return [chosen] * len(inks)
    ends = np.round(np.cumsum(inks) / max(sum(inks), 1e-9) * chosen["dots"]).astype(np.int64)
    return [{**chosen, "dots": max(1, int(dots))} for dots in np.diff(ends, prepend=0)]


def _inked(layer: Layer, ink: Ink) -> Layer:
    """The layer in an ink. Raises ValueError for one that a style has in an ink of its own."""
    if layer.fill is not None or replace(layer.ink, pen=None, overprint=False) != Ink():
        raise ValueError(f"{layer.label!r} is drawn in an ink of its own, which is none of those asked for; leave out inks")
    return replace(layer, ink=replace(ink, pen=layer.ink.pen))


def _summed(reports: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """One report of several: counts, ink, energy and seconds are added up, and of iterations and movement the most is told."""
    sums: dict[str, Any] = {key: sum(one[key] for one in reports) for key in ("marks", "ink_asked_mm2", "ink_placed_mm2", "energy")}
    most = {key: max(one[key] for one in reports) for key in ("iterations", "movement")}
    seconds: dict[str, float] = {}
    for one in reports:
        for stage, time in one["seconds"].items():
            seconds[stage] = round(seconds.get(stage, 0.0) + time, 3)
    warnings = list(dict.fromkeys(said for one in reports for said in one["warnings"]))
    return _filled({**sums, **most, "seconds": seconds, "warnings": warnings})


def _filled(report: dict[str, Any]) -> dict[str, Any]:
    """The report with the share of its ink that is missing."""
    asked, placed = report["ink_asked_mm2"], report["ink_placed_mm2"]
    return {**report, "coverage_missing": max(0.0, 1 - placed / asked) if asked else 0.0}


def _warnings(inks: Sequence[Ink], reports: Sequence[Mapping[str, Any]], parts: Separation) -> list[str]:
    """What is to be said of each ink, and of how far their colours reach."""
    said = []
    if not any(report["marks"] for report in reports):
        return list(dict.fromkeys(one for report in reports for one in report["warnings"]))
    for ink, report in zip(inks, reports, strict=True):
        if report["marks"]:
            said += [f"{ink.name}: {one}" for one in report["warnings"]]
        else:
            said.append(f"{ink.name} has nothing to draw: it brings no colour of the picture nearer; leave it out, or match lightness")
    if parts.least > DARK:
        said.append(f"no ink is dark: all together leave {parts.least:.0%} of the light, and what is darker is as light; add black")
    elif parts.error > UNLIKE:
        said.append(
            f"these inks come no nearer to the picture than {parts.error:.2f} of the light on the mean, and {parts.lost:.0%} of it "
            "is off by over a tenth; add an ink of a colour that is missing"
        )
    return said


def _recorded(sheet: Sheet, style: str, seed: int, chosen: Values, own: Values) -> Sheet:
    """The sheet with the recipe of all of it, and the report with what all reports have."""
    recipe = styles.recipe(style, seed, chosen, sheet.size)
    shared = {key: recipe[key] for key in ("style", "version", "seed", "art_mm")}
    inks = {key: value for key, value in own.items() if value is not None}
    return replace(sheet, recipe={**recipe, "inks": inks}, report={**shared, **sheet.report, "seed": seed})
