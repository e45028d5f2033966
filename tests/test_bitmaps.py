"""PNG and TIFF, read back by Pillow: pixels of a true size, each dark by as much of it as the drawing covers."""

from __future__ import annotations

import io
import struct
from pathlib import Path
from typing import Any

import memory
import numpy as np
import numpy.typing as npt
import pypdfium2
import pytest
from drawings import everything, marks
from PIL import Image
from rendering import run

from crowquill import formats, glyphs, measure
from crowquill.formats import _bitmap
from crowquill.formats.svg import _paint
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.sheet import Ink, Layer, Sheet
from crowquill.units import INCH

Codes = npt.NDArray[Any]
BOTH = pytest.mark.parametrize("format", ["png", "tiff"])
KINDS = pytest.mark.parametrize("bilevel", [False, True], ids=["grey", "bilevel"])
DISC = glyphs.load("disc").glyphs
MM = 254  # dpi at which a pixel is a tenth of a millimetre


def opened(drawing: Sheet, format: str, **values: Any) -> Image.Image:
    image = Image.open(io.BytesIO(formats.to_bytes(drawing, format, **values)))
    image.load()
    return image


def codes(drawing: Sheet, format: str = "png", **values: Any) -> Codes:
    return np.asarray(opened(drawing, format, **values)).astype(np.int64)


def tags(image: Image.Image) -> dict[int, Any]:
    found: Any = image
    return dict(found.tag_v2)


def box(x: float, y: float, width: float, height: float) -> Paths:
    """A rectangle in pixels of MM dpi."""
    corners = np.array([(x, y), (x + width, y), (x + width, y + height), (x, y + height)])
    return Paths.of([corners / 10])


def filled(size: tuple[float, float], *layers: tuple[Ink, Paths]) -> Sheet:
    return Sheet(size, tuple(Layer(ink, art) for ink, art in layers))


def dots(n: int = 600) -> Sheet:
    return Sheet((60, 50), (Layer(Ink(), marks(n, 30, 20)),))


@BOTH
@pytest.mark.parametrize("dpi", [20, 72, 254, 600, 609.6])
def test_a_page_has_the_nearest_whole_number_of_pixels_and_says_its_dpi(format: str, dpi: float) -> None:
    image = opened(Sheet((40, 13.3)), format, dpi=dpi)
    assert image.size == (round(40 / INCH * dpi), round(13.3 / INCH * dpi))
    # a PNG counts pixels to the metre, in whole numbers; a TIFF to the inch, as they are
    assert image.info["dpi"] == pytest.approx((dpi, dpi), abs=INCH / 1000 / 2 + 1e-9 if format == "png" else 1e-9)
    assert image.mode == "L" and np.asarray(image).min() == 255


@BOTH
@KINDS
def test_a_sheet_smaller_than_a_pixel_is_one_pixel(format: str, bilevel: bool) -> None:
    assert opened(filled((0.01, 0.02), (Ink(), box(0, 0, 9, 9))), format, dpi=20, bilevel=bilevel).size == (1, 1)
    assert opened(Sheet((0.01, 90)), format, dpi=20, bilevel=bilevel).size == (1, 71)


def test_a_pixel_is_never_stretched() -> None:
    drawing = filled((5.04, 5.04), (Ink(), box(20, 30, 1, 1)))  # half a pixel is left of the paper: it is cut off
    found = codes(drawing, dpi=MM)
    assert found.shape == (50, 50)
    assert np.argwhere(found < 255).tolist() == [[30, 20]] and found[30, 20] == 0


@BOTH
def test_half_of_a_pixel_of_black_is_code_128_and_a_quarter_191(format: str) -> None:
    drawing = filled((0.5, 0.1), (Ink(), box(1, 0, 1.5, 1)), (Ink(), box(4, 0, 0.25, 1)))
    assert codes(drawing, format, dpi=MM).tolist() == [[255, 0, 128, 255, 191]]


def test_layers_are_painted_from_the_bottom_up_each_over_its_share() -> None:
    black, grey, paper = Ink(), Ink("grey", (0, 0, 0, 0.4)), Ink("paper", (0, 0, 0, 0))
    drawing = filled((0.5, 0.1), (black, box(0, 0, 3, 1)), (grey, box(1, 0, 3, 1)), (paper, box(2, 0, 0.5, 1)))
    # black; grey over black; half paper over that; grey; paper
    assert codes(drawing, dpi=MM).tolist() == [[0, 153, 204, 153, 255]]
    assert codes(filled((0.1, 0.1), (black, box(0, 0, 0.5, 1)), (black, box(0, 0, 0.5, 1))), dpi=MM).tolist() == [[64]]


@BOTH
def test_colours_are_those_of_the_svg(format: str) -> None:
    inks = [Ink("a", (0.7, 0.2, 0, 0.05)), Ink("b", (0, 1, 1, 0)), Ink("c", (0, 0, 0, 0.7)), Ink("d", (0.3, 0.3, 0.3, 0))]
    drawing = filled((0.5, 0.1), *((ink, box(k, 0, 1, 1)) for k, ink in enumerate(inks)))
    image = opened(drawing, format, dpi=MM)
    assert image.mode == "RGB"
    found = ["#" + "".join(f"{code:02x}" for code in pixel) for pixel in np.asarray(image)[0].tolist()]
    assert found == [*(_paint(ink)["fill"] for ink in inks), "#ffffff"]


def test_a_sheet_is_grey_unless_ink_in_use_has_colour() -> None:
    red, nothing = Ink("red", (0, 1, 1, 0)), Paths.of([])
    assert opened(filled((1, 1), (Ink(), box(0, 0, 1, 1)), (red, nothing)), "png", dpi=MM).mode == "L"
    assert opened(filled((1, 1), (red, box(0, 0, 1, 1))), "png", dpi=MM).mode == "RGB"


@KINDS
@pytest.mark.parametrize("sheet_of", [dots, everything], ids=["dots", "everything"])
def test_png_and_tiff_show_the_same_pixels(sheet_of: Any, bilevel: bool) -> None:
    drawing = sheet_of()
    if bilevel:
        drawing = Sheet(drawing.size, tuple(layer for layer in drawing.layers if layer.ink.cmyk == (0, 0, 0, 1)))
    png, tiff = (opened(drawing, format, dpi=200, bilevel=bilevel) for format in ("png", "tiff"))
    assert png.mode == tiff.mode
    assert np.array_equal(np.asarray(png), np.asarray(tiff)) and np.asarray(png).min() == 0


@BOTH
def test_black_and_white_is_black_where_more_than_half_is_covered(format: str) -> None:
    drawing = filled(
        (0.5, 0.1), (Ink(), box(0, 0, 0.49, 1)), (Ink(), box(1, 0, 0.5, 1)), (Ink(), box(2, 0, 0.51, 1)), (Ink(), box(3, 0, 1, 1))
    )
    image = opened(drawing, format, dpi=MM, bilevel=True)
    assert image.mode == "1"
    assert np.asarray(image).tolist() == [[True, True, False, False, True]]


@pytest.mark.parametrize("dpi", [100, 600, 601])  # rows that fill their last byte, and rows that do not
def test_black_and_white_is_the_grey_picture_cut_at_its_middle(dpi: float) -> None:
    grey, bits = codes(dots(), dpi=dpi), codes(dots(), dpi=dpi, bilevel=True)
    assert np.array_equal(bits == 0, grey < 128) and (bits == 0).any()


@BOTH
def test_black_and_white_refuses_inks_that_are_not_black(format: str) -> None:
    for cmyk in ((0, 0, 0, 0.5), (1, 0, 0, 0), (1, 1, 1, 1)):
        with pytest.raises(ValueError, match=r"^bilevel has black alone, and ink 'wash' is cmyk .*; leave bilevel off, or draw in black$"):
            formats.to_bytes(filled((1, 1), (Ink("wash", cmyk), box(0, 0, 1, 1))), format, bilevel=True)
    assert codes(filled((1, 1), (Ink("wash", (0, 0, 0, 0.5)), Paths.of([]))), format, bilevel=True).min() == 1


def test_tiffs_for_press_are_group_4_with_white_as_least_and_one_page() -> None:
    image = opened(dots(), "tiff", dpi=1200, bilevel=True)
    found = tags(image)
    assert [found[tag] for tag in (259, 262, 258, 277, 296, 282, 283)] == [4, 0, (1,), 1, 2, 1200, 1200]
    assert getattr(image, "n_frames") == 1  # noqa: B009
    grey = tags(opened(dots(), "tiff", dpi=300))
    assert [grey[tag] for tag in (259, 262, 258, 317)] == [8, 1, (8,), 2]
    colour = tags(opened(everything(), "tiff", dpi=50))
    assert [colour[tag] for tag in (259, 262, 258, 277)] == [8, 2, (8, 8, 8), 3]


@BOTH
@KINDS
def test_files_say_nothing_of_time_place_or_program(format: str, bilevel: bool) -> None:
    data = formats.to_bytes(dots(), format, dpi=100, bilevel=bilevel)
    if format == "tiff":
        allowed = {256, 257, 258, 259, 262, 273, 277, 278, 279, 282, 283, 284, 293, 296, 317}
        assert set(tags(Image.open(io.BytesIO(data)))) <= allowed
        return
    kinds, at = [], 8
    while at < len(data):
        kinds.append(data[at + 4 : at + 8])
        at += 12 + struct.unpack(">I", data[at : at + 4])[0]
    assert sorted(set(kinds)) == [b"IDAT", b"IEND", b"IHDR", b"pHYs"]


@BOTH
@KINDS
def test_bands_do_not_show(format: str, bilevel: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = codes(dots(), format, dpi=200, bilevel=bilevel)
    for pixels in (1, 5000):  # a row at a time, and ten rows, the last band shorter
        monkeypatch.setattr(_bitmap, "PIXELS", pixels)
        assert np.array_equal(codes(dots(), format, dpi=200, bilevel=bilevel), whole)


@BOTH
def test_more_pixels_than_can_be_written_are_refused_in_a_line(format: str) -> None:
    for size, values, remedy in (
        ((210, 297), {"dpi": 4800}, "; use a lower dpi"), ((210, 297), {"dpi": 4800, "bilevel": True}, "; use a lower dpi"),
        ((210, 297), {"dpi": 2400}, "; use a lower dpi, or bilevel"), ((1e12, 1e12), {}, "; use a lower dpi"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=rf"^dpi .* makes \d+ x \d+ pixels of this sheet, over the limit of \d+ million{remedy}$"):
            formats.to_bytes(Sheet(size), format, **values)
    for dpi in (19, 4801, float("nan"), "600"):
        with pytest.raises(ValueError, match=r"^dpi is .*; it takes a number from 20 to 4800"):
            formats.to_bytes(dots(), format, dpi=dpi)


def test_art_over_the_edge_of_the_paper_is_cut_off() -> None:
    corner = Marks.of([(0, 0), (2, 1)], DISC, scale=1.0)
    found = 1 - codes(Sheet((2, 1), (Layer(Ink(), corner),)), dpi=1016) / 255
    assert found.mean() * 2 == pytest.approx(2 / 4, rel=2e-3)
    assert found[0, 0] == found[-1, -1] == 1 and found[0, -1] == found[-1, 0] == 0


@pytest.mark.parametrize(("bilevel", "within"), [(False, 2e-4), (True, 2e-3)])
def test_the_picture_has_the_ink_of_the_drawing(bilevel: bool, within: float) -> None:
    drawing = Sheet((210, 297), (Layer(Ink(), marks(20_000)),))
    black = 1 - codes(drawing, dpi=600, bilevel=bilevel) / (1 if bilevel else 255)
    width, height = (side * INCH / 600 for side in black.shape[::-1])  # what the pixels are of the page, to half a pixel
    assert black.mean() * width * height / (210 * 297) == pytest.approx(measure.ink(drawing.marks) / (210 * 297), abs=within)


def test_the_check_of_ink_notices_a_tenth_more_dots() -> None:
    assert measure.ink(marks(22_000)) / (210 * 297) - measure.ink(marks(20_000)) / (210 * 297) > 2e-3


def test_renderers_of_the_pdf_agree() -> None:
    line = Layer(Ink(pen=0.5), Paths.of([[(2, 2), (90, 8)]], closed=False))
    drawing = Sheet((101.6, 50.8), (Layer(Ink(), marks(3000, 70, 20)), line))
    mine, pdf = 1 - codes(drawing, dpi=300) / 255, formats.to_bytes(drawing, "pdf")
    with pypdfium2.PdfDocument(pdf) as document:
        pdfium = [np.asarray(document[0].render(scale=dpi / 72, grayscale=True).to_pil()) for dpi in (300, 1200)]
    drawn = run("pdftoppm", ["-r", "1200", "-gray", "-singlefile", "-png", "in.pdf", "out"], {"in.pdf": pdf}, "out.png")
    poppler = np.asarray(Image.open(io.BytesIO(drawn)).convert("L"))
    assert (1 - pdfium[0] / 255).mean() == pytest.approx(mine.mean(), rel=0.02)
    # they lighten borders, Poppler by a gamma of 1.5: less when four pixels across are averaged to one, but it is still seen
    for finer, mean, most in ((pdfium[1], 0.01, 0.06), (poppler, 0.02, 0.15)):
        other = 1 - finer.reshape(600, 4, 1200, 4).mean(axis=(1, 3)) / 255
        assert other.mean() == pytest.approx(mine.mean(), rel=mean)
        np.testing.assert_allclose(mine, other, atol=most)


@pytest.mark.parametrize("n", [20_000, pytest.param(300_000, marks=pytest.mark.soak)])
def test_a_page_for_press_stays_under_a_gigabyte(n: int) -> None:
    code = """
import sys
from drawings import marks
from crowquill import formats
from crowquill.sheet import Ink, Layer, Sheet
formats.to_bytes(Sheet((210, 297), (Layer(Ink(), marks(int(sys.argv[1]))),)), "tiff", dpi=1200, bilevel=True)
"""
    assert memory.taken(code, str(n))[1] < 1_000_000


def test_tif_is_a_name_of_tiff(tmp_path: Path) -> None:
    formats.save(dots(), tmp_path / "a.tif", tmp_path / "b.tiff", tmp_path / "c.png", dpi=100, bilevel=True)
    assert (
        (tmp_path / "a.tif").read_bytes() == (tmp_path / "b.tiff").read_bytes() == formats.to_bytes(dots(), "tiff", dpi=100, bilevel=True)
    )
