"""Contrast-aware stippling: numbers and pens met, tone kept by size, grounds, textures, and bad input."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from PIL import Image
from scipy.ndimage import gaussian_filter

from crowquill import Tone, contrast, draw, measure, raster
from crowquill.__main__ import main
from crowquill.contrast import CAP, TONES, Texture, flat
from crowquill.grid import Grid
from crowquill.halftone.contrast import Diffusing
from crowquill.marks import Marks
from crowquill.paths import Array, Paths
from crowquill.sheet import Sheet

SIZE = (40.0, 30.0)
X, Y = np.meshgrid((np.arange(240) + 0.5) / 240, (np.arange(180) + 0.5) / 180)
HILLS = Tone(0.45 + 0.4 * np.sin(7 * X) * np.cos(5 * Y), SIZE)  # without an edge
BLOCKS = Tone(np.where((X * 5).astype(int) % 2 == (Y * 4).astype(int) % 2, 0.75, 0.15) + 0.1 * X, SIZE)
HATCHED = Tone(np.where(np.abs((X + Y) * 8 % 1 - 0.5) < 0.08, 0.95, 0.1), SIZE)
PICTURES = {"hills": HILLS, "blocks": BLOCKS, "hatched": HATCHED}


@cache
def drawn(name: str, **knobs: Any) -> Sheet:
    return draw("contrast", PICTURES[name], seed=2, **knobs)


def covered(sheet: Sheet, grid: tuple[int, int] = (180, 240)) -> Array:
    """How dark each pixel is, layers over one another, of a sheet of black, white and grey."""
    pixel = sheet.size[0] / grid[1], sheet.size[1] / grid[0]
    dark = np.zeros(grid)
    for layer in sheet.layers:
        dark += raster.covered(layer.art, grid, pixel=pixel) * (layer.ink.cmyk[3] - dark)
    return dark


def off(sheet: Sheet, tone: Tone, sigma: float = 9.0) -> Array:
    """Coverage less what is asked, blurred by so many pixels, without the edge."""
    error = gaussian_filter(covered(sheet) - tone.coverage, sigma)
    return np.asarray(error[15:-15, 15:-15])


@pytest.mark.parametrize("name", PICTURES)
@pytest.mark.parametrize("dots", [300, 2000])
def test_a_number_of_dots_is_met_within_two_percent_and_the_ink_with_it(name: str, dots: int) -> None:
    report = drawn(name, dots=dots).report
    assert report["marks"] == len(drawn(name, dots=dots).marks) == pytest.approx(dots, rel=0.02)
    assert report["ink_placed_mm2"] == pytest.approx(report["ink_asked_mm2"], rel=0.01) and not report["warnings"]


@pytest.mark.parametrize(
    "knobs", [{"order": "raster", "g_plus": 2.0}, {"g_plus": 0.0}, {"g_plus": 3.0, "g_minus": 1.0}, {"mask": 5, "k": 60.0}]
)
def test_a_number_is_met_by_any_rule(knobs: dict[str, Any]) -> None:
    report = drawn("blocks", dots=2000, **knobs).report
    assert report["marks"] == pytest.approx(2000, rel=0.02) and report["g"] == [
        knobs.get("g_plus", 5),
        knobs.get("g_minus", knobs.get("g_plus", 5)),
    ]


@pytest.mark.parametrize("name", PICTURES)
def test_a_pen_is_the_mean_diameter_and_the_ink_is_kept(name: str) -> None:
    sheet = drawn(name, pen=0.5)
    assert 2 * sheet.marks.scale.mean() / np.sqrt(np.pi) == pytest.approx(0.5, rel=0.03)
    assert sheet.report["ink_placed_mm2"] == pytest.approx(PICTURES[name].ink, rel=0.01)


def test_with_a_pen_and_a_number_the_tone_gives_and_that_is_said() -> None:
    sheet = drawn("hills", pen=0.3, dots=2000)
    assert sheet.report["marks"] == pytest.approx(2000, rel=0.02) and sheet.report["pen_mm"] == pytest.approx(0.3, rel=1e-3)
    assert (
        sheet.report["coverage_missing"] > 0.5 and "of the ink asked for is placed; a pen or a number alone" in sheet.report["warnings"][0]
    )


@pytest.mark.parametrize(("g", "most"), [(0.0, 0.03), (2.0, 0.04), (5.0, 0.06)])
def test_sizes_keep_smooth_tones_though_g_leaves_few_dots(g: float, most: float) -> None:
    error = off(drawn("hills", pen=0.3, g_plus=g), HILLS)
    assert np.sqrt((error**2).mean()) < most / 2 and np.abs(error).max() < most


def test_published_sizes_do_not_keep_tones_and_say_so() -> None:
    sheet = drawn("hills", pen=0.3, size_by="published")
    assert np.abs(off(sheet, HILLS)).max() > 0.06 and "placed; a pen or a number alone, sized by tone" in sheet.report["warnings"][0]
    radius = sheet.marks.scale / np.sqrt(np.pi) / sheet.report["pitch_mm"]
    asked = HILLS.at(sheet.marks.xy)
    assert radius == pytest.approx(1 + asked, abs=0.08)  # pixels: the mean over a pixel, up to 0.06 off at the slopes


def test_dots_of_flat_tones_rise_in_size_and_number_of_pixels() -> None:
    found = flat(Diffusing(more=5.0, less=5.0, extra=0.1))
    assert (np.diff(found.share[3:]) > -0.005).all() and found.shares(np.array([0.0, 0.01])).tolist() == [0, found.share[0] / 2]
    assert (np.diff(found.area[TONES <= 0.5]) >= 0).all() and 0.5 < found.area[0] < found.area[8] < 12
    halftone = flat(Diffusing())
    assert halftone.share[4:] == pytest.approx(TONES[4:], abs=0.012) and halftone.area[4:9] == pytest.approx(1.0, abs=0.06)


def test_dots_lie_at_the_middles_of_pixels_but_for_the_jitter() -> None:
    grid = Grid.of(HILLS, drawn("hills", dots=2000).report["pitch_mm"])

    def away(jitter: float) -> Array:
        xy = draw("contrast", HILLS, dots=2000, jitter=jitter, seed=2).marks.xy
        return np.asarray(((xy - grid.corner) / grid.cell) % 1 - 0.5)

    um = 1e-3 / grid.cell  # whole micrometres
    assert (
        np.abs(away(0.0)).max() <= um and np.abs(away(0.3)).max() <= 0.3 + um and away(0.3).std() == pytest.approx(0.3 / 3**0.5, rel=0.05)
    )


def test_a_scratchboard_is_white_dots_on_black_and_keeps_the_tone() -> None:
    sheet = drawn("hills", ground="black")
    ground, dots = sheet.layers
    assert isinstance(ground.art, Paths) and isinstance(dots.art, Marks) and ground.ink.cmyk[3] == 1 and dots.ink.cmyk[3] == 0
    assert np.abs(off(sheet, HILLS)).max() < 0.06
    assert sheet.report["ink_placed_mm2"] == pytest.approx(HILLS.ink, rel=0.01)
    assert covered(sheet).mean() * 1200 == pytest.approx(sheet.report["ink_placed_mm2"], rel=0.015)  # but for what hangs over


def test_on_grey_paper_darks_are_black_dots_and_lights_white_ones() -> None:
    sheet = drawn("hills", ground="grey", grey=0.4, dots=4000)
    paper, dark, light = sheet.layers
    assert [layer.label for layer in sheet.layers] == ["ground", "dots", "white dots"] and paper.ink.cmyk == (0, 0, 0, 0.4)
    assert isinstance(dark.art, Marks) and isinstance(light.art, Marks)
    assert HILLS.at(dark.art.xy).min() > 0.38 and HILLS.at(light.art.xy).max() < 0.42  # the tone under a jittered dot
    assert len(dark.art) + len(light.art) == sheet.report["marks"] == pytest.approx(4000, rel=0.02)
    assert np.abs(off(sheet, HILLS)).max() < 0.06 and sheet.report["ink_placed_mm2"] == pytest.approx(HILLS.ink, rel=0.01)
    assert [layer.label for layer in drawn("hills", ground="toned", grey=0.4, dots=4000).layers] == ["dots", "white dots"]


@pytest.fixture
def stripes(tmp_path: Path) -> str:
    """Upright stripes, dark on the left half of a tile that is twice as wide as high."""
    Image.fromarray(np.tile(np.repeat([20, 230], 16).astype(np.uint8), (16, 1))).save(tmp_path / "stripes.png")
    return str(tmp_path / "stripes.png")


def test_a_texture_shows_and_the_tone_stays(stripes: str) -> None:
    tone = Tone(np.full((30, 40), 0.4), SIZE)
    sheet = draw("contrast", tone, dots=4000, texture=stripes, texture_width=4.0, texture_strength=0.6)
    halves = covered(sheet, (15, 20)).reshape(15, 10, 2).mean(axis=(0, 1))
    assert halves == pytest.approx([0.52, 0.28], abs=0.04)  # 0.6 of the way by ranks of a quarter and three
    assert sheet.report["ink_placed_mm2"] == pytest.approx(tone.ink, rel=0.01)
    plain, none = (draw("contrast", tone, dots=500, **knobs) for knobs in ({}, {"texture": stripes, "texture_strength": 0.0}))
    assert np.array_equal(plain.marks.xy, none.marks.xy)


def test_a_texture_covers_the_drawing_once_or_in_tiles_and_leaves_white_and_black() -> None:
    grid = Grid.of(Tone(np.full((2, 2), 0.5), (8.0, 4.0)), 0.5)
    dark = np.array([[0.0, 1.0]])
    once = Texture(dark, None, 1.0).on(np.full((8, 16), 0.5), grid)
    tiled = Texture(dark, 2.0, 1.0).on(np.full((8, 16), 0.5), grid)
    assert (once[:, :8] < 0.5).all() and (once[:, 8:] > 0.5).all()
    assert np.array_equal(tiled, np.tile(tiled[:2, :4], (4, 4))) and tiled[0, :2].max() < 0.5 < tiled[0, 2:4].min()
    assert once.mean() == pytest.approx(0.5) and tiled.mean() == pytest.approx(0.5)
    ends = np.where(np.arange(16) % 2, 1.0, 0.0) * np.ones((8, 1))
    assert np.array_equal(Texture(dark, 2.0, 1.0).on(ends, grid), ends)
    assert Texture(dark, 10_000.0, 1.0).on(np.full((8, 16), 0.5), grid).shape == (8, 16)


def test_black_and_white_pictures_have_an_answer_whatever_is_asked() -> None:
    black, white = (Tone(np.full((4, 4), value), (10.0, 10.0)) for value in (1.0, 0.0))
    for knobs in ({}, {"dots": 400}, {"ground": "black"}, {"ground": "grey", "dots": 100}, {"order": "raster"}):
        for tone in (black, white):
            report = draw("contrast", tone, **knobs).report
            assert report["marks"] or "no ink" in report["warnings"][0]
    assert draw("contrast", black, dots=400).report["ink_placed_mm2"] == pytest.approx(100, rel=0.01)


def test_more_dots_than_pixels_are_drawn_on_finer_ones() -> None:
    report = draw("contrast", Tone([[0.2, 0.6]], (20.0, 10.0)), dots=5000).report
    assert report["marks"] == pytest.approx(5000, rel=0.02) and not report["warnings"]


def test_a_number_that_no_pixels_give_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(contrast, "MOST", 4000)
    report = draw("contrast", HILLS, dots=3000).report
    assert report["marks"] < 2000 and report["iterations"] <= contrast.ROUNDS
    assert f"{report['marks']} dots in place of 3000: the nearest that pixels of" in report["warnings"][0]


def test_lights_that_a_large_g_loses_by_raster_are_said() -> None:
    tone = Tone(np.tile(np.linspace(0.1, 0.6, 40), (30, 1)), SIZE)
    light = draw("contrast", tone, order="raster", g_plus=6.0, pen=0.5).report
    assert light["coverage_missing"] > 0.02 and "a lower G keeps more of the lights" in light["warnings"][-1]
    none = draw("contrast", Tone(np.full((30, 40), 0.25), SIZE), order="raster", g_plus=6.0, pen=0.5).report
    assert none["marks"] == 0 and "no dots" in none["warnings"][0]


def test_marks_are_grown_until_they_cover_what_is_asked_but_for_limits() -> None:
    marks = drawn("blocks", dots=300).marks
    own = measure.ink(marks)
    for wanted in (0.8 * own, 1.15 * own):
        grown, ink = measure.covering(marks, wanted, (0.5, 2.0))
        assert ink == pytest.approx(wanted, rel=1e-3) and measure.ink(grown) == pytest.approx(ink, rel=3e-4)  # lines and unions
        assert np.ptp(grown.scale / marks.scale) < 1e-12
    held, _ = measure.covering(marks, 5 * own, (0.8, 1.1))
    assert held.scale == pytest.approx(1.1 * marks.scale)
    none, ink = measure.covering(marks.take([]), 3.0, (0.5, 2.0))
    assert (len(none), ink) == (0, 0.0)


def test_a_canvas_and_the_white_cutoff_are_kept_to() -> None:
    canvas = shapely.Point(20, 15).buffer(12) - shapely.Point(20, 15).buffer(4)
    marks = draw("contrast", Tone(HATCHED.coverage, SIZE, canvas), white=0.5).marks
    assert shapely.intersects_xy(canvas, *marks.xy.T).all() and HATCHED.at(marks.xy).mean() > 0.8
    assert CAP == 0.97


WRONG: list[tuple[list[str], str]] = [
    (["--texture-width", "3mm"], "texture-width 3 mm is of no use without a texture; give one"),
    (["--texture", "none.png"], "none.png"),
    (["--texture", "picture.svg"], "picture.svg: not a picture that can be read"),
    (["--pen", "25mm"], "a pen of 25 mm is wider than the canvas of 20 mm; use a finer pen"),
    (["--pen", "0.05mm", "--max-dots", "1000"], "dots, over the limit of 1000; use a wider pen, or raise max-dots"),
    (["--dots", "5000", "--max-dots", "1000"], "dots, over the limit of 1000"),
    (["--pen", "0.01mm", "--max-dots", "100000000"], "million on this picture, over the limit of 12; draw it smaller, or use a wider pen"),
    (["--order", "spiral"], "no order 'spiral'; there are priority, raster"),
    (["--radii", "1"], "radii"),
    (["--ground", "red"], "no ground 'red'; there are white, black, grey, toned"),
    (["--mask", "2"], "mask is 2; it takes a whole number from 3 to 31"),
]


@pytest.mark.parametrize(("typed", "said"), WRONG, ids=[" ".join(typed) for typed, _ in WRONG])
def test_bad_input_is_answered_in_a_line(
    typed: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Image.fromarray(np.full((40, 40), 90, np.uint8)).save("picture.png")
    Path("picture.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>")
    assert main(["contrast", "picture.png", "out.svg", "--width", "20mm", *typed]) == 2
    told = capsys.readouterr().err
    assert said in told.splitlines()[-1] and "Traceback" not in told and not Path("out.svg").exists()


@pytest.mark.usefixtures("stripes")
def test_the_command_line_draws_and_draws_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Image.fromarray((255 * (1 - HATCHED.coverage)).astype(np.uint8)).save("picture.png")
    asked = ["--width", "30mm", "--dots", "400", "--texture", "stripes.png", "--ground", "grey", "--radii", "1,1.5", "--quiet"]
    assert main(["contrast", "picture.png", "one.svg", "one.pdf", *asked, "--report", "report.json"]) == 0
    assert main(["redo", "one.svg", "two.svg", "--quiet"]) == 0
    assert Path("one.svg").read_bytes() == Path("two.svg").read_bytes()
    report = json.loads(Path("report.json").read_text(encoding="utf-8"))
    assert report["marks"] == pytest.approx(400, rel=0.02) and len(report["inks"]) == 2
