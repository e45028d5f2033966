"""Scanned dots on a halftone's black pixels: the published figures, tone kept, inverted parts, edges, and bad input."""

from __future__ import annotations

import io
import json
import re
from functools import cache
from pathlib import Path
from typing import Any

import memory
import numpy as np
import pypdfium2
import pytest
import shapely
from PIL import Image
from scipy import stats

from crowquill import Tone, draw, formats, glyphs, inkdots, making, raster, texture
from crowquill.__main__ import main
from crowquill.formats import _bitmap
from crowquill.greydots import overlaid
from crowquill.halftone import halftoned
from crowquill.inkdots import JITTER, PITCH, PIXEL, Dots, flat, measured, rows_along
from crowquill.marks import Marks
from crowquill.paths import Array, Paths
from crowquill.sheet import Sheet

CELLS = 80  # a side of the flat patches: 6400 candidates, of whose tone chance moves some 0.3 %
NEAR = 0.03  # by which other scans of like dots may differ from the published ones

# Darkness of flat patches of the authors' program with its own scans, boxes of 4 to 7 pixels, candidates so many pixels of 300 dpi apart.
TONES = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 0.9, 1.0)
GREY = {
    2: (0.078, 0.153, 0.291, 0.406, 0.500, 0.585, 0.705, 0.793, 0.827),
    3: (0.035, 0.069, 0.136, 0.201, 0.259, 0.322, 0.414, 0.500, 0.542),
    4: (0.020, 0.038, 0.077, 0.115, 0.152, 0.191, 0.258, 0.323, 0.355),
}
BLACK = {  # at 1200 dpi and 3 pixels, black where the code is this or less
    200: (0.069, 0.134, 0.266, 0.376, 0.480, 0.602, 0.714, 0.820, 0.867),
    128: (0.035, 0.068, 0.140, 0.206, 0.283, 0.363, 0.493, 0.620, 0.681),
}


@cache
def patch(tone: float, pitch: float = PITCH, jitter: float = JITTER) -> Marks:
    return flat(Dots.of(), tone, pitch, jitter, np.random.default_rng(3), CELLS)


@cache
def sheet(tone: float, **knobs: Any) -> Sheet:
    return draw("inkdots", Tone(np.full((4, 4), tone), (CELLS * PITCH, CELLS * PITCH)), seed=4, **knobs)


def darkness(drawing: Sheet, **values: Any) -> float:
    """Of the sheet's middle: dots at its edge hang over."""
    image = np.asarray(Image.open(io.BytesIO(formats.to_bytes(drawing, "png", **values))).convert("L"))
    edge = len(image) // 20
    return 1 - float(image[edge:-edge, edge:-edge].mean()) / 255


def test_pages_have_the_published_numbers_of_pixels_and_candidates() -> None:
    a4, a5 = (210.0, 297.0), (148.0, 210.0)
    wanted = [((2480, 3508), a4, 300), ((1748, 2480), a5, 300), ((3496, 4961), a5, 600), ((6992, 9921), a5, 1200)]
    for pixels, size, dpi in wanted:
        assert _bitmap.pixels(size, dpi, bilevel=False) == pixels
    assert draw("inkdots", Tone([[0.0]], a4)).report["candidates"] == 827 * 1169


@pytest.mark.parametrize("apart", GREY)
def test_flat_patches_of_grey_dots_are_as_dark_as_the_published_ones(apart: int) -> None:
    found = [overlaid(patch(tone, apart * PIXEL), (CELLS, CELLS), pixel=(apart * PIXEL,) * 2).mean() for tone in TONES]
    assert found == pytest.approx(GREY[apart], abs=NEAR)


@pytest.mark.parametrize("code", BLACK)
def test_flat_patches_in_black_and_white_are_as_dark_as_the_published_ones(code: int) -> None:
    pixel = 25.4 / 1200
    grid = (int(CELLS * PITCH / pixel),) * 2
    found = [(overlaid(patch(tone), grid, pixel=(pixel, pixel)) >= 1 - (code + 0.5) / 255).mean() for tone in TONES]
    assert found == pytest.approx(BLACK[code], abs=NEAR)


def test_the_check_of_flat_patches_sees_another_pitch() -> None:
    found = [overlaid(patch(tone, 4 * PIXEL), (CELLS, CELLS), pixel=(4 * PIXEL,) * 2).mean() for tone in TONES]
    assert np.abs(np.array(found) - GREY[3]).max() > 2 * NEAR


def test_half_grey_on_a4_takes_483_000_dots_one_for_each_black_candidate() -> None:
    quarter = draw("inkdots", Tone(np.full((9, 7), 0.5), (105.0, 148.5)), curve="none")
    assert 4 * quarter.report["marks"] == pytest.approx(483_000, rel=0.005)
    assert quarter.report["marks"] == quarter.report["black"] == len(quarter.marks)


def test_dots_lie_evenly_up_to_the_jitter_off_the_middles_of_candidates() -> None:
    off = sheet(0.5).marks.xy % PITCH - PITCH / 2  # half a pitch each way: each dot lies in its own candidate
    for way in off.T:
        inner = way[np.abs(way) < JITTER - 1e-3]  # whole micrometres
        assert np.abs(way).max() <= JITTER + 1e-3 and stats.kstest(inner, stats.uniform(-JITTER, 2 * JITTER).cdf).pvalue > 0.01
    still = sheet(0.5, jitter=0.0).marks.xy % PITCH - PITCH / 2
    assert np.abs(still).max() <= 0.5e-3 + 1e-9


def test_each_size_class_comes_as_often_and_each_scan_of_it() -> None:
    dots = Dots.of()
    marks = dots.at(np.zeros((24_000, 2)), 0.0, np.random.default_rng(1))
    assert stats.chisquare(np.bincount(marks.glyph, minlength=120)).pvalue > 0.01
    nibs = [glyph for size in inkdots.SIZES for glyph in glyphs.load(glyphs.nearest(size)).glyphs]
    assert marks.scale == pytest.approx(np.array([glyph.size for glyph in nibs])[marks.glyph] * np.sqrt(np.pi) / 2)  # as large as they were


def test_sizes_are_mean_diameters_of_scaled_dots() -> None:
    dots = Dots.of("brush", (0.2, 0.4))
    assert [2 * dots.scale[lo:hi].mean() / np.sqrt(np.pi) for lo, hi in ((0, 48), (48, 96))] == pytest.approx([0.2, 0.4])
    assert 2 * Dots.of("brush").scale[7] / np.sqrt(np.pi) == pytest.approx(glyphs.load("brush").glyphs[7].size)


def grid(jitter: float) -> Array:
    """Discs that cover .2 on all of 32 x 32 candidates, as pixels of ink, 32 to a candidate."""
    xy = (np.stack(np.meshgrid(np.arange(32), np.arange(32)), axis=-1).reshape(-1, 2) + 0.5) * PITCH
    moved = xy + np.random.default_rng(0).uniform(-jitter, jitter, xy.shape)
    discs = Marks.of(moved, glyphs.load("disc").glyphs, scale=np.sqrt(0.2) * PITCH)
    return texture.quantised(raster.covered(discs, (1024, 1024), pixel=(PITCH / 32,) * 2))


def correlation(ink: Array, off: int) -> float:
    """c at one candidate, so many pixels: the mean of along the rows and down."""
    return float(np.mean([texture.features(texture.matrix(ink, *way))["correlation"] for way in ((0, off), (off, 0))]))


@pytest.mark.parametrize(("jitter", "wanted"), [(0.0, 1.0), (JITTER / 2, 0.24), (JITTER, -0.01)])
def test_chance_hides_the_grid_as_it_is_published(jitter: float, wanted: float) -> None:
    assert correlation(grid(jitter), 32) == pytest.approx(wanted, abs=0.03)  # 1024 dots: chance alone is .02


def test_what_is_left_in_a_flat_patch_is_the_halftones_own_and_not_the_grid() -> None:
    """At .3 neighbours in a row are shunned: -.43 of the halftone's pixels, of which -.08 is left when dots have moved.

    That is below the .05 wanted of a patch; of coins tossed it would be above, as dots lie over one another. One candidate is .55
    mean spacings there, where jittered grids have -.10 and relaxed sites -.2. One and two spacings off next to nothing is left.
    """
    black = halftoned(np.full((200, 200), 0.3), rng=np.random.default_rng(3)) - 0.3
    assert (black[:, 1:] * black[:, :-1]).mean() / black.var() == pytest.approx(-0.43, abs=0.02)
    ink = raster.covered(patch(0.3), (CELLS * 12,) * 2, pixel=(PITCH / 12,) * 2)
    assert correlation(texture.quantised(ink), 12) == pytest.approx(-0.08, abs=0.02)
    assert np.abs(texture.curves(ink, (PITCH / 12,) * 2, PITCH / 0.3**0.5).mean([1, 2])).max() < 0.05
    still = raster.covered(patch(0.3, jitter=0.0), (CELLS * 12,) * 2, pixel=(PITCH / 12,) * 2)
    assert correlation(texture.quantised(still), 12) < -0.12  # what chance has to hide


@pytest.mark.parametrize("tone", [0.05, 0.2, 0.35, 0.5, 0.65, 0.75])
def test_black_dots_keep_the_tone_as_outlines_and_cut_at_any_resolution(tone: float) -> None:
    drawing = sheet(tone)
    assert drawing.report["tone_of"] == "black" and drawing.report["darkest"]["black"] > 0.8 and drawing.report["out_of_reach"] == 0
    assert darkness(drawing, grey_dots=False) == pytest.approx(tone, abs=NEAR)
    for dpi in (600, 1200):
        assert darkness(drawing, dpi=dpi, bilevel=True) == pytest.approx(tone, abs=NEAR)
    assert darkness(drawing, dpi=300, bilevel=True) == pytest.approx(tone, abs=4 / 3 * NEAR)  # four pixels to a dot
    assert darkness(drawing) < tone  # scans are no full black


@pytest.mark.parametrize("tone", [0.05, 0.2, 0.35, 0.5])
def test_grey_dots_keep_the_tone_where_that_is_asked_for(tone: float) -> None:
    drawing = sheet(tone, curve="measured-grey")
    for dpi in (300, 600, 1200):
        assert darkness(drawing, dpi=dpi) == pytest.approx(tone, abs=NEAR)
    assert drawing.report["ink_placed_mm2"] == pytest.approx(drawing.report["ink_asked_mm2"], abs=NEAR * (CELLS * PITCH) ** 2)  # light


@pytest.mark.parametrize(("curve", "form"), [("measured", "black"), ("measured-grey", "grey")])
def test_what_is_out_of_reach_is_said_and_the_pitch_that_would_do(curve: str, form: str) -> None:
    report = sheet(0.95, curve=curve).report
    assert report["out_of_reach"] == pytest.approx(1 - report["darkest"][form] / 0.95, abs=1e-9)
    said = re.search(r"all candidates together take 0\.\d\d .* a finer pitch would help, such as ([.\d]+)mm$", report["warnings"][0])
    assert said is not None
    fine = draw("inkdots", Tone([[0.95]], (8, 8)), curve=curve, pitch=float(said[1])).report
    assert fine["out_of_reach"] < 0.02 and not fine["warnings"]


FILES = {  # options, and whether dots are grey in the file
    "a.png": ([], True),
    "b.tiff": (["--dpi", "1200"], True),
    "c.png": (["--dpi", "1200", "--bilevel"], False),
    "e.svg": ([], False),
    "g.pdf": (["--grey-dots"], True),
}


def typed(folder: Path, *arguments: str) -> dict[str, Any]:
    """The report of a picture of one grey, drawn 14 mm wide on its own paper by the command line."""
    Image.fromarray(np.full((40, 40), 140, np.uint8)).save(folder / "picture.png")
    page = ["--paper", "14x14mm", "--margin", "0mm", "--tone", "grey", "--report", str(folder / "report.json"), "--quiet"]
    assert main(["inkdots", str(folder / "picture.png"), *arguments, *page]) == 0
    found: dict[str, Any] = json.loads((folder / "report.json").read_text())
    return found


@pytest.mark.parametrize("name", FILES)
def test_each_file_keeps_the_tone_in_the_form_that_it_shows(name: str, tmp_path: Path) -> None:
    options, grey = FILES[name]
    report = typed(tmp_path, str(tmp_path / name), *options)
    assert (report["curve"], report["warnings"]) == (f"measured-{'grey' if grey else 'black'}", [])
    if name.endswith(("svg", "pdf")):
        pages = pypdfium2.PdfDocument(tmp_path / name)[0].render(scale=300 / 72, grayscale=True).to_pil() if name.endswith("pdf") else None
        image = pages or Image.open(io.BytesIO(formats.to_bytes(formats.load(tmp_path / name), "png", grey_dots=False)))
    else:
        image = Image.open(tmp_path / name)
    shown = np.asarray(image.convert("L"))
    edge = len(shown) // 20
    assert 1 - shown[edge:-edge, edge:-edge].mean() / 255 == pytest.approx(1 - 140 / 255, abs=NEAR)


def test_files_of_two_forms_show_the_same_dots_and_which_of_them_keeps_the_tone_is_said(tmp_path: Path) -> None:
    png, svg = str(tmp_path / "a.png"), str(tmp_path / "b.svg")
    one, other = typed(tmp_path, png, svg), typed(tmp_path, svg, png)
    assert (one["curve"], other["curve"]) == ("measured-grey", "measured-black")
    (first,), (second,) = one["warnings"], other["warnings"]
    assert first.startswith(f"{svg}: dots are black there, and all is darker than the picture") and "--curve measured-black" in first
    assert second.startswith(f"{png}: dots are grey there, and all is lighter than the picture") and "--curve measured-grey" in second
    assert len(typed(tmp_path, png, "--no-grey-dots", "--curve", "measured-grey")["warnings"]) == 1
    assert not typed(tmp_path, svg, png, "--curve", "none")["warnings"]


def test_with_a_curve_named_each_resolution_and_format_has_the_same_dots(tmp_path: Path) -> None:
    grey = typed(tmp_path, str(tmp_path / "a.png"), "--curve", "none", "--dpi", "600")
    black = typed(tmp_path, str(tmp_path / "b.png"), str(tmp_path / "b.svg"), "--curve", "none", "--dpi", "1200", "--bilevel")
    assert grey["marks"] == black["marks"]
    drawn = formats.load(tmp_path / "b.svg").marks  # and its own PNG is of this sheet: see test_grey_dots
    again = making.redo(tmp_path / "a.png", picture=tmp_path / "picture.png").marks
    assert np.abs(drawn.xy - again.xy).max() < 0.01 and np.array_equal(drawn.glyph, again.glyph)
    assert drawn.scale == pytest.approx(again.scale, rel=1e-4)


@pytest.mark.parametrize(("pitch", "jitter"), [(25.0, 0.1), (3.0, 25.0), (0.05, 25.0)])
def test_tones_are_measured_at_any_pitch_and_jitter(pitch: float, jitter: float) -> None:
    dots = Dots.of()
    reached = measured(dots, pitch, jitter)
    alone = np.pi / 4 * (dots.mean / pitch) ** 2  # of the paper, if none met another
    assert reached.black[-1] == pytest.approx(alone, rel=0.02) if pitch > 1 else reached.black[-1] > 0.999


def test_the_published_method_asks_for_the_tone_itself() -> None:
    drawing = sheet(0.5, curve="none")
    assert drawing.report["black"] == pytest.approx(CELLS**2 / 2, rel=0.01) and darkness(drawing) == pytest.approx(0.322, abs=NEAR)


def test_reached_tones_rise_and_do_not_hang_on_the_seed() -> None:
    reached = measured(Dots.of(), PITCH, JITTER)
    assert (np.diff(reached.black) > 0).all() and reached.grey is not None and (np.diff(reached.grey) > 0).all()
    assert reached.asked(np.array([0.0, 1.0]), "black").tolist() == [0, 1]
    assert sheet(0.3).report["darkest"] == draw("inkdots", Tone([[0.3]], (5, 5)), seed=9).report["darkest"]


@pytest.fixture
def mask(tmp_path: Path) -> str:
    light = np.zeros((40, 40), np.uint8)
    light[:, 20:] = 255
    Image.fromarray(light).save(tmp_path / "mask.png")
    return str(tmp_path / "mask.png")


@pytest.mark.parametrize("tone", [0.3, 0.6, 0.9])
def test_inverted_parts_are_white_dots_on_black_and_keep_the_tone(mask: str, tone: float) -> None:
    drawing = draw("inkdots", Tone(np.full((8, 8), tone), (24, 24)), invert_mask=mask)
    ground, black, white = drawing.layers
    assert [layer.label for layer in drawing.layers] == ["ground", "dots", "white dots"]
    assert isinstance(ground.art, Paths) and ground.art.areas.sum() == pytest.approx(12 * 24, abs=0.1)
    assert isinstance(black.art, Marks) and isinstance(white.art, Marks)
    assert black.art.xy[:, 0].max() <= 12 <= white.art.xy[:, 0].min()
    image = np.asarray(Image.open(io.BytesIO(formats.to_bytes(drawing, "png", dpi=254, grey_dots=False))))
    for half, reach in ((image[10:-10, 10:110], 0.79), (image[10:-10, 130:-10], 1.0)):
        assert 1 - half.mean() / 255 == pytest.approx(min(tone, reach), abs=NEAR)
    assert drawing.report["ink_placed_mm2"] == pytest.approx((1 - image.mean() / 255) * 24**2, rel=0.01)


def test_edges_are_rows_of_dots_that_just_touch() -> None:
    tone = Tone(np.repeat([[0.0, 0.6]], 100, axis=1).repeat(100, axis=0), (20, 10))
    plain, drawn = draw("inkdots", tone), draw("inkdots", tone, edges=0.4)
    rows = drawn.marks.xy[len(plain.marks) :]
    assert len(rows) == drawn.report["edge_dots"] == pytest.approx(10 / Dots.of().mean, abs=2)
    assert np.abs(rows[:, 0] - 10).max() < 0.05 + JITTER / 4 and np.array_equal(drawn.marks.xy[: len(plain.marks)], plain.marks.xy)
    assert draw("inkdots", Tone([[0.5]], (5, 5)), edges=0.4).report["edge_dots"] == 0


def test_points_along_lines_are_evenly_apart_and_hold_the_ends() -> None:
    bent = rows_along(Paths.of([[(0, 0), (1, 0), (1, 1)], [(3, 3), (3.01, 3)]], closed=False), 0.5)
    assert bent.tolist() == [[0, 0], [0.5, 0], [1, 0], [1, 0.5], [1, 1], [3, 3], [3.01, 3]]
    assert rows_along(Paths.of([], closed=False), 0.5).shape == (0, 2)


def test_no_dot_leaves_the_canvas() -> None:
    canvas = shapely.Point(8, 8).buffer(6)
    marks = draw("inkdots", Tone(np.ones((4, 4)), (16, 16), canvas), edges=0.3).marks
    assert shapely.intersects_xy(canvas, *marks.xy.T).all() and len(marks) > 1500


def test_a_library_without_scans_is_drawn_by_its_outlines_and_said() -> None:
    report = sheet(0.4, glyphs="disc", sizes=(0.3,), curve="measured-grey").report
    assert set(report["darkest"]) == {"black"} and report["warnings"] == ["this library has no scans: tone is kept of black dots"]
    assert darkness(sheet(0.4, glyphs="disc", sizes=(0.3,))) == pytest.approx(0.4, abs=NEAR)


A4 = """
import numpy as np
import sys
from pathlib import Path
from crowquill import Tone, draw, save
x = np.mgrid[0:1200, 0:850][1] / 850
sheet = draw("inkdots", Tone(0.05 + 0.45 * x, (210, 297)), curve="measured-grey")
save(sheet, sys.argv[1], dpi=1200)
print(len(sheet.marks), Path(sys.argv[1]).stat().st_size)
"""


@pytest.mark.soak
def test_a4_in_grey_at_1200_dpi_takes_less_than_a_gigabyte(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", None)
    (dots, size), kilobytes = memory.taken(A4, str(tmp_path / "a4.tiff"))
    assert kilobytes < 1_000_000 and dots > 400_000 and size > 20_000_000
    with Image.open(tmp_path / "a4.tiff") as page:
        assert page.mode == "L" and page.size == (9921, 14031)


def write(folder: Path, name: str, values: Array) -> Path:
    Image.fromarray(np.asarray(values, np.uint8)).save(folder / name)
    return folder / name


WRONG: list[tuple[list[str], str]] = [
    (["--pitch", "23mm"], "a pitch of 23 mm is wider than the canvas of 20 mm; use a finer one"),
    (["--pitch", "0.02mm", "--max-dots", "1000"], "dots, over the limit of 1000; use a wider pitch, or raise max-dots"),
    (["--pitch", "0.02mm", "--sizes", "0.6mm"], "mm are over 20 pitches of 0.02 mm wide; use a wider pitch, or smaller sizes"),
    (["--invert-mask", "none.png"], "none.png"),
    (["--invert-mask", "dark.png"], "dark.png: has no light place to draw in"),
    (["--glyphs", "nib"], "no glyph library 'nib'; there are brush"),
    (["--curve", "straight"], "straight"),
    (["--black-from", "0", "--bilevel"], "black"),
]


@pytest.mark.parametrize(("options", "said"), WRONG, ids=[" ".join(options) for options, _ in WRONG])
def test_bad_input_is_answered_in_a_line(
    options: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path, "picture.png", np.full((40, 40), 90))
    write(tmp_path, "dark.png", np.zeros((9, 9)))
    assert main(["inkdots", "picture.png", "out.png", "--width", "20mm", *options]) == 2
    told = capsys.readouterr().err
    assert said in told.splitlines()[-1] and "Traceback" not in told and not (tmp_path / "out.png").exists()
