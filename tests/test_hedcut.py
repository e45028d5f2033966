"""Hedcuts and isophotes: dots lie in rows along lines, off the lines, as large as the tone asks."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from PIL import Image
from scipy.spatial import cKDTree

import crowquill
from crowquill import Paths, Sheet, Tone, aligned, field, formats, judge, measure, seen
from crowquill.__main__ import main
from crowquill.marks import Marks
from crowquill.relax import State
from crowquill.stippling import Clock

SIZE = (40.0, 40.0)
SIDE = 240  # pixels
X, Y = np.meshgrid(*2 * [(np.arange(SIDE) + 0.5) * SIZE[0] / SIDE])
FROM = np.hypot(X - 20, Y - 20)  # mm from the middle
TURN = np.linspace(0, 2 * np.pi, 181)
CIRCLE = Paths.of([np.stack([20 + 11 * np.cos(TURN), 20 + 11 * np.sin(TURN)], axis=1)], closed=False)
DISC = Tone(np.where(FROM < 11, 0.55, 0.2) + 0.1 * np.sin(X / 3), SIZE)
WAVES = Tone(0.35 + 0.15 * np.sin(X / 3) * np.cos(Y / 4), SIZE)  # knows nothing of the circle: at its own edges dots line up by themselves
DARK = Tone(np.clip(0.9 - FROM / 30, 0, 1), SIZE)


def layer(sheet: Sheet, name: str) -> Any:
    return next((part for part in sheet.layers if part.label == name), None)


def lined(sheet: Sheet) -> shapely.Geometry:
    """What strokes cover."""
    strokes = layer(sheet, "lines")
    return shapely.union_all([shapely.LineString(line).buffer(strokes.ink.pen / 2, 32) for line in strokes.art])


def shapes(marks: Marks) -> Any:
    return marks.outlines().flat(1e-4).polygons()


@cache
def laid(reach: float, dots: int = 2500) -> tuple[aligned.Laid, field.Rows]:
    """Dots along rows beside a circle that nothing keeps them off."""
    begun = aligned.Setting.of(WAVES, pen=None, dots=dots, glyphs="disc", white=0.0, most=10**6)
    demand = aligned.squared(WAVES, begun.pitch / aligned.FINE)
    rows = field.Rows(field.distances(CIRCLE, SIZE, demand.coverage.shape), begun.pitch)
    work = aligned.laid(begun.planned(demand, dots), rows, begun.glyphs, np.random.default_rng(3), Clock(), reach=reach * begun.pitch)
    while True:
        try:
            next(work)
        except StopIteration as stop:
            return stop.value, rows


def off(marks: Marks, rows: field.Rows, within: float) -> float:
    """The median distance from the nearest row in pitches, of dots within so many pitches of the line."""
    near = rows.far.at(marks.xy) < within * rows.pitch
    return float(np.median(rows.off(marks.xy[near])) / rows.pitch)


def test_dots_lie_in_rows_near_a_line_and_anywhere_without_a_reach():
    (led, rows), (free, _) = laid(20.0), laid(0.0)
    assert off(led.marks, rows, 10) < 0.15 and led.off == pytest.approx(off(led.marks, rows, 10), abs=1e-9)
    assert off(free.marks, rows, 10) == pytest.approx(0.25, abs=0.02) and free.off == 0.25
    assert off(led.marks, rows, 3) < 0.05  # where the rows count for nearly all


def test_a_short_reach_leads_near_the_line_alone():
    led, rows = laid(4.0)
    far = rows.far.at(led.marks.xy) > 4 * rows.pitch
    assert off(led.marks, rows, 2) < 0.1
    assert np.median(rows.off(led.marks.xy[far])) / rows.pitch == pytest.approx(0.25, abs=0.03)


def towards(marks: Marks, within: float, rows: field.Rows) -> float:
    """Of dots near the circle, the share whose nearest neighbour lies within 15 degrees of the tangent: a sixth by chance."""
    near = np.flatnonzero(rows.far.at(marks.xy) < within * rows.pitch)
    other = cKDTree(marks.xy).query(marks.xy[near], 2)[1][:, 1]
    way, radial = marks.xy[other] - marks.xy[near], marks.xy[near] - (20, 20)
    angle = np.arctan2(way[:, 1], way[:, 0]) - np.arctan2(radial[:, 1], radial[:, 0]) - np.pi / 2
    return float((np.abs((angle + np.pi / 2) % np.pi - np.pi / 2) < np.pi / 12).mean())


def test_the_nearest_dot_lies_along_the_row():
    (led, rows), (free, _) = laid(20.0), laid(0.0)
    assert towards(led.marks, 5, rows) > 0.6 > 0.25 > towards(free.marks, 5, rows)


def test_the_last_step_leads_to_rows():
    led, _ = laid(20.0, dots=400)
    assert isinstance(led.state, State) and led.state.done == aligned.FREE + aligned.LED
    assert (led.state.done - 1 - aligned.FREE) % 2 == 1


def test_no_dot_touches_a_line():
    sheet = crowquill.draw("hedcut", DISC, dots=2500, black=1.0)
    assert sheet.report["lines"] >= 1 and len(sheet.marks) == 2500
    assert shapely.distance(lined(sheet), shapes(sheet.marks)).min() > 0
    assert shapely.distance(lined(sheet), shapely.points(sheet.marks.xy)).min() > 0.4 * sheet.report["pen_mm"] / 2
    assert sheet.report["rows_off"] < 0.15


def test_a_gap_keeps_dots_off_lines_in_the_lights():
    ring = Tone(np.where(np.abs(FROM - 11) < 0.3, 0.9, 0.25), SIZE)
    sheets = [crowquill.draw("hedcut", ring, pen=0.7, gap=gap) for gap in (0.0, 0.4)]
    least = [float(shapely.distance(lined(sheet), shapes(sheet.marks)).min()) for sheet in sheets]
    assert 0 < least[0] < 0.2 and least[1] > 0.4 * 0.75 - 0.02  # three quarters of it at a coverage of 0.25


def test_strokes_are_of_one_stated_width_on_the_canvas():
    round_ = Tone(DISC.coverage, SIZE, shapely.Point(20, 20).buffer(10.8))
    sheet = crowquill.draw("hedcut", round_, dots=800, line=0.5, detail=0.6)
    assert layer(sheet, "lines").ink.pen == 0.5 == sheet.report["line_mm"]
    assert lined(sheet).difference(round_.canvas.buffer(2e-3)).is_empty  # whole micrometres
    assert lined(sheet).area == pytest.approx(sheet.report["lines_mm2"], rel=1e-3)


def test_tone_is_kept_beside_lines_whose_ink_counts():
    sheet = crowquill.draw("hedcut", DISC, pen=0.5)
    assert sheet.report["ink_placed_mm2"] == pytest.approx(DISC.ink, rel=0.01)
    blurs = judge.of(seen.of_sheet(sheet), DISC).facts["tone"]["blurs"]
    assert abs(blurs[0]["bias"]) < 0.002 and blurs[1]["rmse"] < 0.01  # after two spacings; stippling has 0.006


def test_lines_too_dark_for_their_surroundings_are_told():
    pale = Tone(np.where(np.abs(FROM % 3 - 1.5) < 0.3, 0.12, 0.03), SIZE)
    sheet = crowquill.draw("hedcut", pale, pen=0.5, line=0.6, detail=1.0)
    assert sheet.report["ink_placed_mm2"] > 1.02 * pale.ink and any("darker than asked" in said for said in sheet.report["warnings"])


@cache
def dark() -> Sheet:
    return crowquill.draw("hedcut", DARK, pen=0.5, detail=0.9)


def test_white_dots_are_open_in_black_and_none_meet():
    areas = layer(dark(), "areas").art
    holes = areas.take(np.flatnonzero(areas.areas < 0)).polygons()
    black = shapely.union_all(areas.take(np.flatnonzero(areas.areas > 0)).polygons())
    assert len(holes) == dark().report["white_marks"] > 100
    assert shapely.within(holes, black).all()
    pairs = shapely.STRtree(holes).query(holes, "intersects")
    assert (pairs[0] == pairs[1]).all()
    assert black.area - shapely.area(holes).sum() == pytest.approx(areas.areas.sum(), rel=1e-6)


def test_ink_of_a_drawing_is_that_of_its_layers():
    areas = layer(dark(), "areas").art
    black = shapely.build_area(shapely.geometrycollections([shapely.LinearRing(ring) for ring in areas]))
    every = shapely.union_all([*shapes(dark().marks), black])
    assert dark().report["ink_placed_mm2"] == pytest.approx(every.area, rel=1e-3)  # there is no line outside the black
    assert dark().report["ink_placed_mm2"] == pytest.approx(DARK.ink, rel=0.01)
    assert measure.ink(dark().marks) < 0.95 * every.area


def test_black_of_1_has_none():
    sheet = crowquill.draw("hedcut", DARK, dots=300, black=1.0)
    assert layer(sheet, "areas") is None and sheet.report["white_marks"] == 0


@pytest.mark.parametrize("style", ["hedcut", "isophote"])
def test_a_number_of_dots_is_met_white_ones_among_them(style: str):
    sheet = crowquill.draw(style, DARK, dots=900)
    assert sheet.report["marks"] + sheet.report["left_out"] == 900 and sheet.report["left_out"] < 15
    both = crowquill.draw(style, DARK, dots=900, pen=0.2)
    assert both.report["marks"] + both.report["left_out"] == 900 and both.report["pen_mm"] < 0.3 < sheet.report["pen_mm"]


@pytest.mark.parametrize("style", ["hedcut", "isophote"])
def test_dots_are_larger_where_it_is_darker(style: str):
    ramp = Tone(np.clip(0.02 + X / 65, 0, 0.65), SIZE)
    marks = crowquill.draw(style, ramp, pen=0.5).marks
    wide = [2 * np.sqrt((marks.scale[np.abs(marks.xy[:, 0] - x) < 3] ** 2).mean() / np.pi) for x in (5, 15, 25, 35)]
    assert wide == sorted(wide) and wide[3] > 1.5 * wide[0]
    assert wide[0] >= 0.4 * 0.5 and wide[3] <= 1.4 * 0.5


def test_lines_may_be_left_undrawn():
    sheet = crowquill.draw("hedcut", DISC, dots=900, line=0.0)
    assert layer(sheet, "lines") is None and sheet.report["lines_mm2"] == 0 and sheet.report["rows_off"] < 0.15


def test_a_picture_without_lines_is_dots_alone_and_says_so():
    for style in ("hedcut", "isophote"):
        sheet = crowquill.draw(style, Tone(np.full((30, 30), 0.4), SIZE), dots=400)
        assert len(sheet.marks) == 400 and any(" were found: dots lie evenly" in said for said in sheet.report["warnings"])


def test_thin_lines_are_kept_better_than_by_stippling():
    thin = 0.15 + 0.25 * X / 40
    for k in range(6):
        thin = np.where(np.abs(FROM - 2 - 3.2 * k) < 0.12, 0.85, thin)
    tone = Tone(thin, SIZE)
    kept = {style: judge.of(seen.of_sheet(crowquill.draw(style, tone, dots=5000)), tone).facts["tone"]["edges_kept"] for style in STYLES}
    assert kept["hedcut"] > kept["stipple"] and kept["isophote"] > kept["stipple"]


STYLES = ("stipple", "hedcut", "isophote")


def test_importance_makes_dots_finer():
    wish = Tone(np.full((SIDE, SIDE), 0.4), SIZE, importance=(X > 20).astype(float))
    marks = crowquill.draw("isophote", wish, pen=0.8).marks
    left, right = ((marks.xy[:, 0] < 20).sum(), (marks.xy[:, 0] > 20).sum())
    assert right > 1.5 * left


def ridges(levels: int) -> tuple[Sheet, float]:
    """A drawing of a wavy hill, and the share of its dots within a quarter of a row of its isophotes."""
    hill = Tone(np.clip(0.75 - FROM / 30 + 0.05 * np.sin(X / 2), 0, 1), SIZE)
    sheet = crowquill.draw("isophote", hill, dots=1500, levels=levels, detail=0.0)
    pitch = sheet.report["rows_mm"]
    lines = [shapely.LineString(line) for border in field.isophotes(hill, levels, pitch, least=8 * pitch) for line in border]
    far = shapely.distance(shapely.union_all(lines), shapely.points(sheet.marks.xy))
    return sheet, float((far < pitch / 4).mean())


def test_more_levels_bring_more_dots_near_an_isophote():
    found = [ridges(levels) for levels in (2, 4, 8)]
    shares = [share for _, share in found]
    assert shares[0] < shares[1] < shares[2] and all(sheet.report["rows_off"] < 0.15 for sheet, _ in found)


def grey(name: str, values: Any) -> str:
    Image.fromarray(np.round(255 * values).astype(np.uint8)).save(name)
    return name


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    grey("flat.png", np.full((60, 80), 0.5))
    grey("hill.png", np.clip(1 - np.hypot(*np.meshgrid(np.arange(160) - 80, np.arange(120) - 60)) / 90, 0, 1))
    grey("square.png", np.full((60, 60), 0.5))
    return tmp_path


def test_a_map_of_depth_leads_dots_where_the_picture_says_nothing():
    flat = Tone(np.full((60, 80), 0.4), (40, 30))
    sheet = crowquill.draw("isophote", flat, dots=1200, depth="hill.png")
    assert sheet.report["isophotes"] >= 5 and sheet.report["rows_off"] < 0.15 and not sheet.report["warnings"]


QUICK = ["--paper", "60x50mm", "--margin", "5mm", "--width", "40mm", "--quiet"]


def test_a_drawing_with_depth_is_made_again_to_the_byte():
    assert main(["isophote", "flat.png", "a.svg", "--tone", "grey", "--dots", "300", "--depth", "hill.png", *QUICK]) == 0
    assert formats.load("a.svg").recipe["sources"]["depth"]["name"] == "hill.png"
    assert main(["redo", "a.svg", "b.svg", "--quiet"]) == 0 and Path("a.svg").read_bytes() == Path("b.svg").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (("isophote", "--depth", "square.png"), "square.png: is 60 x 60 pixels, and the drawing 40 x 30 mm; give a map of its shape"),
        (("isophote", "--depth", "none.png"), "none.png"),
        (("isophote", "--depth", "hill"), "no depth 'hill'; give a picture file"),
        (("hedcut", "--line", "0mm", "--gap", "1mm"), "gap 1 mm is of no use to lines of no width; leave one out"),
        (("hedcut", "--line", "45mm"), "wider than the canvas"),
        (("hedcut", "--pen", "45mm"), "wider than the canvas"),
        (("isophote", "--pen", "0.1mm", "--max-dots", "100"), "over the limit of 100"),
    ],
    ids=lambda part: " ".join(part) if isinstance(part, tuple) else "",
)
def test_what_cannot_be_drawn_is_refused_in_one_line(arguments: tuple[str, ...], why: str, capsys: pytest.CaptureFixture[str]):
    assert main([arguments[0], "flat.png", "a.svg", *arguments[1:], "--tone", "grey", *QUICK]) == 2
    said = capsys.readouterr().err
    assert said.startswith("crowquill: ") and said.count("\n") == 1 and why in said and not Path("a.svg").exists()


def test_ink_is_handed_on_nearby_and_none_is_lost():
    grey = Tone(np.full((60, 60), 0.4), (30, 30))
    free = np.ones((60, 60), bool)
    free[:, 28:32] = False
    spent = np.zeros((60, 60))
    spent[:, 29:31] = 0.5
    given = aligned.handed_on(grey, spent, free, 1.5)
    assert given.ink == pytest.approx(grey.ink - spent.sum() / 4, rel=1e-9)
    assert given.coverage[~free].max() == 0 and given.coverage[:, :18] == pytest.approx(0.4)
    more = aligned.handed_on(grey, 3 * spent, free, 1.5)
    assert more.ink == pytest.approx(grey.ink - 3 * spent.sum() / 4, rel=1e-9) and more.coverage.min() >= 0
    assert more.coverage[:, 26].max() < 0.4 < given.coverage[:, 26].min()  # lines gave too much, and too little


def test_ink_that_has_no_place_nearby_is_let_go():
    lone = Tone(np.pad(np.full((4, 4), 0.5), 20), (22, 22))
    assert aligned.handed_on(lone, np.zeros((44, 44)), np.zeros((44, 44), bool), 1.0).ink == 0


def test_squares_keep_the_ink_whatever_their_size():
    for side in (0.05, 0.3, 1.1, 50.0):
        assert aligned.squared(DISC, side).ink == pytest.approx(DISC.ink, rel=1e-9)
    assert aligned.squared(DISC, 1e-6).coverage.size <= 1.01 * aligned.MOST
