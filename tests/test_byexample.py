"""The style byexample: marks of the example, tones kept, white marks in the darks, and what it refuses."""

from __future__ import annotations

import io
from functools import cache

import numpy as np
import pytest
import shapely
from PIL import Image
from scipy.stats import kstest

import crowquill
from crowquill import Tone, exemplar, texture
from crowquill.marks import Marks
from crowquill.paths import Array
from crowquill.raster import covered
from crowquill.styles import byexample

HAND = exemplar.load("hand")
SIDE = 30.0  # mm


@cache
def flat(coverage: float, **knobs: object) -> crowquill.Sheet:
    return crowquill.draw("byexample", Tone(np.full((20, 20), coverage), (SIDE, SIDE)), **knobs)


def darkness(sheet: crowquill.Sheet, margin: float = 1.0) -> float:
    """The ink in the middle of a sheet: at its border half of each mark that lies outside is missing."""
    grid = 600
    pixel = sheet.size[0] / grid
    ink = np.zeros((grid, grid))
    for layer in sheet.layers:
        ink = np.maximum(ink, covered(layer.art, (grid, grid), pixel=(pixel, pixel)))
    edge = round(margin / pixel)
    return float(ink[edge:-edge, edge:-edge].mean())


LEVELS = sorted([level.coverage for level in HAND.black.levels] + [1 - level.coverage for level in HAND.white.levels])


@pytest.mark.parametrize("coverage", LEVELS, ids="{:.2f}".format)
def test_a_flat_tone_of_a_level_comes_out_within_three_greys(coverage):
    assert darkness(flat(coverage)) == pytest.approx(coverage, abs=3 / 255)


@pytest.mark.parametrize("k", range(len(LEVELS) - 1))
def test_a_flat_tone_between_levels_comes_out_within_four_greys(k):
    middle = (LEVELS[k] + LEVELS[k + 1]) / 2
    assert darkness(flat(middle)) == pytest.approx(middle, abs=4 / 255)


def test_marks_of_a_light_tone_stay_in_a_darker_one():
    light, dark = (flat(coverage).marks.xy for coverage in (0.1, 0.3))
    assert set(map(tuple, light.tolist())) <= set(map(tuple, dark.tolist()))
    assert len(dark) > 2 * len(light)


def test_the_areas_of_marks_are_those_of_the_example():
    bank = np.array([np.pi / 4 * glyph.size**2 for glyph in HAND.black.glyphs])
    areas = flat(0.3).marks.scale ** 2
    assert kstest(areas, bank).statistic < 0.05
    assert kstest(areas * 1.1, bank).statistic > 0.05  # a tenth more would be seen


def test_no_shape_comes_again_before_all_others_were_drawn():
    dealt = byexample._dealt(25, 10, np.random.default_rng(0))
    assert sorted(dealt[:10]) == sorted(dealt[10:20]) == list(range(10)) and len(set(dealt[20:].tolist())) == 5


def test_marks_are_turned_at_random():
    angle = flat(0.2).marks.angle
    assert np.hypot(np.cos(2 * angle).mean(), np.sin(2 * angle).mean()) < 4 / np.sqrt(len(angle))  # four standard errors


def test_marks_are_as_large_as_in_the_example_whatever_the_size_of_the_drawing():
    small, large = (crowquill.draw("byexample", Tone(np.full((20, 20), 0.2), (side, side))).marks for side in (15, 30))
    assert small.scale.mean() == pytest.approx(large.scale.mean(), rel=0.03) and len(large) == pytest.approx(4 * len(small), rel=0.1)


def test_what_is_drawn_is_black_alone_and_the_same_again():
    one, same = (crowquill.draw("byexample", Tone(np.full((9, 9), 0.64), (12, 12)), seed=2) for _ in range(2))
    assert crowquill.to_bytes(one, "svg") == crowquill.to_bytes(same, "svg")
    assert {layer.ink.cmyk for layer in one.layers} == {(0, 0, 0, 1)}
    pixels = np.asarray(Image.open(io.BytesIO(crowquill.to_bytes(one, "png", bilevel=True))).convert("L"))
    assert np.unique(pixels).tolist() == [0, 255]


@pytest.mark.parametrize("coverage", [0.64, 0.85])
def test_white_marks_are_holes_and_rings_do_not_cross(coverage):
    drawing = crowquill.draw("byexample", Tone(np.full((9, 9), coverage), (18, 18)))
    areas = next(layer.art for layer in drawing.layers if not isinstance(layer.art, Marks))
    assert (areas.areas < 0).sum() > 300
    inner = np.array([shapely.Polygon(ring) for ring in areas])
    assert shapely.is_valid(inner).all()  # none crosses itself
    one, other = shapely.STRtree(inner).query(inner, predicate="intersects")
    shared, least = shapely.area(shapely.intersection(inner[one], inner[other])), np.minimum(*shapely.area(inner[[one, other]]))
    assert (np.isclose(shared, least, atol=1e-9) | np.isclose(shared, 0, atol=1e-9)).all()  # one in the other, or apart


def test_no_piece_of_black_is_smaller_than_a_quarter_of_a_mark():
    sheet = flat(0.64)
    areas = next(layer.art for layer in sheet.layers if not isinstance(layer.art, Marks)).areas
    assert areas[areas > 0].min() > 0.24 * HAND.black.area  # snapping to micrometres moves a corner by a thousandth


def correlations(coverage: float, **knobs: object) -> Array:
    marks = flat(coverage, **knobs).marks
    pixel = SIDE / 900
    ink = covered(marks, (900, 900), pixel=(pixel, pixel))
    return texture.curves(ink, (pixel, pixel), SIDE / np.sqrt(len(marks))).mean([0.5, 1.0, 2.0])


def test_the_two_examples_lie_plainly_otherwise():
    hand, even = (correlations(0.3, example=name) for name in ("hand", "even"))
    assert hand[0] > 0.02 and even[0] < -0.1  # groups of dots; dots that keep apart
    assert abs(hand[1]) < 0.05 and even[1] > 0.1


@pytest.mark.parametrize(
    ("knobs", "said"),
    [
        ({"example": "nobody"}, "nobody.*even, hand"),
        ({"example": "hand", "style_file": "x.style"}, "leave out example"),
        ({"example_dpi": 600.0}, "example_dpi 600.*leave it out"),
        ({"max_dots": 10}, "over the limit of 10.*draw it smaller"),
    ],
)
def test_what_cannot_be_followed_is_answered_with_what_would_be_right(knobs, said):
    with pytest.raises(ValueError, match=said) as error:
        flat(0.3, **knobs)
    assert "\n" not in str(error.value)
