"""What lies on the paper, and how it came there: Ink, Bitmap, Layer, Sheet, Step."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.lettering import Words
from crowquill.marks import Marks, whole
from crowquill.paths import Array, Paths, frozen
from crowquill.units import INCH, PAPERS, UM, paper

SPOT = re.compile(r"[A-Za-z0-9][A-Za-z0-9 \-_.+&()]{0,62}")  # what every press and plate file takes for a name
PROCESS = {"all", "none", "cyan", "magenta", "yellow", "black"}
SHOWN = 20_000  # shapes of an SVG in a notebook; more make browsers slow


@dataclass(frozen=True)
class Ink:
    """An ink by its share of cyan, magenta, yellow and black, each 0 to 1.

    pen        None fills; a width in mm strokes with round ends
    spot       an ink of its own, mixed by the printer under this name; cmyk is how it looks where it is not at hand
    overprint  prints over what lies below, in place of leaving it out there
    """

    name: str = "black"
    cmyk: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)
    pen: float | None = None
    spot: bool = False
    overprint: bool = False

    def __post_init__(self) -> None:
        if len(self.cmyk) != 4 or not all(0 <= share <= 1 for share in self.cmyk):
            raise ValueError(f"cmyk {self.cmyk} of ink {self.name!r} is not four shares from 0 to 1")
        if self.pen is not None and not 0 < self.pen < 1000:
            raise ValueError(f"pen {self.pen} mm of ink {self.name!r} is not a width; give None to fill")
        if self.spot and (not SPOT.fullmatch(self.name) or self.name.lower() in PROCESS):
            raise ValueError(
                f"spot ink {self.name!r}: presses take plain letters, digits, spaces and -_.+&() in such a name, "
                "and it may not be a process ink's; give the name of the swatch book"
            )

    @property
    def rgb(self) -> tuple[int, int, int]:
        """The ink on a screen, red, green and blue of 0 to 255."""
        red, green, blue = on_screen(np.array([self.cmyk]))[0].tolist()
        return red, green, blue


@dataclass(frozen=True, eq=False)
class Bitmap:
    """Black pixels of a device: bits (h, ceil(w / 8)), 1 is ink, the first pixel the highest bit; its corner (2,) mm and dpi."""

    bits: npt.NDArray[np.uint8]
    width: int
    dpi: float
    corner: Array

    def __post_init__(self) -> None:
        if self.width < 1 or not 0 < self.dpi < np.inf:
            raise ValueError(f"a bitmap {self.width} pixels wide at {self.dpi} dpi has no size; give at least one pixel")
        bits = frozen(self.bits, np.uint8, (None, -(-self.width // 8)), "bits")
        if self.width % 8 and len(bits) and (bits[:, -1] & (0xFF >> self.width % 8)).any():
            raise ValueError("bits has ink beyond its width")
        object.__setattr__(self, "bits", bits)
        object.__setattr__(self, "corner", frozen(self.corner, np.float64, (2,), "corner"))

    @classmethod
    def of(cls, black: npt.ArrayLike, dpi: float, corner: npt.ArrayLike = (0.0, 0.0)) -> Bitmap:
        """The bitmap of pixels (h, w), true for ink."""
        pixels = np.asarray(black, bool)
        if pixels.ndim != 2 or not pixels.size:
            raise ValueError(f"black has shape {pixels.shape}; it takes rows by columns, at least one of each")
        return cls(np.packbits(pixels, axis=1), pixels.shape[1], float(dpi), np.asarray(corner, np.float64))

    def __len__(self) -> int:
        """The number of black pixels."""
        return int(np.bitwise_count(self.bits).sum(dtype=np.int64))

    @property
    def size(self) -> tuple[float, float]:
        """Width and height in mm."""
        return self.width * INCH / self.dpi, len(self.bits) * INCH / self.dpi

    def rows(self, top: int, bottom: int) -> npt.NDArray[np.bool_]:
        """Black pixels (bottom - top, width) of these rows."""
        return np.unpackbits(self.bits[top:bottom], axis=1, count=self.width).astype(bool)

    def moved(self, offset: npt.ArrayLike) -> Bitmap:
        """The bitmap moved by offset (2,) mm."""
        return replace(self, corner=self.corner + np.asarray(offset, np.float64))

    def snapped(self) -> Bitmap:
        """Its corner in whole micrometres."""
        return replace(self, corner=whole(self.corner))


Art = Marks | Paths | Words | Bitmap


@dataclass(frozen=True, eq=False)
class Layer:
    """Art in one ink; `name` is shown in editors and is the ink's when empty.

    Filled art follows the nonzero rule: holes turn the other way. `fill` (n, 4), where given, colours each ring of filled
    Paths by itself, in shares of cyan, magenta, yellow and black; rings are then shapes of their own, the later over the earlier.
    """

    ink: Ink
    art: Art
    name: str = ""
    fill: Array | None = None

    def __post_init__(self) -> None:
        if self.fill is None:
            return
        if not isinstance(self.art, Paths) or not self.art.closed or self.ink.pen is not None:
            raise ValueError("fill colours closed paths that are filled; leave it out for marks and strokes")
        fill = frozen(np.round(self.fill, 4), np.float64, (len(self.art), 4), "fill")
        if fill.size and not 0 <= fill.min() <= fill.max() <= 1:
            raise ValueError(f"fill has shares from {fill.min():g} to {fill.max():g}; it takes 0 to 1")
        object.__setattr__(self, "fill", fill)

    @property
    def label(self) -> str:
        """The name shown in editors."""
        return self.name or self.ink.name


@dataclass(frozen=True, eq=False)
class Sheet:
    """A drawing: its size (width, height) in mm, its layers from the bottom up, what made it and what came of it.

    Lengths are snapped to whole micrometres when made, so that save, load, save gives the
    same bytes. `recipe` goes into the file; `report` holds times and warnings and does not. `attached` are
    files by name that go into the file whole.
    """

    size: tuple[float, float]
    layers: tuple[Layer, ...] = ()
    recipe: Mapping[str, Any] = field(default_factory=dict)
    report: Mapping[str, Any] = field(default_factory=dict)
    attached: Mapping[str, bytes] = field(default_factory=dict)

    def __post_init__(self) -> None:
        width, height = (round(float(side), 3) for side in self.size)
        if not (0 < width < np.inf and 0 < height < np.inf):
            raise ValueError(f"sheet size {self.size} mm has no area; both sides must be over 0")
        object.__setattr__(self, "size", (width, height))
        object.__setattr__(self, "layers", tuple(replace(layer, art=_snapped(layer.art)) for layer in self.layers))
        object.__setattr__(self, "recipe", MappingProxyType(dict(self.recipe)))
        object.__setattr__(self, "report", MappingProxyType(dict(self.report)))
        object.__setattr__(self, "attached", MappingProxyType(dict(self.attached)))

    @property
    def marks(self) -> Marks:
        """The marks of the first layer that has any. Raises ValueError where there are none."""
        for layer in self.layers:
            if isinstance(layer.art, Marks):
                return layer.art
        raise ValueError("the sheet has no layer of marks")

    def on(self, page: str | tuple[float, float], *, margin: float = 15.0, orientation: str = "auto") -> Sheet:
        """The same drawing in the middle of a paper, by name or (width, height) mm.

        orientation is auto (a paper with a name is turned to suit the drawing, a size stays as it
        is), portrait or landscape. Raises ValueError where the drawing does not fit inside the margin.
        """
        if not 0 <= margin < np.inf:
            raise ValueError(f"margin is {margin} mm; it takes a length of 0 or more")
        size = turned(page, self.size, orientation)
        (width, height) = self.size
        check_fit(self.size, size, margin)
        offset = whole(np.array([(size[0] - width) / 2, (size[1] - height) / 2]))
        layers = tuple(replace(layer, art=shifted(layer.art, offset)) for layer in self.layers)
        recipe = {**self.recipe, "paper_mm": list(size), "art_mm": [width, height], "art_at_mm": offset.tolist()}
        return Sheet(size, layers, recipe, self.report, self.attached)

    def _repr_svg_(self) -> str | None:
        """What a notebook shows of a drawing that browsers bear: up to SHOWN paths and marks."""
        if sum(len(layer.art) for layer in self.layers) > SHOWN:
            return None
        return str(_formats().to_bytes(self, "svg").decode("utf-8"))

    def _repr_png_(self) -> bytes:
        """What a notebook shows of any drawing: some 900 pixels of its longer side."""
        data: bytes = _formats().to_bytes(self, "png", dpi=min(600.0, max(20.0, 900 * INCH / max(self.size))))
        return data


@dataclass(frozen=True)
class Shown:
    """How a file shows a sheet: as pixels or not; and whether dots that have scans are grey there, as these, and not black."""

    name: str
    pixels: bool
    grey: bool


@dataclass(frozen=True)
class Step:
    """One state of work under way: what stage, how much of it is done, figures of interest, a Sheet where there is one."""

    stage: str
    done: int
    total: int
    facts: Mapping[str, float] = field(default_factory=dict)
    sheet: Sheet | None = None


def _formats() -> Any:
    """The one door that goes up: a sheet shows itself, and formats, which know how, stand above sheets."""
    return import_module("crowquill.formats")


def check_bar(x: float, y: float, length: float = 10.0) -> Layer:
    """A bar of known length with ticks at its ends, its left end at (x, y) mm: whoever lays a ruler on it knows the scale."""
    thin, tick = 0.2, 1.6  # mm
    bars = [(0, 0, length, thin), (0, thin / 2 - tick / 2, thin, tick), (length - thin, thin / 2 - tick / 2, thin, tick)]
    rings = [[(x + a, y + b), (x + a + w, y + b), (x + a + w, y + b + h), (x + a, y + b + h)] for a, b, w, h in bars]
    return Layer(Ink(), Paths.of(rings), f"check bar {length:g} mm")


def turned(page: str | tuple[float, float], art: tuple[float, float], orientation: str) -> tuple[float, float]:
    """The sides of a paper in the orientation asked for; auto turns one with a name to suit the art, unless that is square."""
    size = paper(page) if isinstance(page, str) else (float(page[0]), float(page[1]))
    short, long = sorted(size)
    if orientation == "auto":
        named = isinstance(page, str) and page.strip().lower() in PAPERS
        orientation = "as it is" if art[0] == art[1] or not named else "landscape" if art[0] > art[1] else "portrait"
    sides = {"portrait": (short, long), "landscape": (long, short), "as it is": size}
    if orientation not in sides:
        raise ValueError(f"no orientation {orientation!r}; there are auto, landscape, portrait")
    return sides[orientation]


def check_fit(art: tuple[float, float], size: tuple[float, float], margin: float) -> None:
    """Raises ValueError where a drawing does not go on a paper inside a margin, all in mm."""
    if art[0] > size[0] - 2 * margin + UM or art[1] > size[1] - 2 * margin + UM:
        raise ValueError(
            f"a drawing of {art[0]:.6g} x {art[1]:.6g} mm does not fit a paper of {size[0]:g} x {size[1]:g} mm "
            f"with a margin of {margin:g} mm; make it smaller, or the paper larger"
        )


def on_screen(cmyk: Array) -> npt.NDArray[np.uint8]:
    """Shares of cyan, magenta, yellow and black (n, 4) as red, green and blue (n, 3) of 0 to 255: each takes its share of the light."""
    return np.round(255 * (1 - cmyk[:, :3]) * (1 - cmyk[:, 3:])).astype(np.uint8)


def in_process(rgb: npt.ArrayLike) -> Array:
    """Red, green and blue (n, 3), 0 to 255, as shares (n, 4) of cyan, magenta, yellow and black, of which on_screen() makes them again.

    Black takes what the three share, so that greys are black ink alone.
    """
    light = np.asarray(rgb, np.float64) / 255
    most = light.max(axis=1, keepdims=True)
    return np.concatenate([1 - light / np.where(most > 0, most, 1), 1 - most], axis=1) * np.where(most > 0, 1, (0, 0, 0, 1))


def outlined(art: Art) -> Paths:
    """The outlines of art as paths. Raises ValueError for a bitmap, which has none."""
    if isinstance(art, Bitmap):
        raise ValueError("pixels of a device have no outlines; draw them as polygons or as dots")
    return art if isinstance(art, Paths) else art.outlines()


def shifted(art: Art, offset: Array) -> Art:
    """The art moved by offset (2,) mm."""
    return art.moved(np.eye(2), offset) if isinstance(art, Paths) else art.moved(offset)


def _snapped(art: Art) -> Art:
    return replace(art, xy=whole(art.xy)) if isinstance(art, Paths) else art.snapped()
