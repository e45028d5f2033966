"""Sheets as pixels of a true size, rows from the top: what every bitmap format shares."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.greydots import RIM, Greys, scanned
from crowquill.kernel import compiled, shared_out
from crowquill.marks import Marks
from crowquill.paths import Array
from crowquill.raster import PIXELS, Raster, ready
from crowquill.raster.pixels import Pixels
from crowquill.sheet import Bitmap, Layer, Sheet, on_screen, outlined
from crowquill.units import INCH

Bytes = npt.NDArray[np.uint8]
DPI = "pixels to the inch (600, or those of a bitmap drawn)"
USUAL = 600.0  # dpi
BILEVEL = "black and white alone: black where ink covers over half of a pixel"
GREY_DOTS = "dots that have scans as grey pixels of these, not outlines (yes for PNG and TIFF; no for PDF, of 600 dpi)"
BLACK_FROM = "in black and white, how much light grey dots take where they are black; 0.216 is the published level"
KEYWORD, DESCRIPTION = "crowquill", 270  # where the recipe is kept: a text of PNG, a field of TIFF
MOST_BITS = 2_000_000_000  # pixels of black and white: A4 at 4500 dpi
MOST = 500_000_000  # pixels of grey or colour: A4 at 2200 dpi


@dataclass(frozen=True)
class Page:
    """Pixels of a page: how many across and down, to the inch, and channels: 0 is bits, 1 grey, 3 red, green and blue.

    grey_dots   dots that have scans are drawn as these
    black_from  what such a dot takes of the light where bits of it are black
    """

    width: int
    height: int
    dpi: float
    channels: int
    grey_dots: bool = True
    black_from: float = RIM

    @property
    def rows(self) -> int:
        """Rows to a band, the last may have fewer."""
        return max(1, PIXELS // self.width)


def page(sheet: Sheet, dpi: float | None, bilevel: bool) -> Page:
    """The page that a sheet takes: whole pixels each way, the nearest number, one at the least.

    A dpi of None is that of the sheet's finest bitmap, or else the USUAL one. Grey where every ink in use is a share of
    black, bits also where all that is drawn are black bitmaps of this very dpi. Raises ValueError for too many pixels, for
    bits of an ink that is not black: shares of ink are not screened here, and for bits that are neither as large as a
    bitmap's own nor half as large, which would lose its tone. White ink is paper.
    """
    used = [layer for layer in sheet.layers if len(layer.art) or isinstance(layer.art, Bitmap)]
    maps = [layer.art.dpi for layer in used if isinstance(layer.art, Bitmap)]
    dpi = finest(sheet) if dpi is None else dpi
    inks = [(layer.ink.name, np.array([layer.ink.cmyk]) if layer.fill is None else layer.fill) for layer in used]
    if maps == [dpi] * len(used) and all((shares == (0, 0, 0, 1)).all() for _, shares in inks):
        bilevel = bilevel or bool(used)
    width, height = pixels(sheet.size, dpi, bilevel)
    for name, shares in inks:
        other = shares[(shares[:, :3] != 0).any(axis=1) | ((shares[:, 3] != 0) & (shares[:, 3] != 1))]
        if bilevel and len(other):
            cmyk = tuple(other[0].tolist())
            raise ValueError(f"bilevel has black alone, and ink {name!r} is cmyk {cmyk}; leave bilevel off, or draw in black")
    for own in maps:
        if bilevel and dpi != own and dpi < 2 * own:
            raise ValueError(f"dpi {dpi:g} has less than two pixels to one of a bitmap of {own:g} dpi; use that, or leave bilevel off")
    grey = all((shares[:, :3] == 0).all() for _, shares in inks)
    return Page(width, height, dpi, 0 if bilevel else 1 if grey else 3)


def finest(sheet: Sheet) -> float:
    """The dpi of a sheet's finest bitmap, or else the usual one."""
    return max((layer.art.dpi for layer in sheet.layers if isinstance(layer.art, Bitmap)), default=USUAL)


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


def foresee(size: tuple[float, float], _marks: int, *, dpi: float | None, bilevel: bool, **_: object) -> None:
    """Raises ValueError for more pixels than a bitmap takes; what dpi a sheet will have is known only once it is drawn."""
    if dpi is not None:
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
        raise ValueError(
            f"{name}: no recipe can be read from it ({' '.join(str(error).split(' <_io')[0].split())[:80]}); give the file as drawn"
        ) from None
    if not isinstance(found, dict) or not found:
        raise ValueError(f"{name}: keeps no recipe of crowquill; give a picture that it drew")
    return found, {}


def bands(sheet: Sheet, page: Page) -> Iterator[Bytes]:
    """The page's rows from the top, some at a time: codes of 0 to 255 (rows, width * channels), or eight bits to a byte, 1 black.

    Layers are painted from the bottom up, each over its share of the pixel: device codes, not light, so that half a
    pixel of black is 128, and two grey dots that each leave half of it are 64. Inks that overprint are filters over
    what is below. The corner of the page is the corner of a pixel, and pixels are INCH / dpi mm, never stretched.
    """
    side, layers = INCH / page.dpi, [layer for layer in sheet.layers if len(layer.art)]
    arts = [part for layer in layers for part in _parts(layer, side, page)]
    channels = max(1, page.channels)
    for top in range(0, page.height, page.rows):
        bottom = min(page.height, top + page.rows)
        value = np.full((bottom - top, page.width, channels), 255.0)
        for part in arts:
            low, high = max(top, part.top), min(bottom, part.bottom)
            if low < high and part.raster.touches(low, high):
                cover = part.raster.rows(low, high)
                if isinstance(part.raster, Greys) and not page.channels:
                    cover = (cover >= page.black_from).astype(np.float64)
                _paint(value[low - top : high - top, part.left : part.right], cover, part.codes[:channels], part.through)
        if page.channels:
            yield np.floor(value + 0.5).astype(np.uint8).reshape(bottom - top, -1)
        else:
            yield np.packbits(value[..., 0] < 127.5, axis=1)


@dataclass(frozen=True)
class _Part:
    """What is painted in one colour, in codes of red, green and blue, and the pixels of the page it may lie on.

    through  what is below shows through
    """

    raster: Raster | Pixels | Greys
    codes: Array
    left: int
    top: int
    right: int
    bottom: int
    through: bool = False


def _parts(layer: Layer, side: float, page: Page) -> Iterator[_Part]:
    """A layer as one part, or, where rings have colours of their own, each of them on its own few pixels."""
    pixel = (side, side)
    if layer.fill is None:
        raster: Raster | Pixels | Greys
        if page.grey_dots and isinstance(layer.art, Marks) and scanned(layer.art) and layer.ink.pen is None:
            raster = Greys.of(layer.art, pixel=pixel, width=page.width)
        else:
            raster = ready(layer.art, pixel=pixel, width=page.width, pen=layer.ink.pen)
        yield _Part(raster, np.array(layer.ink.rgb, np.float64), 0, 0, page.width, page.height, layer.ink.overprint)
        return
    art, codes = outlined(layer.art), on_screen(layer.fill).astype(np.float64)
    for ring in np.flatnonzero(np.diff(art.start)).tolist():
        path = art.take([ring])
        left, top = (max(0, int(low)) for low in np.floor(path.xy.min(axis=0) / side))
        ends = np.ceil(path.xy.max(axis=0) / side)
        right, bottom = min(page.width, int(ends[0])), min(page.height, int(ends[1]))
        if left < right and top < bottom:
            raster = ready(path.moved(np.eye(2), (-left * side, 0)), pixel=pixel, width=right - left)
            yield _Part(raster, codes[ring], left, top, right, bottom)


def _paint(value: Array, cover: Array, codes: Array, through: bool) -> None:
    """Paints codes (channels,) over values (h, w, channels) where they cover, or lays them over as a filter."""
    shared_out(lambda lo, hi: _over(value[lo:hi], cover[lo:hi], codes, through), len(value), 8)


@compiled
def _over(value: Array, cover: Array, codes: Array, through: bool) -> None:
    for row in range(value.shape[0]):
        for column in range(value.shape[1]):
            share = cover[row, column]
            if share > 0:
                for channel in range(value.shape[2]):
                    below, own = value[row, column, channel], codes[channel]
                    value[row, column, channel] = below * (1 - share) + (own * below / 255 if through else own) * share
