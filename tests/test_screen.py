"""The screen style's own bars: coverage is the tone, and the rendered page has the ruling and the angle that were asked for."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import shapely
from rendering import Window, pdfium, poppler
from scipy.ndimage import gaussian_filter

import crowquill
from crowquill import Paths, Sheet, Tone, raster

Array = npt.NDArray[np.float64]
COVERAGES = (0.1, 0.3, 0.5, 0.7, 0.9)
ALL = {"min_line": 0.0, "min_gap": 0.0}  # every line prints
PX = 20.0  # pixels to the mm
PAGE = Window(0, 0, 40, 30)
SCREENS: list[dict[str, Any]] = [
    {"angles": (45.0,)},
    {"angles": (0.0,), "lpi": 40},
    {"angles": (15.0, 75.0)},
    {"angles": (0.0, 60.0, 120.0)},
    {"angles": (15.0, 75.0), "combine": "mean"},
    {"angles": (45.0, -45.0), "combine": "max"},
    {"angles": (15.0, 75.0), "combine": "product"},
]


def grey(coverage: float, canvas: shapely.Geometry | None = None) -> Tone:
    return Tone(np.full((30, 40), coverage), (40.0, 30.0), canvas)


def screen(tone: Tone, **knobs: Any) -> Sheet:
    return crowquill.draw("screen", tone, **knobs)


def covered(sheet: Sheet, grid: tuple[int, int] = (30, 40)) -> Array:
    (layer,) = sheet.layers
    pixel = sheet.size[0] / grid[1], sheet.size[1] / grid[0]
    return raster.covered(layer.art, grid, pixel=pixel, pen=layer.ink.pen, lines=max(128, round(1280 * pixel[1])))  # level lines want many


def peak(page: Array, px: float) -> tuple[float, float]:
    """Lines to the inch and the angle in which they run, of the strongest wave on a page of px pixels to the mm.

    The bin next to the peak leaves some 2 % of doubt; the sum over fractions of a bin around it leaves a thousandth.
    """
    window = np.hanning(page.shape[0])[:, None] * np.hanning(page.shape[1])
    signal = (page - page.mean()) * window
    power = np.abs(np.fft.fft2(signal))
    row, column = np.unravel_index(power.argmax(), power.shape)
    fx, fy = np.fft.fftfreq(page.shape[1])[column], np.fft.fftfreq(page.shape[0])[row]
    part = np.linspace(-1, 1, 101)
    across = np.exp(-2j * np.pi * np.outer(fx + part / page.shape[1], np.arange(page.shape[1])))
    down = np.exp(-2j * np.pi * np.outer(fy + part / page.shape[0], np.arange(page.shape[0])))
    fine = np.abs(down @ signal @ across.T)
    j, i = np.unravel_index(fine.argmax(), fine.shape)
    fx, fy = fx + part[i] / page.shape[1], fy + part[j] / page.shape[0]
    return float(np.hypot(fx, fy) * px * 25.4), float((np.degrees(np.arctan2(fy, fx)) + 90) % 180)


@pytest.mark.parametrize("knobs", SCREENS, ids=str)
def test_coverage_is_the_tone(knobs):
    for coverage in COVERAGES:
        sheet = screen(grey(coverage), seed=1, **ALL, **knobs)
        cover = covered(sheet)
        assert cover.mean() == pytest.approx(coverage, abs=0.005), f"at {coverage}"
        assert sheet.report["ink_placed_mm2"] / 1200 == pytest.approx(cover.mean(), abs=1e-3)
        assert sheet.report["left_out_mm2"] == sheet.report["closed_mm2"] == 0


@pytest.mark.parametrize("knobs", SCREENS, ids=str)
def test_black_is_solid_and_white_is_empty(knobs):
    black = covered(screen(grey(1.0), **knobs))
    assert black.min() > 0.999  # corners in whole micrometres
    white = screen(grey(0.0), **knobs)
    assert white.report["marks"] == 0 and "white" in white.report["warnings"][0]


@pytest.mark.parametrize(("lpi", "angle"), [(50, 45.0), (37, 15.0), (60, -20.0), (25, 90.0)])
def test_the_rendered_page_has_the_ruling_and_the_angle(lpi, angle):
    sheet = screen(grey(0.4), lpi=lpi, angles=(angle,), **ALL)
    pdf = crowquill.to_bytes(sheet, "pdf")
    ruling, run = peak(poppler(pdf, PAGE, PX), PX)
    assert ruling == pytest.approx(lpi, rel=0.01)
    assert abs((run - angle + 90) % 180 - 90) <= 0.5
    assert pdfium(pdf, PAGE, PX).mean() == pytest.approx(0.4, abs=0.005)  # Poppler darkens edges


def test_the_peak_sees_a_wrong_ruling_and_a_wrong_angle():
    page = poppler(crowquill.to_bytes(screen(grey(0.4), lpi=51, angles=(46.0,), **ALL), "pdf"), PAGE, PX)
    ruling, run = peak(page, PX)
    assert abs(ruling / 50 - 1) > 0.01 and abs(run - 45) > 0.5


def test_tone_is_kept_place_by_place():
    x, y = np.meshgrid(np.linspace(0, 6, 240), np.linspace(0, 5, 180))
    tone = Tone(0.5 + 0.4 * np.sin(x) * np.cos(y), (40.0, 30.0))
    for knobs in ({}, {"angles": (15.0, 75.0)}, {"angles": (15.0, 75.0), "combine": "mean"}):
        cover = covered(screen(tone, lpi=80, **ALL, **knobs), (180, 240))
        sigma = 4.0  # pixels, two pitches
        blurred, asked = gaussian_filter(cover, sigma), gaussian_filter(tone.coverage, sigma)
        assert np.abs(blurred - asked)[15:-15, 15:-15].max() <= 0.03


def test_what_lines_too_thin_cost_is_said():
    sheet = screen(grey(0.05), pitch=0.5, min_line=0.03)  # lines of 0.025 mm
    assert sheet.report["left_out"] == pytest.approx(1, abs=0.01) and sheet.report["marks"] == 0
    sheet = screen(grey(0.97), pitch=0.5, min_gap=0.03)  # gaps of 0.015 mm
    assert sheet.report["closed_mm2"] == pytest.approx(36, rel=0.02) and covered(sheet).mean() > 0.9999
    for knobs in ({"combine": "mean"}, {"combine": "max"}, {"combine": "product"}):
        sheet = screen(grey(0.003), pitch=0.5, min_line=0.03, angles=(15.0, 75.0), **knobs)
        assert sheet.report["left_out"] == pytest.approx(1) and "no lines" in sheet.report["warnings"][0]


def test_what_is_left_out_and_closed_makes_up_the_difference_of_ink():
    tone = Tone(np.tile(np.linspace(0, 1, 80), (60, 1)), (40.0, 30.0))
    for knobs in ({}, {"angles": (15.0, 75.0)}):
        report = screen(tone, min_line=0.1, min_gap=0.1, lpi=50, **knobs).report
        balance = report["ink_asked_mm2"] - report["left_out_mm2"] + report["closed_mm2"]
        assert report["left_out"] > 0.005 and report["ink_placed_mm2"] == pytest.approx(balance, rel=0.01)


def test_lines_are_cut_at_the_canvas_and_its_holes():
    canvas = shapely.Polygon([(2, 2), (38, 4), (30, 28), (20, 12), (5, 25)]) - shapely.Point(25, 8).buffer(3)
    for knobs in SCREENS:
        (layer,) = screen(grey(0.6, canvas), **ALL, **knobs).layers
        shape = shapely.union_all([part.buffer(0) for part in layer.art.polygons()])
        assert shape.difference(canvas.buffer(0.002)).area < 1e-3  # mm2; corners are in whole micrometres
        assert screen(grey(0.6, canvas), **ALL, **knobs).report["ink_placed_mm2"] == pytest.approx(0.6 * canvas.area, rel=0.02)


def test_a_family_moves_with_its_phase_and_comes_back_after_a_pitch():
    drawn = {phase: covered(screen(grey(0.3), angles=(90.0,), pitch=0.5, phase=(phase,)), (1, 400)) for phase in (0.0, 0.4, 1.0)}
    assert np.abs(drawn[0.0] - drawn[1.0]).max() < 0.02  # of a pixel of 0.1 mm: whole micrometres
    shift = np.roll(drawn[0.0], -2, axis=1)  # 0.4 pitches are two pixels
    assert np.abs(shift - drawn[0.4])[:, 10:-10].max() < 0.02


@pytest.mark.parametrize("pen", [0.1, 0.3])
def test_a_pen_draws_lines_as_wide_as_outlines(pen):
    sheet = screen(grey(0.6), pitch=1.0, angles=(30.0,), pen=pen)
    (layer,) = sheet.layers
    assert isinstance(layer.art, Paths) and not layer.art.closed and layer.ink.pen == pen
    passes = np.ceil(0.6 / pen - 1e-9)
    assert sheet.report["marks"] == pytest.approx(passes * 46, abs=2 * passes)  # 40 x 30 mm are 46 pitches across the lines
    assert sheet.report["ink_placed_mm2"] == pytest.approx(720, rel=0.02)  # round ends hang over the edge


def test_a_canvas_smaller_than_the_pitch_has_an_answer():
    for phase in (0.0, 0.5):
        sheet = screen(Tone([[0.3]], (0.4, 0.4)), pitch=2.0, phase=(phase,))
        assert sheet.report["marks"] in (0, 1) and np.isfinite(sheet.report["ink_placed_mm2"])


@pytest.mark.parametrize(
    ("knobs", "said"),
    [
        ({"angles": (45.0, -135.0)}, "angles 45 and -135 repeat: .*; take angles 30 degrees apart or more"),
        ({"angles": (0.0, 179.5)}, "angles 0 and 179.5 repeat"),
        ({"lpi": 50, "pitch": 0.5}, "both given; leave one out"),
        ({"lpi": 0}, "lpi is 0; it takes a number from"),
        ({"pitch": 0.0}, "pitch is 0.0; it takes a number from"),
        ({"pitch": 0.0201, "angles": (0.0, 45.0, 90.0, 135.0)}, "over the limit of"),
        ({"combine": "max", "angles": (0.0, 45.0, 90.0)}, "combine 'max' is of two families, and there are 3 angles; give two"),
        ({"combine": "product", "angles": (30.0,)}, "combine 'product' is of two families, and there is one angle; give two"),
        ({"combine": "mean", "angles": (0.0, 90.0), "pen": 0.2}, "pen 0.2 mm draws lines, and combine 'mean' has none; take union"),
        ({"pitch": 0.1}, "min-line 0.03 mm and min-gap 0.03 mm are over half the pitch of 0.1 mm; take a coarser ruling"),
        ({"phase": (0.1, 0.2)}, "phase has 2 numbers for 1 families"),
    ],
    ids=str,
)
def test_knobs_that_do_not_go_together_are_refused_in_one_line(knobs, said):
    with pytest.raises(ValueError, match=said) as error:
        screen(Tone([[0.5]], (100.0, 100.0)), **knobs)
    assert "\n" not in str(error.value)
