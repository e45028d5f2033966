"""The calibration sheet is at true size, black alone, the same each time, and has what is to be measured."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pikepdf
import pytest
import rendering
from scipy import ndimage

from crowquill import calibration, formats, glyphs, measure
from crowquill.__main__ import main
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.sheet import Sheet

PIXELS = 50.0  # to the mm: 1270 dpi


@pytest.fixture(scope="module")
def page() -> Sheet:
    return calibration.sheet()


@pytest.fixture(scope="module")
def pdf(page: Sheet) -> bytes:
    return formats.to_bytes(page, "pdf")


def art(page: Sheet, name: str):
    return next(layer.art for layer in page.layers if layer.name == name)


def ends(profile: np.ndarray) -> float:
    """The distance of the middles of the first and the last tick in a profile of ink, mm."""
    tick, n = ndimage.label(profile > 0.02)
    middles = ndimage.center_of_mass(profile, tick, [1, n])
    assert n == 101
    return (middles[1][0] - middles[0][0]) / PIXELS


@pytest.mark.parametrize("format", ["pdf", "svg"])
@pytest.mark.parametrize("name", ["ruler", "upright ruler"])
def test_both_rulers_are_100_mm_long_on_the_rendered_page_within_10_um(page: Sheet, format: str, name: str):
    low, high = (f(art(page, name).xy, axis=0) for f in (np.min, np.max))
    low, high = np.floor(low) - 1, np.ceil(high) + 1
    window = rendering.Window(*low, *(high - low))
    render = rendering.pdfium if format == "pdf" else rendering.resvg
    ink = render(formats.to_bytes(page, format), window, PIXELS)
    along = name != "ruler"
    short = calibration.TICKS[1]  # where every tick is
    first = round((1 + short / 2) * PIXELS) if not along else round((art(page, name).xy[:, 0].min() - low[0] + short / 2) * PIXELS)
    profile = ink[:, first - 5 : first + 5].mean(axis=1) if along else ink[first - 5 : first + 5].mean(axis=0)
    assert abs(ends(profile) - 100) < 0.010


def test_the_measure_of_a_ruler_sees_20_um():
    x = np.arange(110 * PIXELS) / PIXELS
    profile = np.max([np.clip(1 - np.abs(x - 5 - k * 1.0002) / 0.05, 0, 1) for k in range(101)], axis=0)
    assert abs(ends(profile) - 100.02) < 0.002


def test_it_is_black_alone_with_its_words_as_text_of_an_embedded_font(page: Sheet, pdf: bytes):
    assert {layer.ink.cmyk for layer in page.layers} == {(0, 0, 0, 1)}
    with pikepdf.open(io.BytesIO(pdf)) as document:
        fonts = [font for font in document.objects if isinstance(font, pikepdf.Dictionary) and font.get("/Type") == "/FontDescriptor"]
        assert fonts and all(any(key.startswith("/FontFile") for key in font.keys()) for font in fonts)  # noqa: SIM118
        content = document.pages[0].Contents.read_bytes() if not isinstance(document.pages[0].Contents, pikepdf.Array) else b""
    assert b" rg" not in content and b" RG" not in content


def test_each_time_it_is_the_same(pdf: bytes):
    assert formats.to_bytes(calibration.sheet(), "pdf") == pdf


def test_dots_holes_and_lines_have_the_sizes_written(page: Sheet):
    dots = 2 * art(page, "dots").scale / np.sqrt(np.pi)
    assert np.allclose(np.unique(np.round(dots, 2)), calibration.DOTS) and min(calibration.DOTS) == 0.05 and max(calibration.DOTS) == 0.8
    assert np.allclose(dots.reshape(len(calibration.DOTS), 6), np.array(calibration.DOTS)[:, None], atol=1e-3)
    holes = -art(page, "holes").areas[1:]  # whole micrometres, in which a ring of 0.05 mm is a little rough
    assert np.allclose(2 * np.sqrt(holes / np.pi), dots, atol=2e-3)
    for name, sign in (("lines", 1), ("white lines", -1)):
        paths = art(page, name)
        boxes = np.array([np.ptp(ring, axis=0) for ring in paths if len(ring) == 4][0 if sign == 1 else 1 :])
        assert np.allclose(boxes.min(axis=1).reshape(-1, 4), np.array(calibration.LINES)[:, None])
        assert (boxes.argmin(axis=1).reshape(-1, 4) == [0, 0, 1, 1]).all(), "upright and level"
        assert (np.sign(paths.areas[-len(boxes) :]) == sign).all()


def test_a_step_of_tone_covers_what_its_number_says(page: Sheet):
    dots, solid = art(page, "tones"), art(page, "solid")
    side = np.ptp(solid.xy[:, 0])
    names = art(page, "tones asked")
    left = [x for text, (x, _) in zip(names.text, names.xy, strict=True) if text != "solid"]
    top = solid.xy[:, 1].min()
    pitch = (solid.xy[:, 0].min() - calibration.MARGIN - calibration.BESIDE) / len(calibration.STEPS)
    for k, step in enumerate(calibration.STEPS):
        corner = np.array([calibration.MARGIN + calibration.BESIDE + k * pitch, top])
        assert corner[0] - 1 < left[k] < corner[0] + side
        here = dots.take(((dots.xy > corner - 1e-3) & (dots.xy < corner + side + 1e-3)).all(axis=1))
        # dots may reach over the edge by half their width, and cover a little less of the square
        assert abs(measure.ink(here) / side**2 - min(step / 100, 0.97)) < 0.01, step


def test_every_nib_that_comes_along_has_its_row_at_its_own_size(page: Sheet):
    rows = {layer.name: layer.art for layer in page.layers if isinstance(layer.art, Marks) and layer.name in glyphs.names()}
    assert set(rows) == {name for name in glyphs.names() if len(glyphs.load(name).glyphs) > 1}
    for name, marks in rows.items():
        sizes = [glyph.size for glyph in glyphs.load(name).glyphs[: len(marks)]]
        assert np.allclose(2 * marks.scale / np.sqrt(np.pi), sizes, atol=2e-3) and len(marks) >= 20


@pytest.mark.parametrize("paper", ["a5", "297x210mm"])
def test_all_lies_on_the_paper_inside_a_margin(paper: str):
    page = calibration.sheet(paper, 1.0)
    for layer in page.layers:
        xy = layer.art.outlines().flat(0.01).xy if not isinstance(layer.art, Paths) else layer.art.xy
        assert (xy > 8).all() and (xy < np.array(page.size) - 8).all(), layer.name


def test_the_command_writes_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, pdf: bytes):
    monkeypatch.chdir(tmp_path)
    assert main(["calibrate", "a.pdf", "a.svg"]) == 0
    assert Path("a.pdf").read_bytes() == pdf and Path("a.svg").exists()


@pytest.mark.parametrize(
    "more",
    [
        ["--paper", "b9"],
        ["--paper", "100x300mm"],
        ["--paper", "210x100mm"],
        ["--pen", "0"],
        ["--pen", "9"],
        ["--pen", "99mm"],
        ["--pen", "nan"],
    ],
)
def test_a_sheet_that_cannot_be_is_refused_in_one_line(
    more: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    assert main(["calibrate", "a.pdf", *more]) == 2
    line = capsys.readouterr().err
    assert line.startswith("crowquill: ") and line.count("\n") == 1 and "; " in line and not Path("a.pdf").exists()


def test_a_format_that_is_none_is_refused(capsys: pytest.CaptureFixture[str]):
    assert main(["calibrate", "a.docx"]) == 2 and "; " in capsys.readouterr().err
