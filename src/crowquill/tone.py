"""Tone: how much ink a picture asks for, place by place, on a canvas of stated millimetres."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import cast

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import footprint, light
from crowquill.footprint import touched as touched  # by cells
from crowquill.levels import BLOCK as BLOCK  # whose sums these are
from crowquill.levels import Levels
from crowquill.light import TONES, Source
from crowquill.paths import Array, frozen
from crowquill.picture import MAX_PIXELS, File, kept, window

FITS = ("contain", "cover", "stretch")
WIDTH = 180.0  # mm of a picture of which nothing is said: A4 less its margins


@dataclass(frozen=True, eq=False)
class Tone:
    """Coverage on a rectangle: pixel (r, c) of (h, w) covers a rectangle of `size`, not a lattice point.

    values      (h, w) share of paper to be covered by ink, 0 to 1, as an array or as Levels; see `coverage` and `levels`
    size        (width, height) mm
    canvas      shapely Polygon or MultiPolygon in mm, origin top left, y down; None for the whole rectangle
    importance  (h, w) of 0 to 1: 1 is what matters most, one half neither more nor less than others; None for no wish
    notes       what is to be said of how the picture was read
    rgb         (h, w, 3) its colours as sRGB code values of 0 to 255, where they were asked for
    """

    values: npt.ArrayLike | Levels
    size: tuple[float, float]
    canvas: shapely.Geometry | None = None
    importance: Array | None = None
    notes: tuple[str, ...] = ()
    rgb: npt.NDArray[np.uint8] | None = None

    def __post_init__(self) -> None:
        levels = Levels.of(self.values)
        importance = None if self.importance is None else frozen(self.importance, np.float64, levels.shape, "importance")
        if importance is not None:
            Levels(importance).check("importance")
        width, height = (float(side) for side in self.size)
        if not (0 < width < np.inf and 0 < height < np.inf):
            raise ValueError(f"size {self.size} mm has no area; both sides must be over 0")
        sheet = shapely.box(0, 0, width, height)
        canvas = sheet if self.canvas is None else _canvas(self.canvas, sheet)
        shapely.prepare(canvas)
        rgb = None if self.rgb is None else frozen(self.rgb, np.uint8, (*levels.shape, 3), "rgb")
        kept = {"values": levels, "size": (width, height), "canvas": canvas, "importance": importance, "rgb": rgb}
        for name, value in {**kept, "notes": tuple(self.notes)}.items():
            object.__setattr__(self, name, value)

    @classmethod
    def load(
        cls,
        source: Source,
        *,
        width: float | None = None,
        height: float | None = None,
        fit: str = "contain",
        tone: str = "auto",
        gamma: float = 1.0,
        black_point: float | None = None,
        white_point: float | None = None,
        invert: bool = False,
        crop: tuple[float, float, float, float] | None = None,
        local_contrast: float = 0.0,
        canvas: shapely.Geometry | None = None,
        importance: Source | None = None,
        colour: bool = False,
        toned: bool = False,
        max_pixels: int = MAX_PIXELS,
    ) -> Tone:
        """The Tone of a picture file, an open file or an array, on so many mm.

        source          path or binary file of a picture; an array is coverage itself, 0 to 1,
                        and takes none of the options of light
        width, height   mm; one gives the other by the picture's shape, neither gives 180 mm of width,
                        both are a box: see fitted()
        tone            "linear": light is decoded from sRGB and coverage is 1 - light, physically exact;
                        "grey": 1 - code value; "auto": lightness L* between the picture's
                        own white and black points, the black point at 0.95
        gamma           coverage ** gamma at the end; above 1 opens the shadows
        black_point     code value (0 to 1) taken as full ink; white_point as no ink; None leaves it to the tone
        crop            left, top, width, height as shares of the picture, before all else
        local_contrast  0 to 1, how much of the difference to the surroundings is added (unsharp, 2 % of the width)
        canvas          polygon in mm to draw in; None is the whole rectangle
        importance      a picture file or an array of 0 to 1, white for what matters most; it is laid over the
                        picture before the crop, whatever its own size; transparent pixels in it are one half
        colour          keep the picture's colours too, inverted where it is; no other option of light changes them
        toned           unless they are to go through all of these, channel by channel; "auto" leaves them as they are

        Transparent pixels lie on white, EXIF turns the picture upright, an ICC profile leads to sRGB. A float
        TIFF is scaled by its finite range, whatever the tone; NaN in it is no ink.
        Raises ValueError for what is not a picture, OSError for what cannot be read.
        """
        if tone not in TONES:
            raise ValueError(f"no tone {tone!r}; there are {', '.join(TONES)}")
        if not 0 < gamma <= 10:
            raise ValueError(f"gamma is {gamma}; it takes a number over 0, up to 10")
        if not 0 <= local_contrast <= 1:
            raise ValueError(f"local contrast is {local_contrast}; it takes 0 to 1")
        notes: tuple[str, ...] = ()
        if light.is_file(source):
            code, notes = kept(cast(File, source), max_pixels)
            part = window(code.shape, crop)
            whole, levels = code.shape, light.coverage(code.cut(*part), tone, black_point, white_point)
        else:
            if black_point is not None or white_point is not None:
                raise ValueError("an array is coverage itself and has no black or white point; leave them out")
            given = np.asarray(source, np.float64)
            if given.ndim != 2 or given.size == 0:
                raise ValueError(f"an array of shape {given.shape} is no coverage; give (rows, columns), at least one of each")
            part = window(given.shape, crop)
            whole, levels = given.shape, Levels(frozen(given[part], np.float64, (None, None), "coverage"))

        def changed(levels: Levels) -> Levels:
            levels = light.sharpened(levels, local_contrast) if local_contrast else levels
            levels = levels.mapped(lambda value: 1 - value) if invert else levels
            return levels if gamma == 1 else levels.mapped(lambda value: value**gamma)

        levels = changed(levels).spread()
        h, w = levels.shape
        wish = None
        if importance is not None:
            wish, more = light.wished(importance, whole, part, max_pixels)
            notes += tuple(f"importance: {note}" for note in more)
        rgb = light.on_white(cast(File, source), part, max_pixels) if colour and light.is_file(source) else None
        if rgb is not None and toned:
            rgb = light.toned(rgb, tone, black_point, white_point, changed)
        elif rgb is not None and invert:
            rgb = 255 - rgb
        loaded = cls(levels, (WIDTH, WIDTH * h / w), importance=wish, notes=notes, rgb=rgb).fitted(width, height, fit)
        return loaded if canvas is None else replace(loaded, canvas=canvas)

    @property
    def pixel(self) -> tuple[float, float]:
        """Width and height of a pixel in mm."""
        return self.size[0] / self.shape[1], self.size[1] / self.shape[0]

    @property
    def levels(self) -> Levels:
        """Coverage by pixel, as it is kept: pictures of LARGE and more as codes, of which a band of rows is had at a time."""
        return cast(Levels, self.values)

    @property
    def coverage(self) -> Array:
        """(h, w): all of it; where codes are kept, made anew at each call."""
        return self.levels.whole()

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of pixels."""
        return self.levels.shape

    @property
    def across(self) -> float:
        """The shorter side of the rectangle around the canvas, mm."""
        return float(np.diff(np.array(shapely.bounds(self.canvas)).reshape(2, 2), axis=0).min())

    @property
    def inked(self) -> Levels:
        """The share of each pixel's own area that is asked to be ink inside the canvas, (h, w)."""
        if self.is_rectangle:
            return self.levels
        return Levels.filled(self.shape, lambda top, bottom: self.levels.rows(top, bottom) * self.within.rows(top, bottom))

    @cached_property
    def ink(self) -> float:
        """The area of ink asked for inside the canvas, mm^2."""
        return self.inked.sum() * self.pixel[0] * self.pixel[1]

    @cached_property
    def is_rectangle(self) -> bool:
        """Whether the canvas is the whole rectangle."""
        return bool(shapely.equals(self.canvas, shapely.box(0, 0, *self.size)))

    @cached_property
    def within(self) -> Levels:
        """The share of each pixel that lies in the canvas, exact, or to half a code where coverage is kept as codes."""
        whole = Levels(np.broadcast_to(1.0, self.shape))
        return whole if self.is_rectangle else footprint.shares(self.canvas, self.shape, self.pixel)

    @property
    def inside(self) -> Array:
        """The same as numbers, (h, w)."""
        return self.within.whole()

    @cached_property
    def prefix(self) -> Array:
        """(h, w, 4): sums of coverage by row, as prefix_of() has them, for all rows: 32 bytes a pixel, kept with the tone."""
        table = self.prefix_of(0, self.shape[0])
        table.setflags(write=False)
        return table

    def prefix_of(self, top: int, bottom: int) -> Array:
        """(bottom - top, w, 4): the rows from top to bottom of `prefix`, bit for bit, made for this call by all cores.

        For each pixel the sums of coverage times 1, x, x^2 over the pixels before it in its block, and its coverage; see
        Levels.sums. Rows past the last are left out. Each row is by itself, so that any band gives the same numbers: what
        goes along a picture of LARGE pixels and more takes sites in the order of the first row of their cells, as many at a
        time as lie within some rows, and asks for the rows from the first to the last that these cells touch. Whole cells
        give the same sums, bit for bit, as with the whole of `prefix`.
        """
        return self.levels.sums(top, bottom)

    def fitted(self, width: float | None = None, height: float | None = None, fit: str = "contain") -> Tone:
        """The same picture at another size in mm; its canvas goes with it.

        One side gives the other by the picture's shape. For both, fit is contain (as large as
        goes in), cover (the middle, cut to whole pixels) or stretch. Raises ValueError otherwise.
        """
        if fit not in FITS:
            raise ValueError(f"no fit {fit!r}; there are {', '.join(FITS)}")
        for name, side in (("width", width), ("height", height)):
            if side is not None and not 0 < side < np.inf:
                raise ValueError(f"{name} is {side} mm; it takes a length over 0")
        h, w = self.shape
        old = np.array(self.size)
        if width is None or height is None or fit == "contain":
            scale = min(side / own for side, own in zip((width, height), old, strict=True) if side is not None) if width or height else 1
            return self._resized(slice(h), slice(w), (old[0] * scale, old[1] * scale))
        if fit == "stretch":
            return self._resized(slice(h), slice(w), (width, height))
        scale = max(width / old[0], height / old[1])
        columns = max(1, round(width / (self.pixel[0] * scale)))
        rows = max(1, round(height / (self.pixel[1] * scale)))
        x, y = (w - columns) // 2, (h - rows) // 2
        return self._resized(slice(y, y + rows), slice(x, x + columns), (width, height))

    def _resized(self, rows: slice, columns: slice, size: tuple[float, float]) -> Tone:
        coverage = self.levels.cut(rows, columns)
        importance = None if self.importance is None else self.importance[rows, columns]
        rgb = None if self.rgb is None else self.rgb[rows, columns]
        if self.is_rectangle:
            return Tone(coverage, size, None, importance, self.notes, rgb)
        corner = np.array([columns.start or 0, rows.start or 0]) * self.pixel
        scale = np.array(size) / (coverage.shape[1], coverage.shape[0]) / self.pixel
        canvas = shapely.transform(self.canvas, lambda xy: (xy - corner) * scale)
        return Tone(coverage, size, canvas, importance, self.notes, rgb)

    def mapped(self, curve: Callable[[Array], Array]) -> Tone:
        """The same canvas with curve(coverage) for coverage: the curve takes and gives arrays of 0 to 1, each number by itself."""
        return self.holding(self.levels.mapped(curve))

    def holding(self, values: npt.ArrayLike | Levels) -> Tone:
        """The same canvas with this coverage, (h, w) of 0 to 1."""
        changed = replace(self, values=values)
        if not self.is_rectangle:  # half a second of clipping on a traced specimen, and all that is drawn of it needs the same
            vars(changed)["within"] = self.within
        return changed

    def at(self, xy: npt.ArrayLike) -> Array:
        """Coverage of the pixel under each point, (n,); points outside take the nearest pixel."""
        return self.levels.at(*self.under(xy))

    def under(self, xy: npt.ArrayLike) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
        """Row and column of the pixel under each point of (n, 2); points outside take the nearest pixel."""
        points, (h, w), (dx, dy) = np.asarray(xy, np.float64), self.shape, self.pixel
        column = np.clip(np.floor(points[:, 0] / dx), 0, w - 1).astype(np.int64)
        row = np.clip(np.floor(points[:, 1] / dy), 0, h - 1).astype(np.int64)
        return row, column

    def holds(self, xy: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Whether each point of (n, 2) lies in the canvas, its border included."""
        points = np.asarray(xy, np.float64)
        if self.is_rectangle:
            return np.asarray(((points >= 0) & (points <= self.size)).all(axis=1))
        return np.asarray(shapely.intersects_xy(self.canvas, points[:, 0], points[:, 1]))


def _canvas(canvas: shapely.Geometry, sheet: shapely.Geometry) -> shapely.Geometry:
    """The canvas inside the sheet as a valid (Multi)Polygon of area over 0, or ValueError."""
    if not shapely.is_valid(canvas):
        raise ValueError(f"canvas is not a sound polygon: {shapely.is_valid_reason(canvas)}; mend its outline")
    parts = [p for p in shapely.get_parts(shapely.intersection(canvas, sheet)) if p.geom_type == "Polygon" and p.area > 0]
    if not parts:
        raise ValueError("canvas has no area on the picture; it is a polygon in mm from the picture's top left corner")
    return parts[0] if len(parts) == 1 else shapely.multipolygons(parts)
