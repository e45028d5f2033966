"""Sheets as pixels of a true size, rows from the top: what every bitmap format shares."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.kernel import compiled, shared_out
from crowquill.paths import Array
from crowquill.raster import PIXELS, Raster
from crowquill.sheet import Sheet
from crowquill.units import INCH

Bytes = npt.NDArray[np.uint8]
DPI = "pixels to the inch"
BILEVEL = "black and white alone: black where ink covers over half of a pixel"
KEYWORD, DESCRIPTION = "crowquill", 270  # where the recipe is kept: a text of PNG, a field of TIFF
MOST_BITS = 2_000_000_000  # pixels of black and white: A4 at 4500 dpi
MOST = 500_000_000  # pixels of grey or colour: A4 at 2200 dpi


@dataclass(frozen=True)
class Page:
    """Pixels of a page: how many across and down, to the inch, and channels: 0 is bits, 1 grey, 3 red, green and blue."""

    width: int
    height: int
    dpi: float
    channels: int

    @property
    def rows(self) -> int:
        """Rows to a band, the last may have fewer."""
        return max(1, PIXELS // self.width)


def page(sheet: Sheet, dpi: float, bilevel: bool) -> Page:
    """The page that a sheet takes: whole pixels each way, the nearest number, one at the least.

    Grey where every ink in use is a share of black. Raises ValueError for too many pixels, and for bits of
    an ink that is not black: shares of ink are not screened here. White ink is paper.
    """
    width, height = pixels(sheet.size, dpi, bilevel)
    inks = [layer.ink for layer in sheet.layers if len(layer.art)]
    for ink in inks:
        if bilevel and ink.cmyk not in ((0, 0, 0, 1), (0, 0, 0, 0)):
            raise ValueError(f"bilevel has black alone, and ink {ink.name!r} is cmyk {ink.cmyk}; leave bilevel off, or draw in black")
    grey = all(ink.cmyk[:3] == (0, 0, 0) for ink in inks)
    return Page(width, height, dpi, 0 if bilevel else 1 if grey else 3)


def pixels(size: tuple[float, float], dpi: float, bilevel: bool) -> tuple[int, int]:
    """How many pixels a sheet of this size in mm has across and down. Raises ValueError for too many."""
    width, height = (max(1, round(side / INCH * dpi)) for side in size)
    most = MOST_BITS if bilevel else MOST
    if width * height > most:
        wish = "use a lower dpi" if bilevel or width * height > MOST_BITS else "use a lower dpi, or bilevel"
        raise ValueError(
            f"dpi {dpi:g} makes {width} x {height} pixels of this sheet, over the limit of {most // 1_000_000} million; {wish}"
        )
    return width, height


def foresee(size: tuple[float, float], _marks: int, *, dpi: float, bilevel: bool) -> None:
    """Raises ValueError for more pixels than a bitmap takes."""
    pixels(size, dpi, bilevel)


def said(sheet: Sheet) -> bytes:
    """The sheet's recipe as text for a bitmap's own notes, in ASCII; nothing where there is none."""
    return json.dumps(dict(sheet.recipe), sort_keys=True).encode("ascii") if sheet.recipe else b""


def recipe(data: bytes, name: str) -> tuple[dict[str, Any], dict[str, bytes]]:
    """What made the drawing in a PNG or TIFF of ours; no files are kept in it."""
    from PIL import Image

    try:
        with Image.open(io.BytesIO(data), formats=("PNG", "TIFF")) as image:
            notes: Any = image.info if image.format == "PNG" else getattr(image, "tag_v2", {})
            found = json.loads(str(notes.get(KEYWORD if image.format == "PNG" else DESCRIPTION, "{}")))
    except (OSError, SyntaxError, ValueError, RecursionError) as error:
        raise ValueError(f"{name}: no recipe can be read from it ({' '.join(str(error).split())[:80]}); give the file as drawn") from None
    if not isinstance(found, dict) or not found:
        raise ValueError(f"{name}: keeps no recipe of crowquill; give a picture that it drew")
    return found, {}


def bands(sheet: Sheet, page: Page) -> Iterator[Bytes]:
    """The page's rows from the top, some at a time: codes of 0 to 255 (rows, width * channels), or eight bits to a byte, 1 black.

    Layers are painted from the bottom up, each over its share of the pixel: device codes, not light, so that half a
    pixel of black is 128. The corner of the page is the corner of a pixel, and pixels are INCH / dpi mm, never stretched.
    """
    side, layers = INCH / page.dpi, [layer for layer in sheet.layers if len(layer.art)]
    arts = [(Raster.of(layer.art, pixel=(side, side), width=page.width, pen=layer.ink.pen), layer.ink.rgb) for layer in layers]
    channels = max(1, page.channels)
    for top in range(0, page.height, page.rows):
        bottom = min(page.height, top + page.rows)
        value = np.full((bottom - top, page.width, channels), 255.0)
        for raster, codes in arts:
            if raster.touches(top, bottom):
                _paint(value, raster.rows(top, bottom), np.array(codes[:channels], np.float64))
        if page.channels:
            yield np.floor(value + 0.5).astype(np.uint8).reshape(bottom - top, -1)
        else:
            yield np.packbits(value[..., 0] < 127.5, axis=1)


def _paint(value: Array, cover: Array, codes: Array) -> None:
    """Paints codes (channels,) over values (h, w, channels) where they cover."""
    shared_out(lambda lo, hi: _over(value[lo:hi], cover[lo:hi], codes), len(value), 8)


@compiled
def _over(value: Array, cover: Array, codes: Array) -> None:
    for row in range(value.shape[0]):
        for column in range(value.shape[1]):
            share = cover[row, column]
            if share > 0:
                for channel in range(value.shape[2]):
                    value[row, column, channel] = value[row, column, channel] * (1 - share) + codes[channel] * share
