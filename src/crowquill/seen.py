"""A drawing as the judge sees it: the dots of an SVG, ours or another's, or of a bitmap, and the paper they cover."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from crowquill import formats, raster
from crowquill.formats.svg import drawn
from crowquill.glyphs.page import tagged
from crowquill.marks import Marks
from crowquill.paths import Array, Paths, frozen
from crowquill.picture import read
from crowquill.sheet import Art, Bitmap, Ink, Layer, Sheet, on_screen, shifted
from crowquill.units import INCH
from crowquill.vector import contents

SPOT = 1e-3  # of a stroke's width: a line so short is a dot
LINES = 8  # scan lines to a pixel of coverage


@dataclass(frozen=True, eq=False)
class Seen:
    """What is drawn on a page of `size` (width, height) mm.

    sites     (n, 2) mm, the centroid of each dot; `areas` (n,) mm^2, of each by itself, and its `darkness` 0 to 1
    marks     the same dots as placed glyphs, where every one is a mark of one layer
    layers    the art, from the bottom up, or None for a bitmap
    pixels    (h, w) of 0 (paper) to 1 and their side in mm, of a bitmap
    recipe    what made it, where it says so
    notes     what is to be said of how it was read
    """

    name: str
    size: tuple[float, float]
    sites: Array
    areas: Array
    marks: Marks | None = None
    layers: tuple[Layer, ...] = ()
    pixels: Array | None = None
    pixel: float = 0.0
    recipe: dict[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "sites", frozen(self.sites, np.float64, (None, 2), "sites"))
        object.__setattr__(self, "areas", frozen(self.areas, np.float64, (len(self.sites),), "areas"))

    @property
    def diameters(self) -> Array:
        """Of circles of the dots' areas, (n,) mm."""
        return np.asarray(2 * np.sqrt(self.areas / np.pi))

    def coverage(self, pitch: float, box: tuple[float, float, float, float] | None = None) -> tuple[Array, tuple[float, float]]:
        """How dark each pixel of a part of the page is, (h, w) of 0 to 1, and a pixel's sides in mm, which are near `pitch`.

        box  left, top, width, height in mm; None is the whole page
        """
        left, top, width, height = box or (0.0, 0.0, *self.size)
        if self.pixels is not None:
            return self._averaged(pitch, left, top, width, height)
        grid = max(1, round(height / pitch)), max(1, round(width / pitch))
        pixel = width / grid[1], height / grid[0]
        dark = np.zeros(grid)
        for layer in self.layers:
            art = shifted(layer.art, np.array([-left, -top]))
            for part, depth in _depths(layer, art):
                cover = raster.covered(part, grid, pixel=pixel, pen=layer.ink.pen, lines=LINES)
                dark += cover * (depth - dark)
        return dark, pixel

    def _averaged(self, pitch: float, left: float, top: float, width: float, height: float) -> tuple[Array, tuple[float, float]]:
        """Means of whole blocks of a bitmap's pixels."""
        assert self.pixels is not None
        first = round(top / self.pixel), round(left / self.pixel)
        last = round((top + height) / self.pixel), round((left + width) / self.pixel)
        part = self.pixels[first[0] : max(first[0] + 1, last[0]), first[1] : max(first[1] + 1, last[1])]
        k = max(1, min(round(pitch / self.pixel), *part.shape))
        h, w = part.shape[0] // k, part.shape[1] // k
        blocks = part[: h * k, : w * k].reshape(h, k, w, k).mean(axis=(1, 3))
        return np.asarray(blocks), (k * self.pixel, k * self.pixel)


def _depths(layer: Layer, art: Art) -> list[tuple[Art, float]]:
    """A layer's art by how dark it is; rings with colours of their own in 64 steps."""
    if layer.fill is None or not isinstance(art, Paths):
        return [(art, darkness(layer.ink))]
    step = np.round(64 * (1 - on_screen(layer.fill).sum(axis=1) / 765)).astype(np.int64)
    return [(art.take(np.flatnonzero(step == k)), k / 64) for k in np.unique(step).tolist()]


def darkness(ink: Ink) -> float:
    """How dark an ink is on a screen, 0 (white) to 1 (black)."""
    return 1 - sum(ink.rgb) / 765


def load(path: Path, *, dpi: float | None = None) -> Seen:
    """What a file shows: an SVG of ours with its marks, any other SVG with its closed shapes as dots, or a bitmap.

    dpi  of a bitmap; the file's own when left out. In a bitmap dots that touch are one, and a note says so
    Raises ValueError for what is neither, and for a bitmap of unknown size.
    """
    if path.suffix.lower() != ".svg":
        return _bitmap(path, dpi)
    data = contents(path)
    if b"urn:crowquill:drawing" not in data:
        return of_sheet(drawn(data, str(path)), str(path))
    with path.open("rb") as file:
        return of_sheet(formats.load(file), str(path))


def of_sheet(sheet: Sheet, name: str = "sheet") -> Seen:
    """What a sheet shows. Dots are its marks, or, where it has none, its filled outlines and strokes too short to be lines.

    Of its bitmaps they are the black pixels that hang together.
    """
    marks = [layer.art for layer in sheet.layers if isinstance(layer.art, Marks) and len(layer.art)]
    notes = tuple(sheet.report.get("warnings", ()))
    recipe = dict(sheet.recipe)
    if marks:
        sites = np.concatenate([art.xy for art in marks])
        areas = np.concatenate([art.scale**2 for art in marks])
        return Seen(name, sheet.size, sites, areas, marks[0] if len(marks) == 1 else None, sheet.layers, recipe=recipe, notes=notes)
    found = [_dots(layer) for layer in sheet.layers if isinstance(layer.art, Paths)]
    found += [_clumps(layer.art) for layer in sheet.layers if isinstance(layer.art, Bitmap)]
    sites = np.concatenate([np.zeros((0, 2)), *(part for part, _ in found)])
    areas = np.concatenate([np.zeros(0), *(part for _, part in found)])
    return Seen(name, sheet.size, sites, areas, None, sheet.layers, recipe=recipe, notes=notes)


def _dots(layer: Layer) -> tuple[Array, Array]:
    """Centroids and areas of the dots among a layer's paths."""
    art, pen = layer.art, layer.ink.pen
    assert isinstance(art, Paths)
    if pen is not None:  # round caps make a dot of a line of no length
        filled = np.diff(art.start) > 0
        first = art.xy[art.start[:-1][filled]]
        far = np.zeros(len(art))
        np.maximum.at(far, art.path, np.hypot(*(art.xy - first[np.cumsum(filled)[art.path] - 1]).T))
        spots = far[filled] <= SPOT * pen
        return first[spots], np.full(int(spots.sum()), np.pi / 4 * pen**2)
    if not art.closed:
        return np.zeros((0, 2)), np.zeros(0)
    m = art.green()
    solid = m[:, 0] != 0
    corner = art.xy[art.start[:-1][solid]]
    return corner + m[solid, 1:3] / m[solid, :1], np.abs(m[solid, 0])


def _clumps(art: Bitmap) -> tuple[Array, Array]:
    """Centroids and areas of the black pixels of a bitmap that hang together, by their sides or corners."""
    from scipy import ndimage

    black, side = art.rows(0, len(art.bits)), INCH / art.dpi
    labels, n = ndimage.label(black, np.ones((3, 3), int))
    row, column = np.nonzero(black)
    label = labels[row, column] - 1
    count = np.bincount(label, minlength=n)
    sites = np.stack([np.bincount(label, axis + 0.5, n) / count for axis in (column, row)], axis=1)
    return art.corner + sites * side, np.asarray(count * side**2)


def _bitmap(path: Path, dpi: float | None) -> Seen:
    """What a picture of a drawing shows: pixels, and dots as the dark places that hang together."""
    from scipy import ndimage

    code, notes = read(path)
    dpi = dpi or tagged(path)
    if dpi is None:
        raise ValueError(f"{path}: its dpi is not known, so nothing in it has a size; give --dpi")
    side = INCH / dpi
    dark = 1 - code
    labels, n = ndimage.label(dark >= 0.5, np.ones((3, 3), int))
    near = np.where(labels > 0, labels, ndimage.maximum_filter(labels, 3))  # a dot's soft rim is its own
    ink = np.bincount(near.ravel(), dark.ravel(), n + 1)[1:]
    y, x = np.indices(dark.shape)
    sites = np.stack([np.bincount(near.ravel(), (dark * (axis + 0.5)).ravel(), n + 1)[1:] / ink for axis in (x, y)], axis=1) * side
    areas = np.asarray(ink * side**2, np.float64)
    said = notes
    if n and (joined := int((areas > 1.6 * np.median(areas)).sum())):
        said += (f"{joined} of {n} dark places are larger than a dot: dots that touch are counted as one, the drawing's SVG would tell",)
    size = dark.shape[1] * side, dark.shape[0] * side
    return Seen(str(path), size, sites, areas, pixels=dark, pixel=side, recipe=_kept(path, size), notes=said)


def _kept(path: Path, size: tuple[float, float]) -> dict[str, Any]:
    """The recipe in a bitmap of ours, where it still has the size of its paper."""
    try:
        found, _ = formats.recipe_of(path)
    except ValueError:
        return {}
    return found if np.allclose(found.get("paper_mm", (0, 0)), size, rtol=0.01) else {}
