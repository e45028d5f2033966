"""What a layer may hold beside marks and paths: bitmaps, spot inks, and rings with colours of their own."""

from __future__ import annotations

import io

import numpy as np
import pytest
import resvg_py
from PIL import Image

from crowquill import Sheet, load, to_bytes
from crowquill.finishing import Finish
from crowquill.paths import Paths
from crowquill.plotting import plotted
from crowquill.seen import of_sheet
from crowquill.sheet import Bitmap, Ink, Layer, in_process, on_screen, outlined


@pytest.mark.parametrize("name", ["a/b", "Schönblau", "", "Black", "all", "x" * 64, "tab\t"])
def test_a_spot_ink_has_a_name_that_every_press_takes(name):
    with pytest.raises(ValueError, match="spot ink"):
        Ink(name, (0, 0.5, 1, 0), spot=True)
    assert Ink("PANTONE 124 C", (0, 0.3, 0.9, 0), spot=True).spot


def test_a_bitmap_gives_back_its_pixels_and_its_size():
    black = np.random.default_rng(1).random((5, 13)) < 0.5
    bitmap = Bitmap.of(black, 254, (1, 2))
    assert (bitmap.rows(0, 5) == black).all()
    assert (bitmap.rows(2, 4) == black[2:4]).all()
    assert len(bitmap) == black.sum()
    assert np.allclose(bitmap.size, (1.3, 0.5), atol=1e-12)  # mm: pixels of 0.1
    assert bitmap.moved((1, 1)).corner.tolist() == [2, 3]


def test_a_bitmap_with_ink_beside_its_pixels_is_refused():
    with pytest.raises(ValueError, match="beyond its width"):
        Bitmap(np.full((1, 1), 255, np.uint8), 5, 300, np.zeros(2))
    with pytest.raises(ValueError, match="no size"):
        Bitmap(np.zeros((1, 1), np.uint8), 5, 0, np.zeros(2))
    with pytest.raises(ValueError, match="rows by columns"):
        Bitmap.of(np.zeros((0, 4), bool), 300)


def test_pixels_have_no_outlines():
    with pytest.raises(ValueError, match="no outlines"):
        outlined(Bitmap.of([[True]], 300))


def test_every_colour_of_a_screen_comes_back_from_its_inks():
    rgb = np.random.default_rng(3).integers(0, 256, (2000, 3))
    rgb[:3] = [(0, 0, 0), (255, 255, 255), (77, 77, 77)]
    cmyk = in_process(rgb)
    assert (on_screen(np.round(cmyk, 4)) == rgb).all()  # four decimals are what a layer keeps
    assert cmyk[:3].tolist() == [[0, 0, 0, 1], [0, 0, 0, 0], [0, 0, 0, 1 - 77 / 255]]  # greys are black alone


@pytest.mark.parametrize(
    ("art", "pen", "fill", "said"),
    [
        (Paths.of([[(0, 0), (1, 0), (0, 1)]]), None, [[0, 0, 0, 2]], "0 to 1"),
        (Paths.of([[(0, 0), (1, 0), (0, 1)]]), None, [[0, 0, 0]], "fill has shape"),
        (Paths.of([[(0, 0), (1, 0), (0, 1)]]), 0.3, [[0, 0, 0, 1]], "fill colours closed paths"),
        (Paths.of([[(0, 0), (1, 0), (0, 1)]], closed=False), None, [[0, 0, 0, 1]], "fill colours closed paths"),
    ],
)
def test_a_fill_that_fits_no_ring_is_refused(art: Paths, pen: float | None, fill: list[list[float]], said: str):
    with pytest.raises(ValueError, match=said):
        Layer(Ink(pen=pen), art, fill=np.array(fill))


def test_colours_of_rings_are_drawn_and_come_back():
    rings = Paths.of([[(k, 0), (k + 1, 0), (k + 1, 1), (k, 1)] for k in range(4)])
    rgb = [(200, 10, 30), (200, 10, 30), (0, 0, 0), (7, 200, 255)]
    sheet = Sheet((4, 1), (Layer(Ink("stone"), rings, fill=in_process(rgb)),))
    data = to_bytes(sheet, "svg")
    assert data.count(b"<path") == 3  # neighbours of one colour are one element
    image = np.asarray(Image.open(io.BytesIO(bytes(resvg_py.svg_to_bytes(svg_string=data.decode(), dpi=254)))).convert("RGB"))
    assert (image[5, 5::10] == rgb).all()
    back = load(io.BytesIO(data))
    assert np.array_equal(back.layers[0].fill, sheet.layers[0].fill)
    assert to_bytes(back, "svg") == data


def test_colours_of_rings_are_painted_in_bitmaps():
    square = [(0.1, 0.1), (0.9, 0.1), (0.9, 0.9), (0.1, 0.9)]
    rings = Paths.of([[(x + k, y + 0.5) for x, y in square] for k in range(4)] + [[(-1, 2.4), (9, 2.4), (9, 9), (-1, 9)]])
    rgb = [(200, 10, 30), (90, 10, 30), (0, 0, 0), (7, 200, 255), (0, 0, 255)]
    sheet = Sheet((4, 3), (Layer(Ink("stone"), rings, fill=in_process(rgb)),))
    image = np.asarray(Image.open(io.BytesIO(to_bytes(sheet, "png", dpi=254))).convert("RGB"))
    assert (image[10, 5::10] == rgb[:4]).all()
    assert (image[26:] == rgb[4]).all()  # what hangs over the page is cut
    assert (image[10, 0::10] == 255).all()
    greys = Sheet((4, 3), (Layer(Ink("stone"), rings, fill=in_process([(77, 77, 77)] * 5)),))
    assert Image.open(io.BytesIO(to_bytes(greys, "png", dpi=254))).mode == "L"
    with pytest.raises(ValueError, match="bilevel has black alone"):
        to_bytes(sheet, "png", bilevel=True)


def test_colours_of_rings_are_seen_as_dark_as_they_are():
    rings = Paths.of([[(k, 0), (k + 1, 0), (k + 1, 1), (k, 1)] for k in range(3)])
    sheet = Sheet((3, 1), (Layer(Ink("stone"), rings, fill=in_process([(0, 0, 0), (255, 255, 255), (255, 0, 0)])),))
    dark, _ = of_sheet(sheet).coverage(1.0)
    assert np.allclose(dark, [[1, 0, 2 / 3]], atol=1 / 128)  # steps of a 64th


def test_an_ink_and_a_pen_that_change_no_colour_of_rings_say_so():
    rings = Paths.of([[(k, 0), (k + 1, 0), (k + 1, 1), (k, 1)] for k in range(2)])
    plain = Sheet((2, 1), (Layer(Ink(), rings),))
    stones = Sheet((2, 1), (Layer(Ink(), rings, fill=in_process([(200, 10, 30), (0, 0, 255)])),))
    cyan = Finish(ink=Ink("cyan", (1.0, 0.0, 0.0, 0.0)))
    assert "ink cyan is not used: the drawing has inks of its own" in cyan.drawn(stones).report["warnings"]
    assert not cyan.drawn(plain).report.get("warnings")
    said = "areas with colours of their own are drawn in one ink"
    assert said in plotted(stones, nib=0.1).report["warnings"]
    assert said not in plotted(plain, nib=0.1).report["warnings"]
