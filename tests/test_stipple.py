"""The stipple style's own bars: tone, white, gaps, the book-keeping of dots and ink, and how evenly dots lie."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import shapely
from PIL import Image
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree
from skimage import data

import crowquill
from crowquill import Sheet, Tone, measure

Array = npt.NDArray[np.float64]
UM = 1e-3  # mm: places and sizes on a sheet are whole micrometres
PEN = 0.3  # mm


def ramp(width: float, height: float, low: float = 0.0, high: float = 0.9) -> Tone:
    """Coverage rising from left to right, five pixels a millimetre."""
    columns, rows = round(5 * width), round(5 * height)
    steps = low + (high - low) * (np.arange(columns) + 0.5) / columns
    return Tone(np.tile(steps, (rows, 1)), (width, height))


def stipple(tone: Tone, **knobs: Any) -> Sheet:
    return crowquill.draw("stipple", tone, **knobs)


def test_a_ramp_keeps_its_tone_in_every_band():
    tone = ramp(120.0, 60.0)
    sheet = stipple(tone, pen=PEN)
    cover = measure.rendered(sheet.marks, tone.size, (60, 120))  # pixels of a millimetre
    bands, asked = cover.mean(axis=0).reshape(10, 12).mean(axis=1), tone.coverage.mean(axis=0).reshape(10, 60).mean(axis=1)
    worst = np.abs(bands - asked).max()
    assert worst <= 0.015, f"bands {bands.round(4)} of {asked.round(4)}"
    assert abs(bands.mean() - asked.mean()) <= 0.005
    assert sheet.report["coverage_missing"] <= 0.005


WINDOW = np.ones((60, 80))
WINDOW[:30, :40] = 0
WINDOW[40:50, 50:70] = 0.0199  # grey, and just below the cutoff
FADE = np.tile(np.linspace(0, 0.5, 80) ** 2, (60, 1))
EDGED = np.clip(np.add.outer(np.arange(60), np.arange(80)) - 70, 0, 1) * 0.6
HORSESHOE = shapely.Point(10, 7.5).buffer(7) - shapely.box(8, 7, 12, 15)
PICTURES = {"a window": WINDOW, "a fade to white": FADE, "a slanting edge": EDGED}


@pytest.mark.parametrize("rule", ["before", "after"])
@pytest.mark.parametrize("canvas", [None, HORSESHOE], ids=["the rectangle", "a horseshoe"])
@pytest.mark.parametrize("name", PICTURES)
def test_no_dot_stands_on_white_or_outside_the_canvas(name, canvas, rule):
    tone = Tone(PICTURES[name], (20.0, 15.0), canvas)
    marks = stipple(tone, pen=PEN, white_rule=rule, white=0.02).marks
    column, row = (marks.xy / tone.pixel).astype(int).T
    inner = (column < 80) & (row < 60)  # a dot on the far border belongs to the last pixel
    assert len(marks) > 100
    assert (PICTURES[name][row[inner], column[inner]] >= 0.02).all()
    assert shapely.intersects_xy(tone.canvas, *marks.xy.T).all()


def test_dots_removed_at_the_end_are_counted():
    tone = Tone(FADE, (20.0, 15.0))
    report = stipple(tone, dots=3000, white=0.1, white_rule="after").report
    assert report["removed_on_white"] > 0
    assert report["marks"] + report["removed_on_white"] == 3000
    assert stipple(tone, dots=3000, white=0.1).report["removed_on_white"] == 0


def nearest_gap(sheet: Sheet) -> float:
    """The least distance between two outlines, mm, by shapely; 0 where they touch."""
    outlines = sheet.marks.outlines().flat(UM / 10).polygons()
    first, second = shapely.STRtree(outlines).query(outlines, predicate="dwithin", distance=0.5)
    pairs = first < second
    return float(shapely.distance(outlines[first[pairs]], outlines[second[pairs]]).min())


@pytest.mark.parametrize("dots", [None, 4000], ids=["as many as will do", "too many"])
def test_min_gap_parts_all_outlines_and_says_what_it_cost(dots):
    tone = ramp(30.0, 20.0, low=0.1, high=0.6)
    assert nearest_gap(stipple(tone, pen=PEN, dots=dots)) < 0.01  # there is something to part
    planned = next(crowquill.steps("stipple", tone, pen=PEN, dots=dots, min_gap=0.08)).facts["dots"]
    sheet = stipple(tone, pen=PEN, dots=dots, min_gap=0.08)
    assert nearest_gap(sheet) >= 0.08 - 2 * UM  # the size of each dot is rounded to a micrometre
    report = sheet.report
    assert report["marks"] + report["removed_for_gap"] == planned and report["removed_on_white"] == 0
    assert report["removed_for_gap"] > 200 if dots else report["removed_for_gap"] < 0.01 * planned
    assert report["ink_asked_mm2"] == pytest.approx(tone.ink)
    missing = 1 - report["ink_placed_mm2"] / tone.ink
    assert report["coverage_missing"] == pytest.approx(missing, abs=1e-9) and missing > 0.1  # one division
    assert any("ink" in warning for warning in report["warnings"])


def test_tone_rises_with_tone_however_wide_the_gap():
    for gap in (0.02, 0.1, 0.3):
        steps = [0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.95]
        placed = [stipple(Tone(np.full((8, 8), step), (16.0, 16.0)), pen=0.4, min_gap=gap).report["ink_placed_mm2"] for step in steps]
        assert (np.diff(placed) > 0.02 * 0.46 * (0.4 / (0.4 + gap)) ** 2 * 256).all(), (gap, placed)  # 2 % of the most there can be


LIGHT = Tone(np.full((30, 40), 0.2), (40.0, 30.0))  # so light that dots do not overlap: their areas sum to the ink


@pytest.mark.parametrize("pen", [0.25, 0.5, 1.0])
def test_a_pen_gives_the_number_of_dots(pen):
    sheet = stipple(LIGHT, pen=pen, glyphs="disc")
    wanted = LIGHT.ink / (math.pi * pen**2 / 4)
    assert len(sheet.marks) == pytest.approx(wanted, rel=2e-3)  # the curve of overlap is tabled to about a thousandth
    assert (sheet.marks.scale**2).sum() == pytest.approx(len(sheet.marks) * math.pi * pen**2 / 4, rel=5e-3)  # sizes are whole um
    assert sheet.report["pen_mm"] == pen


@pytest.mark.parametrize("dots", [1, 50, 2000])
def test_the_number_of_dots_gives_their_diameter(dots):
    sheet = stipple(LIGHT, dots=dots, glyphs="disc")
    assert len(sheet.marks) == dots
    assert sheet.report["pen_mm"] == pytest.approx(2 * math.sqrt(LIGHT.ink / (math.pi * dots)), rel=1e-3)  # half of 2e-3 of area
    # so the dots sum to the ink
    assert (sheet.marks.scale**2).sum() == pytest.approx(LIGHT.ink, rel=5e-3)


def test_pen_to_dots_and_back_is_the_same_pen_on_dark_tones_too():
    tone = ramp(30.0, 20.0)
    there = stipple(tone, pen=PEN, iterations=0).report
    back = stipple(tone, dots=there["marks"], iterations=0).report
    assert back["pen_mm"] == pytest.approx(PEN, rel=2e-3)  # two rounds towards a diameter that depends a little on itself


def test_pen_and_dots_together_fix_both_and_the_tone_gives():
    report = stipple(LIGHT, pen=0.4, dots=700).report
    assert (report["marks"], report["pen_mm"]) == (700, 0.4)
    asked, placed = LIGHT.ink, 700 * math.pi * 0.4**2 / 4
    assert report["ink_placed_mm2"] == pytest.approx(placed, rel=0.005)  # sizes of dots vary, and 700 of them nearly cancel
    assert report["coverage_missing"] == pytest.approx(1 - placed / asked, abs=0.005)  # the same


def test_diameters_vary_as_the_library_does_and_their_mean_square_is_the_pens():
    marks = stipple(LIGHT, pen=PEN).marks
    diameters = 2 * marks.scale / math.sqrt(math.pi)
    assert math.sqrt((diameters**2).mean()) == pytest.approx(PEN, rel=0.003)  # over 3000 dots that vary by 7 %
    assert 0.03 < diameters.std() / diameters.mean() < 0.12  # a library of pen dots, not of one disc


def test_until_stops_as_soon_as_dots_move_less():
    calm = stipple(LIGHT, dots=400, until=0.02, iterations=200).report
    assert 0 < calm["iterations"] < 200 and calm["movement"] < 0.02
    before = stipple(LIGHT, dots=400, until=0.0, iterations=calm["iterations"] - 1).report
    assert before["movement"] >= 0.02 and before["iterations"] == calm["iterations"] - 1  # and 0 never stops


def test_relaxation_lowers_the_energy_and_none_leaves_the_start():
    none, some = (stipple(LIGHT, dots=400, iterations=count).report for count in (0, 10))
    assert none["iterations"] == 0 and some["energy"] < none["energy"]


@pytest.mark.parametrize("coverage", [0.9, 0.97, 1.0])
def test_coverage_that_dots_do_not_reach_is_reported(coverage):
    report = stipple(Tone(np.full((30, 40), coverage), (24.0, 18.0)), pen=PEN).report
    wanted = max(0.0, 1 - 0.97 / coverage)
    # dots on the border reach a little beyond it: some hundredths of a millimetre of 84, on 432 mm2
    assert report["coverage_missing"] == pytest.approx(wanted, abs=0.008)
    assert report["ink_asked_mm2"] == pytest.approx(coverage * 432)
    assert report["coverage_missing"] == pytest.approx(max(0.0, 1 - report["ink_placed_mm2"] / report["ink_asked_mm2"]), abs=1e-12)


def test_black_is_said_not_to_be_reached():
    report = stipple(Tone(np.ones((30, 40)), (24.0, 18.0)), pen=PEN).report
    assert report["coverage_missing"] > 0.02 and any("not reached" in warning for warning in report["warnings"])


def test_a_drawing_twice_as_large_with_a_pen_twice_as_wide_is_the_same_drawing():
    small, large = ramp(20.0, 15.0), ramp(20.0, 15.0).fitted(width=40.0)
    one, two = stipple(small, pen=PEN), stipple(large, pen=2 * PEN)
    assert len(one.marks) == len(two.marks)
    assert np.abs(2 * one.marks.xy - two.marks.xy).max() <= 1.5 * UM + 1e-9  # half a micrometre rounded off twice over, and once
    assert (one.marks.glyph == two.marks.glyph).all()


@pytest.fixture(scope="module")
def camera() -> Tone:
    """scikit-image's camera man on 1000 pixels of 0.1 mm, by code value."""
    image = Image.fromarray(data.camera()).resize((1000, 1000), Image.Resampling.BICUBIC)
    return Tone(1 - np.asarray(image) / 255, (100.0, 100.0))


def discs(xy: Array, radius: float, size: int, fine: int = 4) -> Array:
    """The share of each pixel under equal discs, (size, size), by fine x fine samples; xy and radius in pixels."""
    ink = np.zeros((size * fine, size * fine), bool)
    r = radius * fine
    for x, y in xy * fine:
        left, right = max(0, int(x - r - 1)), min(size * fine, int(x + r + 2))
        top, bottom = max(0, int(y - r - 1)), min(size * fine, int(y + r + 2))
        dx, dy = np.arange(left, right) + 0.5 - x, np.arange(top, bottom) + 0.5 - y
        ink[top:bottom, left:right] |= np.add.outer(dy**2, dx**2) <= r * r
    return ink.reshape(size, fine, size, fine).mean(axis=(1, 3))


def scores(tone: Tone, xy: Array) -> tuple[float, float]:
    """How wrong the tone is, seen from afar, and how evenly the dots lie.

    tone    RMSE of equal discs whose areas sum to the ink, both blurred by 8 pixels
    rho     mean distance to the nearest dot, over the most a hexagonal lattice of cells as large as the dot's own
            would allow; cells are counted in pixels
    """
    asked = tone.coverage
    size = len(asked)
    rendered = discs(xy, math.sqrt(asked.sum() / (math.pi * len(xy))), size)
    error = math.sqrt(np.mean((gaussian_filter(rendered, 8) - gaussian_filter(asked, 8)) ** 2))
    tree = cKDTree(xy)
    near = tree.query(xy, k=2)[0][:, 1]
    row, column = np.divmod(np.arange(size * size), size)
    owner = tree.query(np.stack([column, row], axis=1) + 0.5)[1]
    area = np.bincount(owner, minlength=len(xy))
    rho = near[area > 0] / np.sqrt(2 * area[area > 0] / math.sqrt(3))
    return error, float(rho.mean())


def test_the_scores_know_a_lattice_from_chance():
    tone = Tone(np.full((200, 200), 0.2), (20.0, 20.0))
    pitch = 10.0
    rows = np.arange(0, 200, pitch * math.sqrt(3) / 2)
    lattice = np.array([(x + pitch / 2 * (i % 2), y) for i, y in enumerate(rows) for x in np.arange(0, 200, pitch)])
    chance = np.random.default_rng(0).random((len(lattice), 2)) * 200
    even, wild = scores(tone, lattice), scores(tone, chance)
    assert even[1] == pytest.approx(1, abs=0.06)  # cells at the border are cut, so that their dots look too far apart
    assert wild[1] < 0.6 and wild[0] > 2 * even[0]


@pytest.fixture(scope="module")
def photograph(camera) -> tuple[float, float]:
    sheet = stipple(camera, dots=20_000)
    assert len(sheet.marks) == 20_000
    return scores(camera, sheet.marks.xy / camera.pixel)


def test_a_photograph_keeps_its_tone_and_lies_evenly(photograph):
    error, rho = photograph
    assert error <= 0.020 and rho >= 0.885, (error, rho)


def test_the_published_method_is_a_setting_of_the_knobs_and_keeps_tone_less_well(camera, photograph):
    """Lloyd's own steps on a halftone start, cells weighed by coverage itself, until the dots have come to rest."""
    sheet = stipple(camera, dots=20_000, start="floyd-steinberg", exponent=1.0, step=1.0, until=0.005, iterations=200)
    assert len(sheet.marks) == pytest.approx(20_000, rel=0.01)  # a halftone has as many black pixels as it has
    assert sheet.report["movement"] < 0.005 and sheet.report["iterations"] < 200
    error, _ = scores(camera, sheet.marks.xy / camera.pixel)
    assert error > photograph[0] + 0.003, (error, photograph)  # the difference is several times what another seed makes
