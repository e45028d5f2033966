"""Glyphs and Marks: dots, what they take of the light, and where they lie."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.paths import Array, Index, Paths, fixed, frozen

THIN = 1e-4  # area over the square of the length: below, a shape is a hair, and its area may be rounding
TURN_STEPS = 65536  # angles are kept to this part of a turn: 1.4e-5 mm at the rim of a 0.3 mm dot


@dataclass(frozen=True, eq=False)
class Patch:
    """A dot as it was scanned, as it lay on the page.

    grey       (h, w) of the light taken, 0 (paper) to 1
    pixel_mm   side of a pixel
    centre_mm  (2,) the centroid of its outline, x and y from the patch's top left corner
    turn       rad, where the long axis of its outline lies, from x towards y
    """

    grey: Array
    pixel_mm: float
    centre_mm: Array
    turn: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "grey", frozen(self.grey, np.float64, (None, None), "grey"))
        object.__setattr__(self, "centre_mm", frozen(self.centre_mm, np.float64, (2,), "centre_mm"))


@dataclass(frozen=True, eq=False)
class Glyph:
    """The outline of a dot: one path of area 1, centroid 0 and long axis on x; `size` is its true diameter in mm.

    `grey` is its scan, where it is to be drawn as that too.
    """

    paths: Paths
    size: float
    grey: Patch | None = None

    @classmethod
    def of(cls, outline: Paths, grey: Patch | None = None) -> Glyph:
        """The unit glyph of a closed outline in mm, which may wind either way, and its scan as it lay.

        Raises ValueError for an outline without area.
        """
        m = outline.green().sum(axis=0) if len(outline) == 1 and outline.closed else np.zeros(6)
        extent = np.ptp(outline.xy, axis=0).max() if len(outline.xy) else 0.0
        if not abs(m[0]) > THIN * extent**2:
            raise ValueError("its shape is no dot; a glyph takes one closed outline with an area over 0")
        x, y = m[1:3] / m[0]
        xx, xy, yy = m[3] / m[0] - x * x, m[4] / m[0] - x * y, m[5] / m[0] - y * y
        long = 0.5 * np.arctan2(2 * xy, xx - yy)
        cos, sin = np.cos(long), np.sin(long)
        centred = outline.moved(np.eye(2), -(outline[0][0] + (x, y)))
        scale = abs(m[0]) ** -0.5
        unit = centred.moved(scale * np.array([[cos, sin], [-sin, cos]]))
        points = unit.xy
        if m[0] < 0:  # the same ring the other way round; a cubic's controls trade places by it
            points = np.roll(points[::-1], 1, axis=0)
        scan = replace(grey, turn=float(long)) if grey else None
        return cls(Paths(points, unit.start, True, outline.cubic), float(2 * np.sqrt(abs(m[0]) / np.pi)), scan)

    @property
    def reach(self) -> float:
        """The greatest distance of the outline from its centroid, a thousandth of the mark's scale too large at most."""
        return float(np.hypot(*self.paths.flat(1e-3).xy.T).max()) + 1e-3


@dataclass(frozen=True, eq=False)
class Marks:
    """Many placed glyphs: xy (n, 2) mm, angle (n,) rad, scale (n,) mm, glyph (n,) index into `glyphs`.

    A closed mark's own area is scale**2 mm^2.
    """

    xy: Array
    angle: Array
    scale: Array
    glyph: Index
    glyphs: tuple[Glyph, ...]

    def __post_init__(self) -> None:
        freeze_columns(self, "glyph", len(self.glyphs))
        if len(self) and self.scale.min() < 0:
            raise ValueError(f"scale {self.scale.min()} mm is negative")

    @classmethod
    def of(
        cls,
        xy: npt.ArrayLike,
        glyphs: tuple[Glyph, ...],
        *,
        scale: npt.ArrayLike,
        angle: npt.ArrayLike = 0.0,
        glyph: npt.ArrayLike = 0,
    ) -> Marks:
        """Marks at xy (n, 2); scale, angle and glyph are one value for all or (n,)."""
        return cls(*columns(xy, angle, scale, glyph), tuple(glyphs))

    def __len__(self) -> int:
        return len(self.xy)

    def take(self, which: Index | npt.NDArray[np.bool_] | slice) -> Marks:
        """The marks at these indices, this mask or slice."""
        xy, angle, scale, glyph = (fixed(column[which]) for column in (self.xy, self.angle, self.scale, self.glyph))
        return Marks(xy, angle, scale, glyph, self.glyphs)

    def moved(self, offset: npt.ArrayLike) -> Marks:
        """All marks moved by offset (2,) mm."""
        return replace(self, xy=fixed(self.xy + np.asarray(offset, np.float64)))

    def snapped(self) -> Marks:
        """Places and scales in whole micrometres, angles in whole steps: what a file can keep."""
        step = 2 * np.pi / TURN_STEPS
        turns = np.round(self.angle / step)
        turns %= TURN_STEPS
        turns *= step
        return replace(self, xy=fixed(whole(self.xy)), scale=fixed(whole(self.scale)), angle=fixed(turns))

    def outlines(self) -> Paths:
        """Every mark's outline at its place, in the order of the marks. Straight and cubic glyphs may not be mixed."""
        if not len(self):
            return Paths.of([])
        shapes = self._shapes
        counts = np.diff(shapes.start)[self.glyph]
        start = np.concatenate([[0], np.cumsum(counts)])
        x, y = shapes.xy[np.repeat(shapes.start[self.glyph] - start[:-1], counts) + np.arange(start[-1])].T
        cos, sin = np.repeat(self.scale * np.cos(self.angle), counts), np.repeat(self.scale * np.sin(self.angle), counts)
        xy = np.stack([cos * x - sin * y, sin * x + cos * y], axis=1) + np.repeat(self.xy, counts, axis=0)
        return Paths(xy, start, shapes.closed, shapes.cubic)

    @cached_property
    def _shapes(self) -> Paths:
        """All glyphs' outlines as one Paths."""
        kinds = {(glyph.paths.closed, glyph.paths.cubic) for glyph in self.glyphs}
        if len(kinds) > 1:
            raise ValueError("marks mix straight and cubic, or closed and open glyphs; make a layer of each")
        closed, cubic = kinds.pop()
        return Paths.of([glyph.paths.xy for glyph in self.glyphs], closed=closed, cubic=cubic)


def together(parts: list[Marks]) -> Marks:
    """All marks of several, in their order; of one, that one."""
    first = np.cumsum([0, *(len(part.glyphs) for part in parts)])
    if len(parts) == 1:
        return parts[0]
    xy, angle, scale = (np.concatenate([getattr(part, name) for part in parts]) for name in ("xy", "angle", "scale"))
    glyph = np.concatenate([part.glyph + at for part, at in zip(parts, first, strict=False)])
    return Marks(xy, angle, scale, glyph, tuple(glyph for part in parts for glyph in part.glyphs))


def columns(xy: npt.ArrayLike, angle: npt.ArrayLike, scale: npt.ArrayLike, kind: npt.ArrayLike) -> tuple[Array, Array, Array, Index]:
    """Columns of things placed at xy (n, 2): angle, scale and kind, each one value for all or (n,)."""
    points = np.asarray(xy, np.float64)
    points = points if points.ndim == 2 and points.shape[1] == 2 else points.reshape(-1, 2)

    def spread(values: npt.ArrayLike, dtype: Any) -> npt.NDArray[Any]:
        column = np.asarray(values, dtype)
        return column if column.shape == points.shape[:1] else np.broadcast_to(column, len(points))

    return points, spread(angle, np.float64), spread(scale, np.float64), spread(kind, np.int64)


def freeze_columns(things: Any, kind: str, kinds: int) -> None:
    """Makes xy, angle, scale and the column named `kind` of a frozen dataclass read-only, all of one length.

    Raises ValueError where they are not, or where a kind is none of so many.
    """
    n = len(things.xy)
    object.__setattr__(things, "xy", frozen(things.xy, np.float64, (n, 2), "xy"))
    for name, dtype in (("angle", np.float64), ("scale", np.float64), (kind, np.int64)):
        object.__setattr__(things, name, frozen(getattr(things, name), dtype, (n,), name))
    index = getattr(things, kind)
    if n and not 0 <= index.min() <= index.max() < kinds:
        raise ValueError(f"{kind} has an index outside 0 to {kinds - 1}")


def whole(values: Array) -> Array:
    """Millimetres to the nearest whole micrometre: the float nearest to that decimal."""
    return np.round(values, 3)
