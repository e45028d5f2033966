"""Bitmaps on a sheet: their own pixels in PNG and TIFF, an image at its true size in SVG, exact shares anywhere else."""

from __future__ import annotations

import base64
import io
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import resvg_py
from PIL import Image

from crowquill import formats, load, plotting, raster, seen
from crowquill.formats import _bitmap
from crowquill.paths import Paths
from crowquill.sheet import Bitmap, Ink, Layer, Sheet

MM = 254.0  # dpi at which a pixel is a tenth of a millimetre
NOISE = np.random.default_rng(3).random((61, 83)) < 0.4
BOTH = pytest.mark.parametrize("format", ["png", "tiff"])


def sheet(black: npt.ArrayLike = NOISE, dpi: float = MM, corner: tuple[float, float] = (2.0, 3.0), **ink: Any) -> Sheet:
    return Sheet((12, 10), (Layer(Ink(**ink), Bitmap.of(black, dpi, corner)),))


def opened(drawing: Sheet, format: str, **values: Any) -> Image.Image:
    image = Image.open(io.BytesIO(formats.to_bytes(drawing, format, **values)))
    image.load()
    return image


def inked(image: Image.Image) -> npt.NDArray[np.float64]:
    return np.asarray(1 - np.asarray(image.convert("L")) / 255)


def on_page(shape: tuple[int, int], top: int, left: int, black: npt.NDArray[np.bool_] = NOISE) -> npt.NDArray[np.bool_]:
    page = np.zeros(shape, bool)
    page[top : top + len(black), left : left + black.shape[1]] = black
    return page


@BOTH
@pytest.mark.parametrize("values", [{}, {"dpi": MM}, {"bilevel": True}], ids=["left out", "its own", "bilevel"])
def test_pixels_are_copied_where_the_page_has_the_same(format: str, values: dict[str, Any]) -> None:
    image = opened(sheet(), format, **values)
    assert image.mode == "1" and image.size == (120, 100)
    assert image.info["dpi"] == pytest.approx((MM, MM), abs=0.013)  # a PNG has whole pixels to the metre
    assert (~np.asarray(image) == on_page((100, 120), 30, 20)).all()


@BOTH
@pytest.mark.parametrize(
    ("corner", "at"), [((2.04, 3.049), (30, 20)), ((1.96, 2.951), (30, 20)), ((2.051, 3.06), (31, 21)), ((-0.96, 0), (0, -10))]
)
def test_a_bitmap_between_pixels_moves_to_the_nearest(format: str, corner: tuple[float, float], at: tuple[int, int]) -> None:
    top, left = at
    wanted = on_page((100, 120), top, max(0, left), NOISE[:, max(0, -left) :])
    assert (~np.asarray(opened(sheet(corner=corner), format)) == wanted).all()


@BOTH
@pytest.mark.parametrize("dpi", [20, 100, 381, 600])
def test_on_other_pixels_each_has_its_exact_share(format: str, dpi: float) -> None:
    image = opened(sheet(corner=(2.033, 3.017)), format, dpi=dpi)
    assert image.mode == "L"
    cover = raster.covered(sheet(corner=(2.033, 3.017)).layers[0].art, inked(image).shape, pixel=(25.4 / dpi, 25.4 / dpi))
    assert np.abs(inked(image) - cover).max() <= 0.5 / 255 + 1e-9
    assert cover.sum() * (25.4 / dpi) ** 2 == pytest.approx(NOISE.sum() * 0.01, rel=1e-12)


def test_exact_shares_are_those_of_the_pixels_drawn_as_squares() -> None:
    art = Bitmap.of(NOISE, MM, (0.77, 0.31))
    row, column = np.nonzero(NOISE)
    x, y = column / 10 + 0.77, row / 10 + 0.31
    squares = Paths.of(np.stack([np.stack(p, axis=1) for p in ((x, y), (x + 0.1, y), (x + 0.1, y + 0.1), (x, y + 0.1))], axis=1))
    for pixel in ((0.25, 0.25), (0.3, 0.7)):
        mine = raster.covered(art, (30, 40), pixel=pixel)
        # level borders of squares err by a 32nd of a pixel, divided by the lines of a pixel
        assert mine == pytest.approx(raster.covered(squares, (30, 40), pixel=pixel, lines=200), abs=0.01)


@BOTH
def test_a_page_with_more_than_a_bitmap_is_grey_and_keeps_its_pixels(format: str) -> None:
    box = Paths.of([[(0, 0), (1.05, 0), (1.05, 1), (0, 1)]])
    both = Sheet((12, 10), (*sheet().layers, Layer(Ink(), box)))
    image = opened(both, format)
    assert image.mode == "L" and image.size == (120, 100)
    assert (inked(image)[30:91, 20:103] == NOISE).all() and inked(image)[5, 10] == pytest.approx(0.5, abs=0.01)
    assert opened(both, format, bilevel=True).mode == "1"


@BOTH
def test_ink_of_a_colour_is_drawn_in_it(format: str) -> None:
    image = np.asarray(opened(sheet(name="sea", cmyk=(1, 0.5, 0, 0)), format))
    assert image.shape == (100, 120, 3)
    assert (image[30:91, 20:103][NOISE] == (0, 128, 255)).all() and (image[30:91, 20:103][~NOISE] == 255).all()


@BOTH
def test_a_white_bitmap_is_white_bits(format: str) -> None:
    image = opened(sheet(np.zeros((4, 5), bool)), format)
    assert image.mode == "1" and np.asarray(image).all() and image.size == (120, 100)


@BOTH
def test_of_two_bitmaps_the_finer_gives_the_dpi(format: str) -> None:
    two = Sheet((12, 10), (*sheet().layers, Layer(Ink(), Bitmap.of(NOISE, 2 * MM, (6, 6)))))
    assert opened(two, format).size == (240, 200)


@BOTH
def test_bits_that_would_lose_the_tone_are_refused(format: str) -> None:
    with pytest.raises(ValueError, match=r"^dpi 300 has less than two pixels to one of a bitmap of 254 dpi; use that, or leave "):
        formats.to_bytes(sheet(), format, dpi=300, bilevel=True)
    assert opened(sheet(), format, dpi=508, bilevel=True).mode == "1"


@BOTH
def test_bands_do_not_show(format: str, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = [np.asarray(opened(sheet(), format, **values)) for values in ({}, {"dpi": 100})]
    monkeypatch.setattr(_bitmap, "PIXELS", 500)
    monkeypatch.setattr("crowquill.raster.pixels.HELD", 200)
    for kept, values in zip(whole, ({}, {"dpi": 100}), strict=True):
        assert (np.asarray(opened(sheet(), format, **values)) == kept).all()


def test_an_svg_shows_it_at_its_true_size() -> None:
    data = formats.to_bytes(sheet(), "svg")
    shown = resvg_py.svg_to_bytes(svg_string=data.decode(), dpi=MM * 3, background="#ffffff")
    ink = inked(Image.open(io.BytesIO(bytes(shown))))
    wanted = np.kron(on_page((100, 120), 30, 20), np.ones((3, 3)))
    assert ink.shape == wanted.shape
    assert (ink[1::3, 1::3] == wanted[1::3, 1::3]).all()  # the middles of pixels
    assert ink.mean() == pytest.approx(wanted.mean(), abs=0.002)  # borders are the renderer's


def test_an_svg_gives_back_the_bitmap_and_the_same_bytes() -> None:
    drawing = sheet(name="sea", cmyk=(1, 0.5, 0, 0))
    data = formats.to_bytes(drawing, "svg")
    again = load(io.BytesIO(data))
    art = again.layers[0].art
    assert isinstance(art, Bitmap) and (art.rows(0, 61) == NOISE).all()
    assert (art.dpi, art.corner.tolist(), again.layers[0].ink) == (MM, [2.0, 3.0], drawing.layers[0].ink)
    assert formats.to_bytes(again, "svg") == data


def test_an_svg_whose_image_was_changed_says_that_it_is_left_out() -> None:
    data = formats.to_bytes(sheet(), "svg").decode()
    at = data.index("base64,") + 400
    other = data[:at] + ("A" if data[at] != "A" else "B") + data[at + 1 :]
    again = load(io.BytesIO(other.encode()))
    assert not again.layers and "bitmaps in it are left out" in again.report["warnings"][0]


def test_the_image_of_an_svg_is_one_colour_and_nothing() -> None:
    data = formats.to_bytes(sheet(name="sea", cmyk=(1, 0.5, 0, 0)), "svg").decode()
    png = base64.b64decode(data.split("base64,")[1].split('"')[0])
    image = np.asarray(Image.open(io.BytesIO(png)).convert("RGBA"))
    assert ((image[..., 3] == 255) == NOISE).all() and (image[NOISE] == (0, 128, 255, 255)).all()


def test_a_bitmap_is_seen_as_its_pixels_that_hang_together() -> None:
    black = np.zeros((20, 30), bool)
    black[2:4, 3:6] = black[4, 6] = black[10, 20] = True
    found = seen.of_sheet(sheet(black))
    assert sorted(found.areas.tolist()) == pytest.approx([0.01, 0.07])
    assert found.sites[found.areas.argmin()] == pytest.approx([2 + 2.05, 3 + 1.05])
    cover, pixel = found.coverage(0.5, (2.0, 3.0, 3.0, 2.0))
    assert cover.sum() * pixel[0] * pixel[1] == pytest.approx(black.sum() * 0.01, rel=1e-12)
    assert len(seen.of_sheet(sheet(np.zeros((4, 5), bool))).sites) == 0


def test_a_plotter_has_no_pixels() -> None:
    with pytest.raises(ValueError, match="pixels of a device have no outlines; draw them as polygons or as dots"):
        plotting.plotted(sheet())
