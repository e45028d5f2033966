"""The style halftone: the same cells as pixels, as outlines and as dots, at the size asked for, with the tone asked for."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import memory
import numpy as np
import pytest
import shapely
from PIL import Image
from test_styles import DEGENERATE

import crowquill
from crowquill import Sheet, Tone, formats, halftone, measure, raster, styles
from crowquill.__main__ import main
from crowquill.halftone.averages import averaged
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.sheet import Bitmap
from crowquill.units import INCH

RAMP = Tone(np.tile(np.linspace(0, 0.9, 80), (60, 1)), (40.0, 30.0))
FORMS = ("pixels", "polygons", "dots")


def drawn(tone: Tone = RAMP, **knobs: Any) -> Sheet:
    return crowquill.draw("halftone", tone, **knobs)


def pixels(tone: Tone = RAMP, **knobs: Any) -> Bitmap:
    art = drawn(tone, form="pixels", **knobs).layers[0].art
    assert isinstance(art, Bitmap)
    return art


def black(art: Bitmap) -> np.ndarray[Any, Any]:
    return art.rows(0, len(art.bits))


def test_three_forms_draw_the_same_cells() -> None:
    bitmap, outlines, dots = (drawn(form=form, cell=0.4).layers[0].art for form in FORMS)
    assert isinstance(bitmap, Bitmap) and isinstance(outlines, Paths) and isinstance(dots, Marks)
    cells = black(bitmap)
    cover = raster.covered(outlines, cells.shape, pixel=(0.4, 0.4))
    assert cells.shape == (75, 100) and np.abs(cover - cells).max() < 0.01  # micrometres
    row, column = np.nonzero(cells)
    assert dots.xy == pytest.approx((np.stack([column, row], axis=1) + 0.5) * 0.4, abs=1e-3)
    # a dot has a cell's area: nibs draw dots that differ, and a fifth more or less is what they do
    assert (dots.scale**2).mean() == pytest.approx(0.16, rel=0.01) and np.ptp(dots.scale) < 0.2


@pytest.mark.parametrize("method", halftone.KEEPING)
@pytest.mark.parametrize("form", ["pixels", "polygons"])
def test_ink_is_what_is_asked_for(method: str, form: str) -> None:
    sheet = drawn(method=method, form=form, cell=0.2, seed=4)
    assert sheet.report["ink_placed_mm2"] == pytest.approx(RAMP.ink, rel=0.02 if method in ("random", "bayer") else 0.006)
    assert sheet.report["tone_error"] < (0.08 if method == "random" else 0.07 if method == "diffuse-1d" else 0.03)
    assert sheet.report["warnings"] == []


@pytest.mark.parametrize("method", ["threshold", "atkinson"])
def test_a_method_that_does_not_keep_tone_says_so_with_the_ink(method: str) -> None:
    tone = Tone(np.full((40, 40), 0.2), (20.0, 20.0))
    (said,) = drawn(tone, method=method).report["warnings"]
    assert method == "threshold" or said.startswith("atkinson does not keep tone: ")
    assert method == "atkinson" or said.startswith("no cell is black")


def test_the_tone_error_is_that_of_blocks_of_cells() -> None:
    sheet = drawn(Tone(np.full((1, 1), 0.25), (16.0, 16.0)), form="pixels", cell=0.5, method="bayer")
    cells = black(sheet.layers[0].art)  # type: ignore[arg-type]
    off = cells.reshape(4, 8, 4, 8).mean(axis=(1, 3)) - 0.25
    assert sheet.report["tone_error"] == pytest.approx(np.sqrt((off**2).mean()), abs=1e-12)
    # of a picture that is half ink and drawn white, by hand
    none = drawn(Tone(np.full((1, 1), 0.49), (16.0, 16.0)), form="pixels", cell=0.5, method="threshold")
    assert none.report["tone_error"] == pytest.approx(0.49, abs=1e-9) and len(none.layers[0].art) == 0


def test_dots_tell_how_much_of_their_ink_is_lost_where_they_overlap() -> None:
    sheet = drawn(form="dots", cell=0.5, glyphs="disc")
    art = sheet.marks
    assert sheet.report["ink_placed_mm2"] == pytest.approx(measure.ink(art), rel=1e-9)
    assert sheet.report["overlap"] == pytest.approx(1 - measure.ink(art) / (len(art) * 0.25), abs=1e-4) and sheet.report["overlap"] > 0.02
    assert any("polygons lose none" in said for said in sheet.report["warnings"])


def test_cells_have_the_size_asked_for_and_lie_in_the_middle() -> None:
    for knobs, dpi in (({"cell": 0.35}, INCH / 0.35), ({"cells_per_inch": 90}, 90.0), ({}, INCH / 0.3)):
        art = pixels(**knobs)
        assert art.dpi == dpi
        assert (art.corner * 2 + art.size) == pytest.approx(RAMP.size, abs=2e-3)  # the corner is in whole micrometres
        assert np.abs(np.array(art.size) - RAMP.size).max() <= INCH / dpi / 2 + 1e-9


def test_a_cell_takes_the_mean_under_it() -> None:
    tone = Tone(np.random.default_rng(0).random((30, 40)), (20.0, 15.0))
    art = pixels(tone, cell=1.5, method="threshold")
    x, y = ((at + 1.5 * np.arange(n + 1)) * 2 for at, n in zip(art.corner, (13, 10), strict=True))
    inside = averaged(np.ones((30, 40)), x, y)  # the last columns hang over
    assert (black(art) == (averaged(np.array(tone.coverage), x, y) / inside >= 0.5)).all()


def test_cells_whose_middle_is_outside_the_canvas_stay_white_and_all_others_are_drawn() -> None:
    canvas = shapely.Point(20, 15).buffer(13) - shapely.box(15, 12, 26, 17)
    art = pixels(Tone(np.ones((3, 4)), (40.0, 30.0), canvas), cell=0.5)
    row, column = np.indices(black(art).shape)
    assert (black(art) == shapely.contains_xy(canvas, 0.5 * column + 0.25, 0.5 * row + 0.25)).all()


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", DEGENERATE)
def test_every_form_has_an_answer_to_an_awkward_tone(form: str, name: str) -> None:
    sheet = drawn(DEGENERATE[name], form=form, method="zhou-fang")
    again = crowquill.load(io.BytesIO(crowquill.to_bytes(sheet, "svg")))
    assert [len(layer.art) for layer in again.layers] == [len(layer.art) for layer in sheet.layers]
    assert len(sheet.layers[0].art) or sheet.report["warnings"]


def test_auto_is_outlines_until_they_have_too_many_corners(monkeypatch: pytest.MonkeyPatch) -> None:
    assert isinstance(drawn().layers[0].art, Paths)
    monkeypatch.setattr("crowquill.styles.halftone.CORNERS", 1000)
    assert isinstance(drawn().layers[0].art, Bitmap)
    with pytest.raises(ValueError, match=r"^outlines of cells of 0.3 mm have over 1000 corners, more than files bear; use"):
        drawn(form="polygons")


@pytest.mark.parametrize(
    ("knobs", "said"),
    [
        ({"cell": 31.0}, "^a cell of 31 mm is wider than the canvas of 30 mm; use smaller ones$"),
        ({"cell": 0.3, "cells_per_inch": 85}, "^cell 0.3 mm and cells-per-inch 85 are both given; leave one out$"),
        ({"form": "dots", "cell": 0.1, "max_dots": 10}, r"^the picture takes 54000 dots, over the limit of 10; use larger cells, or .*$"),
        ({"cell": 0.0}, "cell is 0.0; it takes a number from 0.005 to 50 mm"),
        ({"method": "bayers"}, "no method 'bayers'; there are .*bayer"),
    ],
)
def test_what_cannot_be_drawn_is_said_before_any_work(knobs: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        next(styles.steps("halftone", RAMP, **knobs))


def test_more_cells_than_a_file_holds_are_refused_before_memory_is_taken() -> None:
    with pytest.raises(
        ValueError, match=r"^a cell of 0.005 mm makes 400000 x 400000 cells of this picture, over the limit of 2000 million; "
    ):
        next(styles.steps("halftone", Tone([[0.5]], (2000.0, 2000.0)), cell=0.005))


def test_importance_is_said_to_be_of_no_use() -> None:
    tone = Tone(np.full((4, 4), 0.5), (8.0, 8.0), importance=np.ones((4, 4)))
    assert drawn(tone).report["warnings"] == ["importance is not heeded: cells are all of one size; stippling heeds it"]


def test_a_1_bit_tiff_has_the_cells_themselves_at_their_dpi(tmp_path: Path) -> None:
    Image.fromarray(np.uint8(255 * (1 - RAMP.coverage))).save(tmp_path / "ramp.png")
    out = [str(tmp_path / name) for name in ("a.tiff", "a.png")]
    picture = str(tmp_path / "ramp.png")
    args = ["--cells-per-inch", "300", "--form", "pixels", "--paper", "60x50mm", "--margin", "5mm", "--quiet"]
    assert main(["halftone", picture, *out, *args]) == 0
    assert main(["halftone", picture, str(tmp_path / "b.tiff"), *args, "--dry-run"]) == 0 and not (tmp_path / "b.tiff").exists()
    tiff, png = (Image.open(name) for name in out)
    assert tiff.mode == png.mode == "1" and tiff.info["dpi"] == (300, 300) and tiff.info["compression"] == "group4"
    tone = Tone.load(picture, width=50)
    ink = ~np.asarray(tiff)
    assert ink.sum() * (INCH / 300) ** 2 == pytest.approx(tone.ink, rel=0.005) and (ink == ~np.asarray(png)).all()


@pytest.mark.parametrize(("names", "form"), [(["a.png"], "1"), (["a.tiff", "a.png"], "1"), (["a.png", "a.svg"], "L")])
def test_auto_is_pixels_where_all_files_are(tmp_path: Path, names: list[str], form: str) -> None:
    Image.fromarray(np.uint8(255 * (1 - RAMP.coverage))).save(tmp_path / "ramp.png")
    out = [str(tmp_path / name) for name in names]
    assert main(["halftone", str(tmp_path / "ramp.png"), *out, "--cells-per-inch", "150", "--paper", "60x50mm", "--quiet"]) == 0
    with Image.open(tmp_path / "a.png") as png:
        assert png.mode == form


A4 = """
import numpy as np
from crowquill import Tone, draw, formats
y, x = np.mgrid[0:1400, 0:1000] / 1000
sheet = draw("halftone", Tone(0.5 + 0.45 * np.sin(9 * x * y), (210, 297)), cells_per_inch=1200, form="pixels")
data = formats.to_bytes(sheet, "tiff")
print(len(data))
"""


@pytest.mark.soak
def test_a4_at_1200_dpi_takes_less_than_a_gigabyte() -> None:
    (size,), kilobytes = memory.taken(A4)
    assert kilobytes < 1_000_000 and size > 1_000_000


@pytest.mark.parametrize("form", FORMS)
def test_every_format_takes_every_form(form: str) -> None:
    sheet = drawn(form=form, cell=0.5)
    for format in ("png", "tiff", "svg", "pdf"):
        assert len(formats.to_bytes(sheet, format)) > 500
