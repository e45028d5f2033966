"""Objects: points, lines and outlines that are moved and turned as wholes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.inertia import crosses, drawn, fold_of, long_axis, of_sides, pooled
from crowquill.marks import THIN, Marks, columns, freeze_columns
from crowquill.moments import of_rings
from crowquill.paths import Array, Index, Paths

CORNER = np.radians(20)  # a sharper turn of an outline gets a sample
FLAT = 1e-3  # of the extent: what pieces of curves may stray
MOST = 20_000_000  # samples; their cells take some ten gigabytes


@dataclass(frozen=True, eq=False)
class Shape:
    """What an object looks like about its own centre of mass.

    paths  straight rings or straight lines, one or several, mm at scale 1, the centre at (0, 0); one point alone is a point
    axis   direction of the long axis, rad in (-pi/2, pi/2]
    fold   how often in a full turn it looks the same: 2 for a line, 4 for a square, 0 when it always does
    notes  what is to be said of how the outline was read
    """

    paths: Paths
    axis: float
    fold: int
    notes: tuple[str, ...] = ()

    @classmethod
    def of(cls, outline: Paths, fold: int | None = None) -> Shape:
        """The shape of an outline in mm, its centre brought to the origin.

        Rings weigh by their area, lines by their length. Of several rings the places inside an odd number count,
        and a ring that crosses itself is split where it does. Curves become straight pieces within a thousandth of
        the extent. The fold is found, unless given: turned, the outline comes within 2 % of itself; a point or a
        disc has 0. Where inertia knows no long axis, as in a square, it is the long side of the tightest box.
        Raises ValueError for an outline without points, length or area, or a negative fold.
        """
        return _read(outline, fold)[0]

    @property
    def is_point(self) -> bool:
        """Whether it is one point alone."""
        return len(self.paths.xy) == 1

    @cached_property
    def way(self) -> tuple[Array, Array, Array, Array]:
        """The outline by length, for samples: its points (m, 2), how far along each lies, and its pieces.

        A piece runs from corner to corner, given by where it starts and how long it is; the end of a line is a piece of length 0.
        """
        end = np.zeros(0 if self.paths.closed else 1)
        points, along, begin, length, far = [], [], [], [], 0.0
        for path in self.paths:
            xy = np.concatenate([path, path[:1]]) if self.paths.closed else path
            side = np.diff(xy, axis=0)
            at = far + np.concatenate([[0.0], np.cumsum(np.hypot(*side.T))])
            ahead = np.arctan2(side[:, 1], side[:, 0])
            bend = np.abs((np.diff(ahead) + np.pi) % (2 * np.pi) - np.pi)
            breaks = np.concatenate([at[:1], at[1:-1][bend > CORNER], at[-1:]])
            points.append(xy)
            along.append(at)
            begin.append(np.concatenate([breaks[:-1], at[-1] + end]))
            length.append(np.concatenate([np.diff(breaks), end]))
            far = at[-1] + 1.0  # a gap, so that no length means two places
        return np.concatenate(points), np.concatenate(along), np.concatenate(begin), np.concatenate(length)


@dataclass(frozen=True, eq=False)
class Objects:
    """Many placed shapes: xy (n, 2) mm of their centres, angle (n,) rad, scale (n,) over 0, shape (n,) index into `shapes`."""

    xy: Array
    angle: Array
    scale: Array
    shape: Index
    shapes: tuple[Shape, ...]

    def __post_init__(self) -> None:
        freeze_columns(self, "shape", len(self.shapes))
        if len(self.xy) and not self.scale.min() > 0:
            raise ValueError(f"scale {self.scale.min()} leaves nothing of an object; it takes numbers over 0")

    @classmethod
    def of(
        cls,
        xy: npt.ArrayLike,
        shapes: tuple[Shape, ...],
        *,
        angle: npt.ArrayLike = 0.0,
        scale: npt.ArrayLike = 1.0,
        shape: npt.ArrayLike = 0,
    ) -> Objects:
        """Objects with their centres at xy (n, 2); angle, scale and shape are one value for all or (n,)."""
        return cls(*columns(xy, angle, scale, shape), tuple(shapes))

    @classmethod
    def of_paths(cls, paths: Paths) -> Objects:
        """Every path an object where it lies, not turned and of scale 1; a path of one point is a point.

        Raises ValueError for a path without points, length or area.
        """
        found = []
        for i in range(len(paths)):
            try:
                found.append(_read(paths.take([i]), None))
            except ValueError as error:
                raise ValueError(f"path {i}: {error}") from None
        xy = np.array([centre for _, centre in found]).reshape(-1, 2)
        return cls.of(xy, tuple(shape for shape, _ in found), shape=np.arange(len(found)))

    @classmethod
    def of_marks(cls, marks: Marks) -> Objects:
        """The marks as objects with the same xy, angle, scale and index: shape k is glyph k."""
        return cls(marks.xy, marks.angle, marks.scale, marks.glyph, tuple(Shape.of(glyph.paths) for glyph in marks.glyphs))

    @classmethod
    def joined(cls, parts: Sequence[Objects]) -> Objects:
        """The objects of all parts in their order, each part with shapes of its own."""
        first = np.cumsum([0, *(len(part.shapes) for part in parts)])
        return cls(
            np.concatenate([np.empty((0, 2)), *(part.xy for part in parts)]),
            np.concatenate([np.empty(0), *(part.angle for part in parts)]),
            np.concatenate([np.empty(0), *(part.scale for part in parts)]),
            np.concatenate([np.empty(0, np.int64), *(part.shape + k for part, k in zip(parts, first, strict=False))]),
            tuple(shape for part in parts for shape in part.shapes),
        )

    def __len__(self) -> int:
        return len(self.xy)

    def take(self, which: npt.ArrayLike) -> Objects:
        """The objects at these indices or this mask."""
        chosen = np.arange(len(self))[np.asarray(which)]
        return Objects(self.xy[chosen], self.angle[chosen], self.scale[chosen], self.shape[chosen], self.shapes)

    @property
    def points(self) -> npt.NDArray[np.bool_]:
        """Which objects are single points, (n,)."""
        return np.array([shape.is_point for shape in self.shapes], bool)[self.shape]

    @property
    def notes(self) -> tuple[str, ...]:
        """What is to be said of the shapes in use, each thing once."""
        return tuple(dict.fromkeys(note for k in np.unique(self.shape) for note in self.shapes[k].notes))

    def placed(self, local: Array, owner: Index) -> Array:
        """Where points (k, 2) of objects owner (k,) lie; `local` are mm at the object's own scale, before its turn."""
        cos, sin = np.cos(self.angle)[owner], np.sin(self.angle)[owner]
        x, y = local.T
        return np.stack([cos * x - sin * y, sin * x + cos * y], axis=1) + self.xy[owner]

    def rings(self) -> tuple[Paths, Index]:
        """The closed outlines at their places, and the object that each is of."""
        return self._outlines(True)

    def lines(self) -> tuple[Paths, Index]:
        """The open outlines at their places, and the object that each is of; points are left out."""
        return self._outlines(False)

    def _outlines(self, closed: bool) -> tuple[Paths, Index]:
        parts = [shape.paths.take([]) if shape.is_point or shape.paths.closed != closed else shape.paths for shape in self.shapes]
        table = Paths.of([path for part in parts for path in part], closed=closed)
        count = np.array([len(part) for part in parts], np.int64)
        owner = np.repeat(np.arange(len(self)), count[self.shape])
        first = (np.cumsum(count) - count)[self.shape[owner]]
        begin = np.searchsorted(owner, np.arange(len(self)))[owner]
        local = table.take(first + np.arange(len(owner)) - begin)
        of = owner[local.path]
        return Paths(self.placed(local.xy * self.scale[of][:, None], of), local.start, closed), owner

    def axes(self) -> Paths:
        """Two segments an object, through its centre: its long axis, then that across, as long as it reaches along each."""
        reach = np.zeros((len(self.shapes), 2))
        for k, shape in enumerate(self.shapes):
            cos, sin = np.cos(shape.axis), np.sin(shape.axis)
            x, y = shape.paths.xy.T
            reach[k] = np.abs(cos * x + sin * y).max(), np.abs(cos * y - sin * x).max()
        return crosses(self.xy, self.angle + self.own_axes, reach[self.shape] * self.scale[:, None])

    @property
    def own_axes(self) -> Array:
        """The direction of each object's long axis before its turn, (n,) rad."""
        return np.array([shape.axis for shape in self.shapes], np.float64)[self.shape]

    @property
    def folds(self) -> Index:
        """How often in a full turn each object looks the same, (n,); 0 when it always does."""
        return np.array([shape.fold for shape in self.shapes], np.int64)[self.shape]

    def samples(self, most: float) -> tuple[Array, Index]:
        """Points along the outlines at most so many mm apart: (k, 2) before the turn, as `placed` takes them, and their objects, rising.

        Corners and ends are among them, and an outline has eight or more. Only what lies on outlines: the inside has none.
        Raises ValueError for a step that makes over twenty million.
        """
        local, owner, total = [], [], 0
        for k in np.unique(self.shape):
            which = np.flatnonzero(self.shape == k)
            points, along, begin, length = self.shapes[k].way
            if self.shapes[k].is_point:
                begin, length = np.zeros(1), np.zeros(1)
            step = np.minimum(most / self.scale[which], length.sum() / 8)[:, None]
            # rounding must not cut a piece of eight whole steps in nine
            parts = np.maximum(1, np.ceil(length / np.where(step > 0, step, 1.0) - 1e-9))
            total += parts.sum()
            if total > MOST:
                raise ValueError(f"a step of {most:g} mm makes over {MOST} samples; take a longer one")
            counts = parts.astype(np.int64).ravel()
            piece = np.repeat(np.tile(np.arange(len(length)), len(which)), counts)
            nth = np.arange(len(piece)) - np.repeat(np.cumsum(counts) - counts, counts)
            at = begin[piece] + length[piece] * nth / np.repeat(counts, counts)
            of = np.repeat(np.repeat(which, len(length)), counts)
            local.append(np.stack([np.interp(at, along, axis) for axis in points.T], axis=1) * self.scale[of][:, None])
            owner.append(of)
        owners = np.concatenate([np.empty(0, np.int64), *owner])
        order = np.argsort(owners, kind="stable")
        return np.concatenate([np.empty((0, 2)), *local])[order], owners[order]


def _read(outline: Paths, fold: int | None) -> tuple[Shape, Array]:
    """The shape of an outline, and where its centre of mass was."""
    if fold is not None and fold < 0:
        raise ValueError(f"fold is {fold}; it takes 0 for what looks always the same, or 1 and more")
    if not len(outline.xy):
        raise ValueError("an outline has no points; a point takes one")
    if len(outline.xy) == 1:
        return Shape(Paths.of([(0.0, 0.0)], closed=False), 0.0, 0), outline.xy[0]
    extent = float(np.ptp(outline.xy, axis=0).max())
    paths = outline.flat(FLAT * extent) if extent > 0 else outline
    notes: tuple[str, ...] = ()
    if paths.closed:
        paths, notes = _sound(paths)
        parts = of_rings(paths)
        if not parts.mass.sum() > THIN * extent**2:
            raise ValueError("a ring has no area; give it as an open line")
    else:
        parts = of_sides(paths)
        if not parts.mass.sum() > 0:
            raise ValueError("a line has no length; a point takes one point only")
    whole = pooled(parts, np.zeros(len(parts.mass), np.int64), 1, paths.xy[:1])
    centred = paths.moved(np.eye(2), -whole.centroid[0])
    lines = drawn(centred)
    axis = long_axis(lines, whole.covariance)
    return Shape(centred, axis, fold_of(lines, whole.covariance) if fold is None else fold, notes), whole.centroid[0]


def _sound(rings: Paths) -> tuple[Paths, tuple[str, ...]]:
    """Rings that do not cross, outer ones turning from x to y and holes back, and what is to be said."""
    polygons = rings.polygons()
    crossed = not shapely.is_valid(polygons).all()
    if len(rings) == 1 and not crossed:
        return (rings if rings.areas[0] >= 0 else Paths(rings.xy[::-1], rings.start)), ()
    parts = shapely.get_parts(reduce(shapely.symmetric_difference, shapely.make_valid(polygons)))
    found, _ = Paths.of_polygons(parts[shapely.get_type_id(parts) == shapely.GeometryType.POLYGON])
    return found, ("an outline crosses itself; it was split where it does",) if crossed else ()
