"""The dots style's own bars: a dot to each square of the lattice, as large as the ink there, whatever the shape."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import shapely
from rendering import Window, poppler
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree
from test_screen import peak

import crowquill
from crowquill import Marks, Paths, Sheet, Tone, raster
from crowquill.styles.dots import SHAPES, _glyphs, overlap

Array = npt.NDArray[np.float64]
COVERAGES = (0.1, 0.3, 0.5, 0.7, 0.9)
SIZE = (80.0, 60.0)
ANY_SHAPE = pytest.mark.parametrize("shape", [*SHAPES, "nib-03"])
CENTRE = slice(2, -2)  # pixels of a millimetre: further from the edge than any dot reaches


def grey(coverage: float, canvas: shapely.Geometry | None = None, size: tuple[float, float] = SIZE) -> Tone:
    return Tone(np.full((30, 40), coverage), size, canvas)


def dots(tone: Tone, **knobs: Any) -> Sheet:
    return crowquill.draw("dots", tone, **knobs)


def covered(sheet: Sheet) -> Array:
    return raster.covered(sheet.layers[0].art, (60, 80), pixel=(1.0, 1.0), lines=128)


def disc(rho: float) -> float:
    """The share of a square of side 1 that discs of this radius cover, one in the middle of each square."""
    if rho <= 0.5:
        return float(np.pi * rho**2)
    return float(np.pi * rho**2 - 4 * (rho**2 * np.arccos(1 / (2 * rho)) - 0.5 * np.sqrt(rho**2 - 0.25)))


def found(name: str) -> tuple[Array, Array]:
    return overlap(_glyphs(name), np.random.default_rng(1))


@ANY_SHAPE
def test_coverage_is_the_tone(shape):
    for coverage in COVERAGES:
        sheet = dots(grey(coverage), shape=shape, seed=2, min_dot=0.0)
        assert sheet.report["ink_placed_mm2"] / 4800 == pytest.approx(coverage, abs=0.005)
        # a window of 76 by 56 mm cuts dots at its edge: of 13 000 some 300 by chance
        assert covered(sheet)[CENTRE, CENTRE].mean() == pytest.approx(coverage, abs=0.003)


@ANY_SHAPE
def test_black_closes_up_and_white_is_empty(shape):
    black = covered(dots(grey(1.0), shape=shape))
    assert black[CENTRE, CENTRE].mean() > 0.9995  # what is less than CLOSED of white
    white = dots(grey(0.0), shape=shape)
    assert white.report["marks"] == 0 and "white" in white.report["warnings"][0]


def test_discs_that_overlap_cover_what_the_formula_says():
    coverage, area = found("round")
    formula = [disc(float(np.sqrt(a / np.pi))) for a in area[:-1]]
    assert coverage[:-1] == pytest.approx(formula, abs=3e-4)  # measured along 512 lines
    assert area[-1] == pytest.approx(np.pi / 2, abs=0.03)  # radius 0.7071


def test_diamonds_that_overlap_cover_what_the_formula_says():
    coverage, area = found("diamond")
    half = np.sqrt(area / 2)
    assert coverage[:-1] == pytest.approx(np.where(half <= 0.5, 2 * half**2, 1 - 2 * (1 - half) ** 2)[:-1], abs=3e-4)


@pytest.mark.parametrize("name", ["round", "ellipse", "diamond", "nib-03"])
def test_dots_that_do_not_meet_cover_their_area_and_others_less(name):
    coverage, area = found(name)
    few = area <= 0.3
    assert coverage[few] == pytest.approx(area[few], abs=1e-3)
    assert (coverage <= area + 1e-3).all() and (np.diff(coverage) >= 0).all() and coverage[-1] == 1


@pytest.mark.parametrize(("lpi", "angle"), [(50, 45.0), (60, 15.0), (40, 0.0)])
def test_there_are_as_many_dots_as_the_ruling_says_in_its_rows(lpi, angle):
    sheet = dots(grey(0.3), lpi=lpi, angle=angle)
    marks = sheet.marks
    inner = marks.take(((marks.xy > 5) & (marks.xy < (75, 55))).all(axis=1))
    assert len(inner) / 3500 == pytest.approx((lpi / 25.4) ** 2, rel=0.01)
    assert (inner.scale**2).sum() / 3500 == pytest.approx(0.3, rel=0.01)
    far, _ = cKDTree(marks.xy).query(inner.xy, k=2)
    assert far[:, 1] == pytest.approx(25.4 / lpi, abs=2e-3)  # places are whole micrometres
    window = Window(10, 10, 40, 30)
    ruling, run = peak(poppler(crowquill.to_bytes(sheet, "pdf"), window, 20.0), 20.0)
    assert ruling == pytest.approx(lpi, rel=0.01)
    assert min(abs((run - angle - turn + 45) % 90 - 45) for turn in (0, 90)) <= 0.5


def test_each_dot_has_the_ink_of_its_own_square():
    x = np.linspace(0, 1, 400)
    tone = Tone(np.tile(0.6 * x, (300, 1)), SIZE)
    marks = dots(tone, pitch=1.0, angle=0.0, phase=(0.5, 0.5), min_dot=0.0).marks
    assert len(marks) == 4800
    for k in (5, 1000, 3333):
        left, top = np.floor(marks.xy[k])
        square = tone.coverage[round(top * 5) : round(top * 5) + 5, round(left * 5) : round(left * 5) + 5]
        assert marks.scale[k] ** 2 == pytest.approx(square.mean(), abs=2e-3)  # scales are whole micrometres
    assert (marks.scale**2).sum() == pytest.approx(tone.ink, rel=2e-3)


def test_marks_are_glyphs_and_a_euclidean_screen_is_outlines():
    assert all(isinstance(dots(grey(0.6), shape=shape).layers[0].art, Marks) for shape in ("round", "ellipse", "diamond", "nib-03"))
    art = dots(grey(0.6), shape="euclidean").layers[0].art
    assert isinstance(art, Paths) and (art.areas < 0).sum() > 10_000  # white holes, one to a square


def test_an_ellipse_lies_along_its_rows_and_dots_of_a_library_anyhow():
    along = dots(grey(0.3), shape="ellipse", angle=30.0).marks
    assert np.unique(along.angle) == pytest.approx([np.radians(30)], abs=1e-4)
    some = dots(grey(0.3), shape="nib-03").marks
    assert len(np.unique(some.angle)) > 1000 and len(np.unique(some.glyph)) == len(some.glyphs) > 1


def test_tone_is_kept_place_by_place():
    x, y = np.meshgrid(np.linspace(0, 6, 320), np.linspace(0, 5, 240))
    tone = Tone(0.5 + 0.4 * np.sin(x) * np.cos(y), SIZE)
    for shape in SHAPES:
        cover = raster.covered(dots(tone, lpi=80, shape=shape).layers[0].art, (240, 320), pixel=(0.25, 0.25), lines=32)
        blurred, asked = (gaussian_filter(part, 3.0) for part in (cover, tone.coverage))  # pixels, over two pitches
        assert np.abs(blurred - asked)[12:-12, 12:-12].max() <= 0.03


def test_dots_too_small_are_left_out_and_said():
    sheet = dots(grey(0.002), pitch=0.5, min_dot=0.03)  # of 0.025 mm
    # pieces of squares at the edge have smaller ones yet
    assert sheet.report["left_out"] == pytest.approx(1) and sheet.report["marks"] == 0 and "smaller" in sheet.report["warnings"][0]
    sheet = dots(grey(0.002), pitch=0.5, min_dot=0.0)
    assert sheet.report["left_out"] < 0.01 and sheet.report["ink_placed_mm2"] == pytest.approx(9.6, rel=0.05)  # scales of 22.4 are 22 um
    euclidean = dots(grey(0.002), pitch=0.5, min_dot=0.03, shape="euclidean")
    assert euclidean.report["left_out"] == pytest.approx(1) and euclidean.report["marks"] == 0


@pytest.mark.parametrize("shape", ["round", "euclidean"])
def test_a_canvas_with_a_hole_and_islands_keeps_its_ink(shape):
    ring = shapely.Point(25, 30).buffer(20) - shapely.Point(25, 30).buffer(8)
    canvas = shapely.union(ring, shapely.box(55, 10, 75, 50))
    sheet = dots(grey(0.4, canvas), shape=shape)
    assert shapely.contains_xy(canvas.buffer(0.001), sheet.layers[0].art.xy).all()  # centres, or corners
    assert sheet.report["ink_placed_mm2"] == pytest.approx(0.4 * canvas.area, rel=0.01)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_canvas_smaller_than_a_square_has_an_answer(shape):
    sheet = dots(grey(0.4, size=(0.5, 0.4)), pitch=2.0, shape=shape)
    ink = sheet.report["ink_placed_mm2"]
    assert np.isfinite(ink)
    if shape != "euclidean":  # whose dots may miss the canvas
        assert ink == pytest.approx(0.4 * 0.2, rel=0.03)  # whole micrometres


@pytest.mark.parametrize(
    ("knobs", "said"),
    [
        ({"lpi": 50, "pitch": 0.5}, "both given; leave one out"),
        ({"pitch": 0}, "pitch is 0; it takes a number from"),
        ({"pitch": 0.0201}, "over the limit of"),
        ({"pitch": 0.05, "min_dot": 0.06}, "a pitch of 0.05 mm has no dots over 0.056 mm, and min-dot is 0.06 mm; take a coarser ruling"),
        ({"shape": "square"}, "no shape 'square'; there are round, euclidean, ellipse, diamond, .*, or the path of an SVG file"),
        ({"phase": (0.1,)}, "phase is .*; it takes 2 numbers"),
    ],
    ids=str,
)
def test_knobs_that_do_not_go_together_are_refused_in_one_line(knobs, said):
    with pytest.raises(ValueError, match=said) as error:
        dots(Tone([[0.5]], (100.0, 100.0)), **knobs)
    assert "\n" not in str(error.value)
