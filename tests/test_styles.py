"""What every style promises, tried on every style there is; a new one is tested before it has a test."""

from __future__ import annotations

import importlib
import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely

import crowquill
from crowquill import Paths, Sheet, Tone, options, styles
from crowquill.knobs import Choice, Flag, Knob, Numbers, Range, Text
from crowquill.marks import Marks

STYLES = styles.names()
UM = 1e-3  # mm: lengths on a sheet are whole micrometres
RAMP = Tone(np.tile(np.linspace(0, 0.9, 80), (60, 1)), (40.0, 30.0))
LITTLE = RAMP.fitted(width=12.0)  # the same, where a few hundred dots will do


def box(x: float, y: float, width: float, height: float) -> shapely.Geometry:
    return shapely.box(x, y, x + width, y + height)


def spot(pixels: tuple[int, int], at: tuple[int, int]) -> np.ndarray[Any, Any]:
    coverage = np.zeros(pixels)
    coverage[at] = 1
    return coverage


SIZE = (20.0, 15.0)  # mm
PIXELS = (30, 40)
HALF = np.full(PIXELS, 0.5)
COARSE = np.full((6, 8), 0.5)  # pixels much larger than dots: an outline cuts most of what is drawn in them
DISTANCE = np.hypot(*np.meshgrid(np.arange(40) - 19.5, np.arange(30) - 14.5))  # pixels from the middle
STAR = shapely.Polygon([(10 + r * math.cos(k), 7.5 + r * math.sin(k)) for k in range(10) for r in [7.0 if k % 2 else 2.0]]).buffer(0)
DEGENERATE = {
    "one pixel": Tone([[0.5]], SIZE),
    "white": Tone(np.zeros(PIXELS), SIZE),
    "black": Tone(np.ones(PIXELS), SIZE),
    "constant grey": Tone(HALF, SIZE),
    "all lighter than any cutoff": Tone(np.full(PIXELS, 1e-6), SIZE),
    "one pixel of ink": Tone(spot(PIXELS, (12, 17)), SIZE),
    "one pixel of ink in the corner": Tone(spot(PIXELS, (29, 39)), SIZE),
    "a thin ring": Tone(((DISTANCE > 10) & (DISTANCE < 11.5)).astype(float), SIZE),
    "pixels black and white by turns": Tone(np.indices(PIXELS).sum(axis=0) % 2.0, SIZE),
    "one row of 400 pixels on 100 mm by a third": Tone(np.full((1, 400), 0.3), (100.0, 0.35)),
    "one column of 400 pixels on 1 mm by 100": Tone(np.full((400, 1), 0.3), (1.0, 100.0)),
    "a round canvas": Tone(COARSE, SIZE, shapely.Point(10, 7.5).buffer(7)),
    "a ring of canvas": Tone(COARSE, SIZE, shapely.Point(10, 7.5).buffer(7) - shapely.Point(10, 7.5).buffer(6)),
    "a canvas with two holes": Tone(HALF, SIZE, box(0, 0, 20, 15) - box(2, 2, 6, 6) - box(12, 3, 4, 9)),
    "two islands": Tone(HALF, SIZE, shapely.MultiPolygon([box(1, 1, 4, 4), box(12, 8, 7, 6)])),
    "islands that touch in a point": Tone(HALF, SIZE, shapely.MultiPolygon([box(0, 0, 10, 7.5), box(10, 7.5, 10, 7.5)])),
    "a canvas like a hair": Tone(HALF, SIZE, box(5, 0, 0.4, 15)),
    "a canvas inside one pixel": Tone(HALF, SIZE, box(5.05, 5.05, 0.35, 0.35)),
    "a star that crosses itself": Tone(HALF, SIZE, STAR),
    "ink only outside the canvas": Tone(np.repeat([[0.0, 1.0]], 20, axis=1).repeat(30, axis=0), SIZE, box(0, 0, 10, 15)),
}


def drawn_and_checked(style: str, tone: Tone, **knobs: Any) -> Sheet:
    """The sheet of a style, checked for all that must hold whatever the tone."""
    sheet = crowquill.draw(style, tone, **knobs)
    assert sheet.size == pytest.approx(tone.size, abs=UM)
    for layer in sheet.layers:
        outlines = layer.art.outlines() if isinstance(layer.art, Marks) else layer.art
        assert np.isfinite(outlines.xy).all()
        if isinstance(layer.art, Marks):
            assert np.isfinite(layer.art.scale).all() and (layer.art.scale > 0).all()
            out = ~tone.holds(layer.art.xy)
            assert not out.any(), f"{out.sum()} of {len(out)} marks outside the canvas, the first at {layer.art.xy[out][0]}"
    numbers = [value for value in sheet.report.values() if isinstance(value, float)]
    assert numbers and all(math.isfinite(number) for number in numbers)
    assert json.loads(json.dumps(dict(sheet.report))) == dict(sheet.report)
    return sheet


def area_of(rings: Paths) -> shapely.Geometry:
    """What rings enclose that nowhere cross: outlines, the holes in them, what lies in these, and so on."""
    return shapely.build_area(shapely.geometrycollections([shapely.LinearRing(ring) for ring in rings]))


def inked(sheet: Sheet) -> float:
    """The area that all layers cover together, mm^2, by shapely's union of outlines; rings with holes by their borders."""
    shapes = []
    for layer in sheet.layers:
        paths = layer.art.outlines() if isinstance(layer.art, Marks) else layer.art
        flat = paths.flat(UM / 10)
        if layer.ink.pen is None and (flat.areas < 0).any():
            shapes.append(area_of(flat))
        elif layer.ink.pen is None:
            shapes += list(flat.polygons())
        else:
            lines = [ring[[*range(len(ring)), 0]] if flat.closed else ring for ring in flat]
            shapes += [shapely.LineString(line).buffer(layer.ink.pen / 2) for line in lines]
    return float(shapely.union_all(shapes).area)


def bytes_of(sheet: Sheet) -> bytes:
    """What is drawn, without the recipe, which names the seed."""
    return crowquill.to_bytes(replace(sheet, recipe={}), "svg")


@pytest.mark.parametrize("style", STYLES)
def test_the_same_seed_gives_the_same_bytes_and_another_does_not(style):
    one, same, other = (bytes_of(crowquill.draw(style, LITTLE, seed=seed)) for seed in (1, 1, 2))
    assert one == same and one != other


def bound(style: str) -> float:
    """How far the ink of a style may be from what is asked: 1 % of it, or the INK of its module, which says why."""
    module = importlib.import_module(styles.style(style).__module__)
    return float(getattr(module, "INK", 0.01))


@pytest.mark.parametrize("style", STYLES)
def test_the_ink_on_paper_is_the_ink_asked_for(style):
    sheet = drawn_and_checked(style, RAMP)
    assert sheet.report["ink_asked_mm2"] == pytest.approx(RAMP.ink, rel=1e-3)  # what is lighter than a white cutoff may be left out
    ink = inked(sheet)
    assert ink == pytest.approx(RAMP.ink, rel=bound(style))  # the promise to every reader
    assert sheet.report["ink_placed_mm2"] == pytest.approx(ink, rel=1e-3)  # sampled to 1e-4, outlines snapped to 1 um


def test_a_style_is_held_to_one_percent_unless_it_states_a_bound(monkeypatch):
    assert bound("stipple") == 0.01
    monkeypatch.setattr("crowquill.styles.stipple.INK", 0.05, raising=False)
    assert bound("stipple") == 0.05


@pytest.mark.parametrize("style", STYLES)
def test_every_option_of_a_style_has_a_name_of_its_own(style):
    tables = [options.recipe.takes_of(table, style) for table in options.TABLES]
    names = [name for takes in tables for name in takes] + ["picture", "out", "seed", "recipe", "report", "quiet", "overwrite", "dry_run"]
    assert sorted(names) == sorted(set(names))


@pytest.mark.parametrize("style", STYLES)
def test_the_measured_ink_sees_art_that_is_missing(style):
    sheet = crowquill.draw(style, LITTLE)
    art = sheet.layers[0].art
    if isinstance(art, Paths) and len(art) < 20:  # one line through all: its last twentieth
        less = Paths.of([line[: -len(line) // 20] for line in art], closed=art.closed)
    elif isinstance(art, Paths) and art.closed and (art.areas < 0).any():  # rings in rings: the lowest twentieth of the sheet
        less, _ = Paths.of_polygons(shapely.intersection(area_of(art), shapely.box(0, 0, sheet.size[0], 0.95 * sheet.size[1])))
    else:
        less = art.take(np.flatnonzero(np.arange(len(art)) % 20))
    fewer = replace(sheet, layers=(replace(sheet.layers[0], art=less, fill=None), *sheet.layers[1:]))
    assert inked(fewer) < 0.98 * inked(sheet)  # a twentieth of the art is gone; where art overlaps, less of it shows
    assert inked(fewer) > 0.90 * inked(sheet)


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("name", DEGENERATE)
def test_an_awkward_tone_has_an_answer(style, name):
    tone = DEGENERATE[name]
    sheet = drawn_and_checked(style, tone)
    marks = sum(len(layer.art) for layer in sheet.layers)
    if tone.ink > 0.1 or tone.ink < 1e-3:  # mm2: ink for a dot or more, or next to none; between them either will do
        assert (marks > 0) == (tone.ink > 0.1)
    assert bool(sheet.report["warnings"]) or marks


@pytest.mark.parametrize("style", STYLES)
def test_the_report_has_what_all_reports_have(style):
    report = crowquill.draw(style, LITTLE, seed=5).report
    wanted = {"style", "version", "seed", "art_mm", "marks", "ink_asked_mm2", "ink_placed_mm2", "coverage_missing"}
    wanted |= {"iterations", "energy", "movement", "seconds", "warnings"}
    assert wanted <= set(report)
    assert (report["style"], report["seed"], report["art_mm"]) == (style, 5, [12.0, 9.0])


@pytest.mark.parametrize("style", STYLES)
def test_the_recipe_draws_the_same_sheet_again(style):
    sheet = crowquill.draw(style, LITTLE, seed=5)
    recipe = sheet.recipe
    again = crowquill.draw(recipe["style"], LITTLE, seed=recipe["seed"], **recipe["knobs"])
    given = {name for name, knob in styles.knobs(style).items() if knob.default is not None}  # the others are left to the style
    assert bytes_of(again) == bytes_of(sheet) and set(recipe["knobs"]) == given


@pytest.mark.parametrize("style", STYLES)
def test_steps_say_how_far_the_work_is_and_foretell_it_before_it_begins(style):
    work = styles.steps(style, LITTLE)
    first = next(work)
    assert first.facts["seconds"] >= 0 and all(math.isfinite(fact) for fact in first.facts.values())
    steps = [first, *work]
    assert len(steps) > 1 and all(0 <= step.done <= step.total and step.stage for step in steps)


@pytest.mark.parametrize("style", STYLES)
def test_work_can_be_left_at_any_step_and_begun_again(style):
    work = styles.steps(style, LITTLE)
    next(work), next(work)
    work.close()
    with pytest.raises(StopIteration):
        next(work)
    assert bytes_of(crowquill.draw(style, LITTLE)) == bytes_of(crowquill.draw(style, LITTLE))


@pytest.mark.parametrize("style", STYLES)
def test_the_docstring_names_its_source(style):
    module = importlib.import_module(styles.style(style).__module__)
    assert "Source:" in (module.__doc__ or "") and styles.summary(style) in (module.__doc__ or "")


KNOBS = [pytest.param(style, knob, id=f"{style}-{knob.name}") for style in STYLES for knob in styles.knobs(style).values()]
WHITE = DEGENERATE["white"]


def refusal(style: str, **knobs: Any) -> str:
    """What is said of a knob before any work is done."""
    with pytest.raises(ValueError) as error:
        styles.steps(style, WHITE, **knobs)
    return str(error.value)


@pytest.mark.parametrize(("style", "knob"), KNOBS)
def test_a_knob_takes_its_default_and_what_its_range_says_and_nothing_else(style: str, knob: Knob):
    takes = knob.takes
    styles.steps(style, WHITE, **{knob.name: knob.default}).close()
    if isinstance(takes, Choice):
        good, bad = list(takes.names), ["", "nonsense", takes.names[0].upper(), None, 1]
    elif isinstance(takes, Range):
        least = 1 if knob.whole else 1e-6 * (takes.high - takes.low)
        good = [takes.low, takes.high, int(takes.low) + 1 if knob.whole else (takes.low + takes.high) / 2]
        bad = [takes.low - least, takes.high + least, math.nan, math.inf, -math.inf, "1", True, []]
        bad += [takes.low + 0.5] if knob.whole else []
        bad += [] if knob.default is None else [None]
    elif isinstance(takes, Flag):
        good, bad = [True, False], [0, 1, "yes", None, []]
    elif isinstance(takes, Numbers):
        good = [(takes.low,), [takes.high, takes.low]] if takes.count is None else [(takes.low,) * takes.count]
        bad = [(), 1.0, "1", (takes.low - 1,) * (takes.count or 1), (math.nan,) * (takes.count or 2)]
    else:
        assert isinstance(takes, Text)
        good, bad = [], [1, True, []]
    for value in good:
        styles.steps(style, WHITE, **{knob.name: value}).close()
    for value in bad:
        said = refusal(style, **{knob.name: value})
        told = value[0] if isinstance(value, tuple) and value else value  # of several numbers the one that will not do
        assert knob.name in said and repr(told) in said and "; " in said, said


@pytest.mark.parametrize(("style", "knob"), KNOBS)
def test_a_knob_misspelt_is_answered_with_the_nearest(style, knob):
    said = refusal(style, **{knob.name + "q": knob.default})
    assert repr(knob.name + "q") in said and f"did you mean {knob.name}?" in said


@pytest.mark.parametrize("style", STYLES)
def test_a_knob_like_no_other_is_answered_with_all_there_are(style):
    said = refusal(style, zzzzzzzz=1)
    assert all(name in said for name in styles.knobs(style))


@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("seed", [-1, 1.5, "1", None, True, math.nan])
def test_a_seed_is_a_whole_number(style, seed):
    assert repr(seed) in refusal(style, seed=seed)


@pytest.mark.parametrize(("name", "answer"), [(STYLES[0] + "x", f"did you mean {STYLES[0]}?"), ("zzzz", STYLES[0])])
def test_a_style_there_is_not_is_answered_with_one_there_is(name, answer):
    with pytest.raises(ValueError, match=name) as error:
        crowquill.draw(name, WHITE)
    assert answer in str(error.value)
