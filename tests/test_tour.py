"""The tour style's own bars: one line, unbroken, that crosses itself nowhere and has as much ink as asked."""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import shapely

import crowquill
from crowquill import Paths, Sheet, Tone, raster
from crowquill.route.crossings import crossings
from crowquill.styles.tour import FLAT, _bends, _corrected, inked

Array = npt.NDArray[np.float64]
FORMS: list[dict[str, Any]] = [
    {"closed": closed, "rounded": rounded, "width_by": width}
    for closed, rounded, width in itertools.product((False, True), (False, True), ("pen", "tone"))
]
EVERY = pytest.mark.parametrize("form", FORMS, ids=lambda form: " ".join(str(value) for value in form.values()))
ISLANDS = shapely.MultiPolygon([shapely.box(1, 1, 5, 5), shapely.box(12, 8, 19, 14)])


def grey(coverage: float, canvas: shapely.Geometry | None = None) -> Tone:
    return Tone(np.full((30, 40), coverage), (20.0, 15.0), canvas)


def ramp(low: float, high: float) -> Tone:
    return Tone(np.tile(np.linspace(low, high, 80), (60, 1)), (40.0, 30.0))


def tour(tone: Tone, **knobs: Any) -> Sheet:
    return crowquill.draw("tour", tone, **knobs)


def strokes(sheet: Sheet) -> list[Array]:
    """All strokes of all layers in straight pieces; rings end where they begin."""
    found = []
    for layer in sheet.layers:
        assert isinstance(layer.art, Paths)
        found += [np.concatenate([line, line[:1]]) if layer.art.closed else line for line in layer.art.flat(FLAT)]
    return found


def crossed(sheet: Sheet) -> int:
    lines = strokes(sheet)
    return len(crossings(np.concatenate([line[:-1] for line in lines]), np.concatenate([line[1:] for line in lines])))


@EVERY
def test_the_strokes_are_one_line_that_crosses_nowhere(form):
    sheet = tour(ramp(0.1, 0.7), pen=0.4, **form)
    assert sheet.report["sites"] > 500 and crossed(sheet) == 0
    if form["width_by"] == "pen":
        assert len(strokes(sheet)) == sheet.report["marks"] == 1
    else:
        widths = [layer.ink.pen for layer in sheet.layers]
        assert len(widths) > 4 and widths == sorted(widths) and 0.2 <= widths[0] < widths[-1] <= 0.6
    ends = Counter(tuple(line[k].tolist()) for line in strokes(sheet) for k in (0, -1))
    loose = [place for place, count in ends.items() if count == 1]
    assert set(ends.values()) <= {1, 2} and len(loose) == (0 if form["closed"] else 2)
    joined = shapely.line_merge(shapely.MultiLineString(strokes(sheet)))
    assert joined.geom_type == "LineString" and joined.is_closed == form["closed"]  # unbroken
    assert joined.length == pytest.approx(sheet.report["length_mm"], rel=1e-3)  # curves are flattened otherwise there


@EVERY
@pytest.mark.parametrize("name", ["one pixel of ink", "islands", "hair", "black", "white", "two sites", "three sites"])
def test_every_form_has_an_answer_where_it_is_awkward(form, name):
    spot = np.zeros((30, 40))
    spot[12, 17] = 1
    few = {"two sites": {"dots": 2}, "three sites": {"dots": 3}}.get(name, {"pen": 0.3})
    tone = {
        "one pixel of ink": Tone(spot, (20.0, 15.0)),
        "islands": grey(0.4, ISLANDS),
        "hair": grey(0.5, shapely.box(5, 0, 5.4, 15)),
        "black": grey(1.0),
        "white": grey(0.0),
    }.get(name, grey(0.3))
    sheet = tour(tone, **form, **few)
    assert bool(sheet.report["marks"]) == (name != "white")
    there_and_back = name == "hair" and form["closed"]  # its sites lie in one row, which a ring must cover twice
    assert name == "white" or there_and_back or crossed(sheet) == 0
    assert sheet.report["sites"] == few.get("dots", sheet.report["sites"])


@EVERY
def test_the_ink_is_what_is_asked_and_what_shapely_joins(form):
    tone = ramp(0.1, 0.8)
    sheet = tour(tone, pen=0.4, **form)
    assert sheet.report["ink_placed_mm2"] == pytest.approx(tone.ink, rel=0.01)
    areas = []
    for layer in sheet.layers:
        assert isinstance(layer.art, Paths) and layer.ink.pen is not None
        lines = [np.concatenate([line, line[:1]]) if layer.art.closed else line for line in layer.art.flat(1e-3)]
        areas += [shapely.LineString(line).buffer(layer.ink.pen / 2) for line in lines]
    assert sheet.report["ink_placed_mm2"] == pytest.approx(shapely.union_all(areas).area, rel=2e-3)


@pytest.mark.parametrize("width", ["pen", "tone"])
def test_a_ramp_keeps_its_tone_in_every_band(width):
    tone = ramp(0.1, 0.8)
    cover = sum(
        raster.covered(layer.art, (60, 80), pixel=(0.5, 0.5), pen=layer.ink.pen, lines=32)
        for layer in tour(tone, pen=0.2, width_by=width).layers
    )
    bands = np.asarray(cover)[3:-3, 2:-2].reshape(54, 4, 19).mean(axis=(0, 2))
    asked = tone.coverage[0, 2:-2].reshape(4, 19).mean(axis=1)
    # widths are summed, so that joins between them count twice: some 2 %
    assert np.abs(bands - asked).max() <= 0.04, f"bands {bands.round(4)} of {asked.round(4)}"


def test_sites_lie_on_the_canvas_and_the_line_between_islands_is_told():
    sheet = tour(grey(0.4, ISLANDS))
    (line,) = strokes(sheet)
    inside = shapely.contains_xy(shapely.buffer(ISLANDS, 1e-3), *line.T)
    assert inside.all()  # straight: its points are the sites
    gap = shapely.LineString(line).difference(ISLANDS).length
    assert gap > 7.6  # mm from corner to corner; a line with two ends may cross the gap once
    assert sheet.report["outside_mm"] == pytest.approx(gap, abs=0.5)  # seen every half pixel
    assert tour(grey(0.4)).report["outside_mm"] == 0


def test_dots_give_the_number_of_sites_and_one_is_no_line():
    assert tour(grey(0.4), dots=200).report["sites"] == 200
    one = tour(grey(0.4), dots=1)
    assert one.report["marks"] == 0 and "no line" in one.report["warnings"][0]


def test_black_and_importance_are_told_and_too_many_sites_are_refused():
    report = tour(grey(1.0)).report
    assert report["coverage_missing"] == pytest.approx(0.1, abs=0.01) and "not reached" in report["warnings"][0]
    weighed = tour(replace(grey(0.3), importance=np.linspace(0, 1, 1200).reshape(30, 40)))
    assert "importance is not heeded" in weighed.report["warnings"][0]
    with pytest.raises(ValueError, match="over the limit of 100"):
        tour(grey(0.5), max_dots=100)
    with pytest.raises(ValueError, match="wider than the canvas"):
        tour(grey(0.5), pen=16)


def test_bends_ease_where_they_would_cross():
    """A sharp turn beside another: bent as far as they go, one would run over the other."""
    line = np.array([(0, 0), (4, 0), (8, 6), (8.2, 6), (4.4, 0), (20, 0), (20, 10), (8.1, 6.02), (0, 10)], float)
    b, c = np.split(_bends(line, False), 2, axis=1)
    control = np.concatenate([np.stack([line[:-1], b[:, 0], c[:, 0]], axis=1).reshape(-1, 2), line[-1:]])
    flat = Paths.of([control], closed=False, cubic=True).flat(FLAT).xy
    assert len(crossings(flat[:-1], flat[1:])) == 0
    assert (np.hypot(*(b[:, 0] - line[:-1]).T) > 0).any()


def test_the_crossing_check_sees_a_line_that_crosses():
    knot = Paths.of([[(0, 0), (4, 4), (4, 0), (0, 4)]], closed=False)
    sheet = tour(grey(0.3), dots=3)
    assert crossed(replace(sheet, layers=(replace(sheet.layers[0], art=knot),))) == 1


def test_the_ink_of_strokes_of_several_pens_is_counted_once():
    line = Paths.of([[(0, 0), (10, 0)]], closed=False)
    assert inked([(0.5, line), (1.0, line)]) == pytest.approx(10 + np.pi / 4, rel=1e-3)
    assert inked([]) == 0


def test_the_number_of_sites_is_corrected_towards_the_ink():
    first = _corrected([(4000, 50.0)], 60.0)
    assert first == 5760 and _corrected([(4000, 50.0), (5760, 58.0)], 60.0) > 5760
    assert _corrected([(10, 1e-9)], 60.0) == 20 and _corrected([(2, 1e9)], 60.0) == 2
