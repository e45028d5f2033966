"""Dots of several sizes: tone by bands, small in the lights, who gets which nib and library, and what importance asks for."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import shapely
from scipy.spatial import cKDTree

import crowquill
from crowquill import Marks, Sheet, Tone, glyphs, measure
from crowquill.marks import together
from crowquill.nibs import _eased, _followed, _handed_out

Array = npt.NDArray[np.float64]
NIBS = (0.2, 0.3, 0.5)
EVERY = [{"sizes": NIBS}, {"size_by": "tone", "sizes": (0.2, 0.5)}, {"size_by": "tone", "pen": 0.3}]
NAMES = ["three nibs", "free between two", "free about a pen"]


def ramp(width: float, height: float, low: float = 0.0, high: float = 0.9) -> Tone:
    columns, rows = round(5 * width), round(5 * height)
    steps = low + (high - low) * (np.arange(columns) + 0.5) / columns
    return Tone(np.tile(steps, (rows, 1)), (width, height))


def grey(coverage: float, width: float = 20.0, height: float = 15.0) -> Tone:
    return Tone(np.full((30, 40), coverage), (width, height))


def stipple(tone: Tone, **knobs: Any) -> Sheet:
    return crowquill.draw("stipple", tone, **knobs)


def dots(sheet: Sheet) -> Marks:
    return together([layer.art for layer in sheet.layers])


def diameters(marks: Marks) -> Array:
    return np.asarray(2 * marks.scale / math.sqrt(math.pi))


@pytest.fixture(scope="module", params=EVERY, ids=NAMES)
def banded(request) -> Sheet:
    return stipple(ramp(120.0, 40.0), **request.param)


def test_a_ramp_keeps_its_tone_in_every_band_and_dots_grow_with_it(banded):
    tone, marks = ramp(120.0, 40.0), dots(banded)
    cover = measure.rendered(marks, tone.size, (40, 120))
    bands, asked = cover.mean(axis=0).reshape(10, 12).mean(axis=1), tone.coverage.mean(axis=0).reshape(10, 60).mean(axis=1)
    assert np.abs(bands - asked).max() <= 0.02, f"bands {bands.round(4)} of {asked.round(4)}"
    assert abs(bands.mean() - asked.mean()) <= 0.005
    band = np.minimum(marks.xy[:, 0] // 12, 9)
    mean = [diameters(marks)[band == k].mean() for k in range(10)]
    assert (np.diff(mean) > 0).all() and mean[9] > 1.8 * mean[0]


def test_the_report_tells_marks_and_ink_of_each_size(banded):
    report = banded.report
    assert sum(size["marks"] for size in report["sizes"]) == report["marks"] == len(dots(banded))
    areas = sum(size["ink_mm2"] for size in report["sizes"])
    assert areas == pytest.approx((dots(banded).scale ** 2).sum(), rel=0.005)  # scales on a sheet are whole micrometres
    assert areas >= report["ink_placed_mm2"]  # dots overlap


def test_each_nib_has_its_layer_small_first_and_its_library():
    sheet = stipple(ramp(30.0, 20.0), sizes=(0.5, 0.2, 0.3, 0.2))
    assert [layer.label for layer in sheet.layers] == ["0.2 mm", "0.3 mm", "0.5 mm"]
    for layer, pen, told in zip(sheet.layers, NIBS, sheet.report["sizes"], strict=True):
        assert math.sqrt((diameters(layer.art) ** 2).mean()) == pytest.approx(pen, rel=0.01)  # hundreds of dots that vary by 7 %
        assert (told["pen_mm"], told["marks"]) == (pen, len(layer.art))
        assert told["glyphs"] == glyphs.nearest(pen) and told["glyph_scaling"] == pytest.approx(pen / told["glyph_pen_mm"])


def test_sizes_that_follow_the_tone_are_one_layer_within_their_span():
    sheet = stipple(ramp(30.0, 20.0), size_by="tone", pen=0.3)
    assert len(sheet.layers) == 1
    found = diameters(sheet.marks)
    assert found.min() >= 0.6 * 0.3 - 2e-3 and found.max() <= 1.6 * 0.3 + 2e-3  # scales are rounded to micrometres
    assert len(np.unique(found)) > 100


def test_one_nib_of_sizes_is_a_pen_and_a_nib_too_much_is_refused():
    one, same = stipple(grey(0.3), sizes=(0.3,)), stipple(grey(0.3), pen=0.3)
    assert (one.marks.xy == same.marks.xy).all() and (one.marks.scale == same.marks.scale).all()
    with pytest.raises(ValueError, match=r"pen 0.3 mm and sizes .* leave one out"):
        stipple(grey(0.3), pen=0.3, sizes=NIBS)
    with pytest.raises(ValueError, match="wider than the canvas"):
        stipple(grey(0.3), sizes=(0.2, 20))


@pytest.mark.parametrize("knobs", EVERY, ids=NAMES)
@pytest.mark.parametrize("rule", ["before", "after"])
def test_no_dot_of_any_size_stands_on_white_or_outside_the_canvas(knobs, rule):
    coverage = np.tile(np.linspace(-0.2, 0.6, 80).clip(0), (60, 1))
    coverage[10:20, 50:60] = 0.01
    tone = Tone(coverage, (20.0, 15.0), shapely.Point(10, 7.5).buffer(7) - shapely.box(8, 7, 12, 15))
    marks = dots(stipple(tone, white_rule=rule, **knobs))
    assert len(marks) > 100 and tone.holds(marks.xy).all() and (tone.at(marks.xy) >= 0.02).all()


@pytest.mark.parametrize("knobs", EVERY, ids=NAMES)
def test_min_gap_parts_dots_of_all_sizes(knobs):
    sheet = stipple(ramp(20.0, 15.0, 0.1, 0.6), min_gap=0.08, **knobs)
    outlines = dots(sheet).outlines().flat(1e-4).polygons()
    first, second = shapely.STRtree(outlines).query(outlines, predicate="dwithin", distance=0.3)
    gap = shapely.distance(outlines[first[first < second]], outlines[second[first < second]]).min()
    assert gap >= 0.08 - 2e-3  # sizes are rounded to micrometres
    assert len(dots(sheet)) > 4 * sheet.report["removed_for_gap"]


def test_sizes_and_dots_fix_both_and_the_tone_gives():
    few = stipple(grey(0.5), sizes=NIBS, dots=300).report
    assert few["marks"] == 300 and few["sizes"][2]["marks"] > 290  # the largest have all there is to do
    assert few["coverage_missing"] == pytest.approx(1 - 300 * math.pi / 4 * 0.25 / 150, abs=0.01)  # some of 300 may overlap
    free = stipple(grey(0.5), size_by="tone", dots=1000).report
    assert free["marks"] == 1000 and free["coverage_missing"] < 0.01


def test_nibs_are_handed_out_so_that_sums_hold_and_what_cannot_be_reached_is_not_carried_far():
    areas, half = np.array([1.0, 2.0, 6.0]), np.full(1000, 0.5)
    due = np.random.default_rng(0).uniform(3, 4, 1000)
    nib, order = np.zeros(1000, np.int64), np.arange(1000)
    _handed_out(due, order, areas, half, nib)
    assert np.abs(np.cumsum(areas[nib] - due)).max() <= 2.0 + 1e-9  # half of the widest step from nib to nib
    due[:500], due[500:] = 9.0, 1.0
    _handed_out(due, order, areas, half, nib)
    assert (nib[:500] == 2).all() and (nib[510:] == 0).all()


def test_free_sizes_are_the_due_within_the_span_and_the_rest_goes_to_the_next():
    area = np.full(4, 5.0)
    _followed(np.array([3.0, 7.0, 1.0, 0.1]), np.array([0, 1, 2, 3]), 1.0, area)
    assert area.tolist() == [3.0, 5.0, 3.0, 1.0]


def overlap(xy: Array, radius: Array) -> float:
    """The sum over pairs of how deep discs lie in one another."""
    pairs = cKDTree(xy).query_pairs(2 * radius.max(), output_type="ndarray")
    return float(np.maximum(0, radius[pairs].sum(axis=1) - np.hypot(*(xy[pairs[:, 0]] - xy[pairs[:, 1]]).T)).sum())


def test_dots_of_unlike_sizes_share_the_room():
    tone, rng = grey(0.7), np.random.default_rng(0)
    sites = rng.permutation(np.stack(np.meshgrid(np.arange(0.25, 20, 0.5), np.arange(0.25, 15, 0.5)), axis=-1).reshape(-1, 2))
    radius = np.where(rng.random(len(sites)) < 0.5, 0.15, 0.3)
    fill = np.full(len(sites), math.pi * (radius**2).mean() / 0.25)
    moved = _eased(sites, radius, fill, tone, np.zeros((30, 40), bool))
    assert tone.holds(moved).all() and overlap(moved, radius) < 0.35 * overlap(sites, radius)
    assert (_eased(sites[:1], radius[:1], fill[:1], tone, np.zeros((30, 40), bool)) == sites[:1]).all()


@pytest.fixture
def shelf(tmp_path, monkeypatch):
    """Libraries of 0.2, 0.3 and 0.5 mm nibs and one of no nib, all of one shape."""
    text = (glyphs.FOLDER / "disc.svg").read_text(encoding="utf-8")
    for name, pen in (("nib-a", 0.2), ("nib-b", 0.3), ("nib-c", 0.5), ("brush", 1.2)):
        (tmp_path / f"{name}.svg").write_text(text.replace('"pen_mm": 0.3', f'"pen_mm": {pen}'), encoding="utf-8")
    monkeypatch.setattr(glyphs, "FOLDER", tmp_path)


@pytest.mark.parametrize(
    ("pen", "name"), [(0.01, "nib-a"), (0.2, "nib-a"), (0.24, "nib-a"), (0.25, "nib-b"), (0.39, "nib-c"), (1.2, "nib-c")]
)
@pytest.mark.usefixtures("shelf")
def test_the_nearest_nib_is_the_one_that_is_scaled_least(pen, name):
    assert glyphs.nearest(pen) == name


def test_the_library_is_the_nearest_nib_unless_one_is_named():
    report = stipple(grey(0.3), pen=0.3).report
    assert (report["glyphs"], report["glyph_pen_mm"], report["glyph_scaling"]) == ("nib-03", 0.3, 1.0)
    assert report["warnings"] == [] and report["simulated"] is True
    assert stipple(grey(0.3), pen=0.3, glyphs="disc").report["glyphs"] == "disc"


@pytest.mark.parametrize(("pen", "words"), [(0.72, "a 0.3 mm nib drawn at 0.72 mm are enlarged 2.4 times"), (0.15, "reduced to 0.5")])
def test_dots_far_from_their_own_size_are_said_to_be(pen, words):
    report = stipple(grey(0.3), pen=pen, glyphs="nib-03").report
    assert report["glyph_scaling"] == pytest.approx(pen / 0.3)
    assert any(words in warning for warning in report["warnings"])
    assert stipple(grey(0.3), pen=pen, glyphs="disc").report["warnings"] == []  # a circle is one at any size


def parted(coverage: float, left: float, right: float) -> Tone:
    """A grey whose halves differ in importance."""
    wish = np.repeat([[left, right]], 20, axis=1).repeat(30, axis=0)
    return replace(grey(coverage), importance=wish)


@pytest.mark.parametrize("knobs", [*EVERY, {"pen": 0.3}], ids=[*NAMES, "a pen"])
def test_importance_that_is_grey_all_over_changes_nothing(knobs):
    plain, asked = stipple(grey(0.4), **knobs), stipple(parted(0.4, 0.5, 0.5), **knobs)
    assert (dots(plain).xy == dots(asked).xy).all() and plain.report["warnings"] == asked.report["warnings"]


@pytest.mark.parametrize("knobs", EVERY, ids=NAMES)
def test_dots_are_finer_where_it_is_important_and_tone_is_kept(knobs):
    marks = dots(stipple(parted(0.4, 0.25, 0.75), **knobs))
    left = marks.xy[:, 0] < 10
    coarse, fine = (math.sqrt((diameters(marks)[half] ** 2).mean()) for half in (left, ~left))
    assert coarse > 1.3 * fine  # sizes are divided by half the square root of two, and by twice that
    cover = measure.rendered(marks, (20.0, 15.0), (15, 20))
    assert cover[:, 1:9].mean() == pytest.approx(0.4, abs=0.02) and cover[:, 11:19].mean() == pytest.approx(0.4, abs=0.02)


def test_one_pen_shares_its_dots_out_by_importance_and_says_what_it_costs():
    plain, asked = stipple(grey(0.3), pen=0.3), stipple(parted(0.3, 0.25, 0.75), pen=0.3)
    assert len(plain.marks) == len(asked.marks)
    assert asked.report["ink_placed_mm2"] == pytest.approx(plain.report["ink_placed_mm2"], rel=0.01)  # some overlap more
    right = (asked.marks.xy[:, 0] > 10).mean()
    assert right == pytest.approx(2 / 3, abs=0.01)  # twice as many
    assert any("tone is kept on the whole only" in warning for warning in asked.report["warnings"])
    dark = stipple(parted(0.9, 0.0, 1.0), pen=0.3)
    assert len(dark.marks) == pytest.approx(len(stipple(grey(0.9), pen=0.3).marks), rel=1e-3)
