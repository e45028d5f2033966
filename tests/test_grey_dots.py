"""Dots as they were scanned, laid over each other: ink takes its share of the light that is left, at any resolution."""

from __future__ import annotations

import io
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pikepdf
import pypdfium2
import pytest
from PIL import Image
from printing import check_archived
from scipy import ndimage
from scipy.spatial import cKDTree

from crowquill import formats, glyphs, greydots, raster
from crowquill.formats import _bitmap
from crowquill.greydots import Greys, overlaid, scanned
from crowquill.marks import Glyph, Marks, Patch
from crowquill.paths import Paths
from crowquill.sheet import Ink, Layer, Sheet

NIB = glyphs.load("nib-03", grey=True).glyphs
FINE = (0.01, 0.01)  # mm: half a pixel of the scans
BOTH = pytest.mark.parametrize("format", ["png", "tiff"])


def own(glyph: Glyph) -> float:
    """The scale at which a glyph is as large as it was."""
    return glyph.size * float(np.sqrt(np.pi)) / 2


def crowd(n: int = 150, seed: int = 1) -> Marks:
    rng = np.random.default_rng(seed)
    glyph = rng.integers(len(NIB), size=n)
    scale = np.array([own(g) for g in NIB])[glyph]
    return Marks.of(rng.uniform(0.5, 4.5, (n, 2)), NIB, scale=scale, angle=rng.uniform(0, 7, n), glyph=glyph)


def sheet(marks: Marks, size: tuple[float, float] = (5.0, 5.0)) -> Sheet:
    return Sheet(size, (Layer(Ink(), marks),))


def codes(drawing: Sheet, format: str = "png", **values: Any) -> npt.NDArray[np.float64]:
    image = Image.open(io.BytesIO(formats.to_bytes(drawing, format, **values)))
    return np.asarray(image.convert("L")).astype(np.float64)


def even(share: float, size: float = 0.3) -> Glyph:
    """A square of even ink; its outline is another matter."""
    return replace(NIB[0], size=2 * size / float(np.sqrt(np.pi)), grey=Patch(np.full((20, 20), share), size / 20, np.full(2, size / 2)))


@pytest.mark.parametrize("share", [0.2, 0.62, 1.0])
def test_two_dots_at_one_place_leave_what_each_leaves_of_the_other(share: float) -> None:
    marks = Marks.of([(0.5, 0.5)] * 2, (even(share),), scale=0.3)
    middle = overlaid(marks, (100, 100), pixel=FINE)[50, 50]
    assert middle == pytest.approx(1 - (1 - share) ** 2, abs=1e-12)
    assert overlaid(marks.take([0]), (100, 100), pixel=FINE)[50, 50] == pytest.approx(share, abs=1e-12)


def test_light_left_by_two_layers_of_dots_is_the_product_of_both() -> None:
    marks = crowd()
    one, other, both = (1 - overlaid(part, (500, 500), pixel=FINE) for part in (marks.take(slice(70)), marks.take(slice(70, None)), marks))
    assert both == pytest.approx(one * other, abs=1e-12)


def astray(glyph: Glyph, angle: float) -> float:
    """The share of a dot's outline that lies on light places, when as many of the darkest are taken as it has."""
    marks = Marks.of([(1, 1)], (glyph,), scale=own(glyph), angle=angle)
    dark, inside = overlaid(marks, (200, 200), pixel=FINE), raster.covered(marks, (200, 200), pixel=FINE) > 0.5
    level = np.sort(dark.ravel())[-int(inside.sum())]
    return float((inside & (dark < level)).sum() / inside.sum())


@pytest.mark.parametrize("angle", [0.0, 1.0, 2.5, 4.0])
def test_a_scan_lies_under_its_outline_however_the_dot_is_turned(angle: float) -> None:
    assert max(astray(glyph, angle) for glyph in NIB[:12]) < 0.03  # a sample is 0.01 mm, and the rim is some 70 of them long


def test_the_check_of_outlines_sees_a_scan_turned_or_moved() -> None:
    for glyph in NIB[:12]:
        assert glyph.grey is not None
        turned = replace(glyph, grey=replace(glyph.grey, turn=glyph.grey.turn + np.pi / 2))
        moved = replace(glyph, grey=replace(glyph.grey, centre_mm=glyph.grey.centre_mm + np.array([0.021, 0])))
        assert min(astray(turned, 1.0), astray(moved, 1.0)) > 0.03


def test_a_dot_takes_as_much_light_as_its_scan_says_at_any_size() -> None:
    for glyph in NIB[:5]:
        assert glyph.grey is not None
        said = glyph.grey.grey.sum() * glyph.grey.pixel_mm**2
        for by in (0.5, 1.0, 3.0):
            marks = Marks.of([(1.5, 1.5)], (glyph,), scale=by * own(glyph), angle=0.7)
            taken = overlaid(marks, (300, 300), pixel=FINE).sum() * 1e-4
            assert taken == pytest.approx(said * by**2, rel=5e-3)  # straight lines between pixels, met at places of their own


@pytest.mark.parametrize("dpi", [40, 72, 150, 300, 601, 1200, 2400])
def test_a_drawing_is_as_dark_at_any_resolution(dpi: float) -> None:
    marks = crowd(400)
    side = round(5 / 25.4 * dpi)
    mean = overlaid(marks, (side, side), pixel=(25.4 / dpi, 25.4 / dpi)).mean() * (side * 25.4 / dpi / 5) ** 2
    assert mean == pytest.approx(overlaid(marks, (500, 500), pixel=FINE).mean(), rel=0.01)  # whole pixels cut a part of the page off


def test_no_marks_and_marks_of_no_size_take_nothing() -> None:
    none = Marks.of(np.empty((0, 2)), NIB, scale=1.0)
    flat = Marks.of([(0.5, 0.5)], NIB, scale=0.0)
    for marks in (none, flat):
        assert not overlaid(marks, (10, 10), pixel=(0.1, 0.1)).any()
        assert not Greys.of(marks, pixel=(0.1, 0.1), width=10).touches(0, 10)
    assert not scanned(none) and scanned(flat)


def test_marks_without_scans_are_refused_in_a_line() -> None:
    plain = Marks.of([(1, 1)], glyphs.load("nib-03").glyphs, scale=0.3)
    assert not scanned(plain)
    with pytest.raises(ValueError, match=r"^1 of the marks' glyphs have no scan; draw their outlines$"):
        overlaid(plain, (10, 10), pixel=(0.1, 0.1))


def test_bands_and_cores_do_not_change_a_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    marks = crowd()
    whole = overlaid(marks, (118, 118), pixel=(25.4 / 600,) * 2)
    greys = Greys.of(marks, pixel=(25.4 / 600,) * 2, width=118)
    monkeypatch.setattr(greydots, "HELD", 500)
    monkeypatch.setattr("crowquill.kernel.CORES", 3)
    assert np.array_equal(np.concatenate([greys.rows(0, 31), greys.rows(31, 32), greys.rows(32, 118)]), whole)


def test_a_library_of_a_disc_has_no_scans_and_nibs_have_one_a_dot() -> None:
    assert all(glyph.grey is None for glyph in glyphs.load("disc", grey=True).glyphs + glyphs.load("nib-03").glyphs)
    assert all(glyph.grey is not None for glyph in NIB) and len(NIB) == 40


@BOTH
def test_bitmaps_show_scans_where_glyphs_have_them_and_outlines_on_demand(format: str) -> None:
    drawing, side = sheet(crowd()), round(5 / 25.4 * 600)
    grey, solid = codes(drawing, format), codes(drawing, format, grey_dots=False)
    taken = overlaid(drawing.marks, (side, side), pixel=(25.4 / 600,) * 2)
    assert np.abs(grey - 255 * (1 - taken)).max() <= 0.5 + 1e-9
    plain = replace(drawing.marks, glyphs=tuple(replace(glyph, grey=None) for glyph in NIB))
    assert np.array_equal(solid, codes(sheet(plain), format)) and not np.array_equal(solid, grey)


@BOTH
def test_grey_has_many_levels_and_black_and_white_two(format: str) -> None:
    drawing = sheet(crowd())
    assert len(np.unique(codes(drawing, format))) > 100
    assert np.unique(codes(drawing, format, dpi=1200, bilevel=True)).tolist() == [0, 255]


@pytest.mark.parametrize("dpi", [300, 600, 1200, 2400])
@pytest.mark.parametrize("level", [0.216, 0.28, 0.5])
def test_black_and_white_is_black_where_dots_take_that_much_light(dpi: float, level: float) -> None:
    drawing, side = sheet(crowd()), round(5 / 25.4 * dpi)
    taken = overlaid(drawing.marks, (side, side), pixel=(25.4 / dpi,) * 2)
    assert np.array_equal(codes(drawing, dpi=dpi, bilevel=True, black_from=level) == 0, taken >= level)


def test_the_published_level_is_code_200_and_darker() -> None:
    drawing = sheet(crowd())
    side = round(5 / 25.4 * 1200)
    code = np.round(255 * (1 - overlaid(drawing.marks, (side, side), pixel=(25.4 / 1200,) * 2)))
    black = codes(drawing, dpi=1200, bilevel=True, black_from=0.216) == 0
    assert (black != (code <= 200)).mean() < 0.002  # codes are rounded, and light is not


def test_white_dots_take_black_away_as_black_ones_take_light() -> None:
    ground = Layer(Ink(), Paths.of([[(0, 0), (5, 0), (5, 5), (0, 5)]]))
    white = Sheet((5, 5), (ground, Layer(Ink("white", (0, 0, 0, 0)), crowd())))
    inner = np.s_[:-1, :-1]  # the page ends within the last pixel
    assert np.abs(codes(white) + codes(sheet(crowd())) - 255)[inner].max() <= 1


def test_words_and_rules_beside_grey_dots_are_cut_at_half_a_pixel_whatever_the_level() -> None:
    box = Layer(Ink(), Paths.of([[(3, 3), (4.04, 3), (4.04, 4), (3, 4)]]))
    alone = codes(Sheet((5, 5), (box,)), dpi=254, bilevel=True)
    beside = codes(Sheet((5, 5), (box, *sheet(crowd().moved((-4, -4)).take(slice(20))).layers)), dpi=254, bilevel=True, black_from=0.1)
    assert np.array_equal(alone[25:, 25:], beside[25:, 25:])


def test_bands_of_a_bitmap_do_not_show(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = codes(sheet(crowd()), dpi=300)
    for pixels in (1, 600):
        monkeypatch.setattr(_bitmap, "PIXELS", pixels)
        assert np.array_equal(codes(sheet(crowd()), dpi=300), whole)


@pytest.mark.parametrize("values", [{"dpi": 600}, {"dpi": 1200, "bilevel": True}], ids=["grey at 600", "black and white at 1200"])
def test_any_resolution_shows_the_same_dots_at_the_same_millimetres(values: dict[str, Any]) -> None:
    at = (np.stack(np.meshgrid(np.arange(8), np.arange(8)), axis=-1).reshape(-1, 2) + 1) * 0.6 + 0.0371
    marks = Marks.of(at, NIB, scale=[own(NIB[k % 40]) for k in range(64)], glyph=np.arange(64) % 40, angle=np.arange(64.0))
    ink = 1 - codes(sheet(marks, (6.0, 6.0)), **values) / 255
    island, n = ndimage.label(ink > 0.1)
    found = np.array(ndimage.center_of_mass(ink, island, np.arange(1, n + 1)))[:, ::-1] + 0.5
    far, which = cKDTree(found * 25.4 / values["dpi"]).query(sheet(marks).marks.xy)
    assert n == 64 and len(np.unique(which)) == 64
    assert far.max() < 0.01  # mm: a scan's ink and its outline have their centroids some micrometres apart


def shown(data: bytes, dpi: float) -> npt.NDArray[np.float64]:
    page = pypdfium2.PdfDocument(data)[0]
    return np.asarray(page.render(scale=dpi / 72, grayscale=True).to_pil()).astype(np.float64)


def test_a_pdf_has_outlines_and_on_demand_the_pixels_of_the_png() -> None:
    side = 120 * 25.4 / 600  # whole pixels, so that a renderer need not stretch the page
    bar = Layer(Ink(), Paths.of([[(0.5, 4.6), (4.5, 4.6), (4.5, 4.8), (0.5, 4.8)]]))
    drawing = Sheet((side, side), (*sheet(crowd()).layers, bar))
    grey, plain = formats.to_bytes(drawing, "pdf", grey_dots=True), formats.to_bytes(drawing, "pdf")
    dots = codes(sheet(crowd(), (side, side)))
    with pikepdf.open(io.BytesIO(grey)) as document:
        image = document.pages[0].Resources.XObject.Grey
        assert image.read_bytes() == dots.astype(np.uint8).tobytes() and (image.Width, image.Height) == dots.shape[::-1]
    page = shown(grey, 600)
    off = [np.abs(np.roll(page, shift, (0, 1)) - dots)[3:100, 3:-3].mean() for shift in ((0, 0), (2, 0), (-2, 0), (0, 2), (0, -2))]
    assert off[0] < 0.5 * min(off[1:])  # the renderer moves images by up to a pixel
    assert page[110, 60] == 0  # the bar stays over the image
    assert b"/Image" in grey and b"/Image" not in plain and b"/SMask" not in grey
    assert plain == formats.to_bytes(drawing, "pdf", grey_dots=False)


def test_a_pdf_of_grey_dots_lies_within_its_marks_and_bleed() -> None:
    drawing = sheet(crowd(), (12.0, 10.0))
    out = 600 * 0.5  # pixels: half an inch, about as wide as the slug
    page = shown(formats.to_bytes(drawing, "pdf", grey_dots=True, bleed=3.0, marks=True), 600)
    inner = codes(drawing)
    x, y = (round((have - want) / 2) for have, want in zip(page.shape[::-1], inner.shape[::-1], strict=True))
    best = min(np.abs(page[y + j :, x + i :][:200, :200] - inner[:200, :200]).mean() for i in (-1, 0, 1) for j in (-1, 0, 1))
    assert 0 < x < out and best < 3  # a pixel here is not one there


def test_grey_dots_in_a_pdf_suit_pdf_a_and_pdf_x() -> None:
    drawing = sheet(crowd())
    for standard in ({"pdfx": "x1a"}, {"pdfx": "x3"}, {"pdfx": "x4"}):
        assert b"/Image" in formats.to_bytes(drawing, "pdf", grey_dots=True, **standard)
    check_archived(formats.to_bytes(drawing, "pdf", grey_dots=True, pdfa=True))


def test_grey_dots_in_a_pdf_are_black_and_white_inks() -> None:
    sea = Layer(Ink("sea", (1, 0, 0, 0)), Paths.of([[(0, 0), (1, 0), (1, 1)]]))
    dots = sheet(crowd()).layers[0]
    with pytest.raises(ValueError, match=r"^grey-dots in a PDF are grey, .*; leave it out, or save a TIFF$"):
        formats.to_bytes(Sheet((5, 5), (sea, dots)), "pdf", grey_dots=True)
    assert formats.to_bytes(Sheet((5, 5), (dots, sea)), "pdf", grey_dots=True)  # above them any ink will do
    assert b"/Image" not in formats.to_bytes(Sheet((5, 5), (sea,)), "pdf", grey_dots=True)
    with pytest.raises(ValueError, match=r"^grey-dots make too many pixels of 600 dpi of this sheet; leave it out, or draw smaller$"):
        formats.to_bytes(Sheet((2000, 1500), (dots,)), "pdf", grey_dots=True)
