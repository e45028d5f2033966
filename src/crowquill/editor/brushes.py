"""Brushes: which items are under the way of one, and how strongly."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import shapely

from crowquill.editor.drawing import Drawing, Layer
from crowquill.editor.items import Items
from crowquill.kernel import compiled
from crowquill.knobs import Choice, Numbers, Range
from crowquill.paths import Array, Index

FAR = 100_000  # mm
MOST = 30_000  # numbers of a path: ten thousand points

Path = Annotated[tuple[float, ...] | None, Numbers(-FAR, FAR, "mm", "way: x, y, pressure of each point, pressure from 0 to 1")]
Size = Annotated[float, Range(0, 1000, "mm", "diameter of the brush")]
Strength = Annotated[float, Range(0, 1, "", "how much it does")]
Falloff = Annotated[str, Choice(("smooth", "linear", "flat"), "from the middle to the rim")]
On = Annotated[str, Choice(("brush", "selection", "all"), "what it changes")]
OfLayer = Annotated[int | None, Range(1, 10**6, "", "of this layer only; left out, of all that may change")]


@dataclass(frozen=True, eq=False)
class Brush:
    """A round brush on its way: points (m, 2) mm, pressure (m,), its radius in mm, strength, and how that falls off."""

    points: Array
    pressure: Array
    radius: float
    strength: float
    falloff: str

    @classmethod
    def of(cls, path: tuple[float, ...] | None, size: float, strength: float = 1.0, falloff: str = "flat") -> Brush:
        """The brush of an operation's parameters. Raises ValueError for a path that is none."""
        points, pressure = way(path)
        return cls(points, pressure, size / 2, strength, falloff)

    @property
    def headings(self) -> Array:
        """The direction of the way at each point, rad: towards the next, at the last from the one before; 0 for a point alone."""
        step = np.diff(self.points, axis=0)
        ahead = np.arctan2(step[:, 1], step[:, 0]) if len(step) else np.zeros(1)
        return np.concatenate([ahead, ahead[-1:]])[: len(self.points)]

    def near(self, xy: Array) -> Index:
        """Which places lie in the box of the way, grown by the radius."""
        low, high = self.points.min(axis=0) - self.radius, self.points.max(axis=0) + self.radius
        x, y = xy[:, 0], xy[:, 1]
        return np.flatnonzero((x >= low[0]) & (x <= high[0]) & (y >= low[1]) & (y <= high[1]))

    def under(self, xy: Array) -> tuple[Index, Array]:
        """The rows of places (n, 2) under the brush, and the weight of each, over 0 to 1."""
        rows = self.near(xy)
        far, at = self._nearest(xy[rows])
        pressure = np.interp(at, np.arange(len(self.points)), self.pressure)
        weight = self.strength * pressure * self.profile(far)
        return rows[weight > 0], weight[weight > 0]

    def heading(self, xy: Array) -> Array:
        """The direction of the way where it is nearest to each place (n, 2), rad."""
        return np.asarray(self.headings[self._nearest(xy)[1].astype(np.int64)])

    def _nearest(self, xy: Array) -> tuple[Array, Array]:
        """How far each place is from the way, mm, and where along it: 1.5 is halfway from the second point to the third."""
        far, at = np.full(len(xy), np.inf), np.zeros(len(xy))
        _nearest(xy, self.points, far, at)
        return np.sqrt(far), at

    def profile(self, far: Array) -> Array:
        """How much of the strength is left so far from the way, 0 beyond the radius."""
        share = np.where(far <= self.radius, 1 - far / max(self.radius, 1e-9), 0.0)
        share = np.where((self.radius == 0) & (far == 0), 1.0, share)
        if self.falloff == "flat":
            return np.where(far <= self.radius, 1.0, 0.0)
        return share if self.falloff == "linear" else share * share * (3 - 2 * share)


@compiled
def _nearest(xy: Array, points: Array, far: Array, at: Array) -> None:
    """Fills in the square of each place's distance from a line through points, or from a point alone, and where along it."""
    for i in range(len(xy)):
        for k in range(max(1, len(points) - 1)):
            x, y = points[k, 0], points[k, 1]
            u, v, t = 0.0, 0.0, 0.0
            if len(points) > 1:
                u, v = points[k + 1, 0] - x, points[k + 1, 1] - y
            square = u * u + v * v
            if square > 0:
                t = min(1.0, max(0.0, ((xy[i, 0] - x) * u + (xy[i, 1] - y) * v) / square))
            d = (xy[i, 0] - x - t * u) ** 2 + (xy[i, 1] - y - t * v) ** 2
            if d < far[i]:
                far[i], at[i] = d, k + t


def way(path: tuple[float, ...] | None) -> tuple[Array, Array]:
    """Points (m, 2) mm and pressures (m,) of a path parameter. Raises ValueError for one that is none."""
    if not path or len(path) % 3 or len(path) > MOST:
        raise ValueError(f"path has {len(path or ())} numbers; it takes x, y and pressure of 1 to {MOST // 3} points")
    table = np.array(path, np.float64).reshape(-1, 3)
    if table[:, 2].min() < 0 or table[:, 2].max() > 1:
        raise ValueError("path has a pressure outside 0 to 1; every third number is one")
    return table[:, :2], table[:, 2]


def outline(path: tuple[float, ...] | None) -> shapely.Geometry:
    """The area inside a path drawn round it, mended where it crosses itself. Raises ValueError for one without area."""
    points, _ = way(path)
    ring = shapely.make_valid(shapely.Polygon(points)) if len(points) > 2 else shapely.Polygon()
    parts = [part for part in shapely.get_parts(ring) if part.geom_type == "Polygon" and part.area > 0]
    if not parts:
        raise ValueError("path encloses nothing; draw it around what is meant")
    return parts[0] if len(parts) == 1 else shapely.union_all(parts)


@dataclass(frozen=True, eq=False)
class Meant:
    """What an operation is to change: `on` says which items, of one layer or of all that may change; the brush, or None without one."""

    drawing: Drawing
    on: str
    brush: Brush | None
    strength: float
    layer: int | None

    def parts(self, *, frozen: bool = False) -> Iterator[tuple[Layer, Index, Array]]:
        """Each layer that may change with the rows of its items that are meant, frozen ones on request, and their weights over 0 to 1."""
        for found in self.drawing.free(self.layer):
            items = found.items
            if self.brush:
                rows, weight = self.brush.under(items.xy)
            else:
                rows = np.flatnonzero(items.selected) if self.on == "selection" else np.arange(len(items))
                weight = np.full(len(rows), self.strength)
            counts = (weight > 0) & (frozen | ~items.frozen[rows])
            yield found, rows[counts], weight[counts]

    def changed(self, change: Callable[[Layer, Index, Array], Items]) -> Drawing:
        """The drawing with what is meant changed, layer by layer; the same where nothing is."""
        by = {found.id: change(found, rows, weight) for found, rows, weight in self.parts() if len(rows)}
        return self.drawing.with_items(by) if by else self.drawing


def meant(
    drawing: Drawing,
    *,
    on: On = "brush",
    path: Path = None,
    size: Size = 5.0,
    strength: Strength = 1.0,
    falloff: Falloff = "smooth",
    layer: OfLayer = None,
) -> Meant:
    """What is under a brush, or selected, or all. Raises ValueError for a brush without a way."""
    return Meant(drawing, on, Brush.of(path, size, strength, falloff) if on == "brush" else None, strength, layer)
