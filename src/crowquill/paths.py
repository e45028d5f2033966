"""Paths: many rings or lines in one pair of arrays, straight or cubic.

Cells, outlines of dots, strokes and canvases are all Paths. Shapely is met here and in `cells` only.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.kernel import compiled

Array = npt.NDArray[np.float64]
Index = npt.NDArray[np.int64]

# Gauss-Legendre with 6 points is exact to degree 11, which second moments of cubic outlines have.
_GAUSS = np.polynomial.legendre.leggauss(6)


def frozen(values: npt.ArrayLike, dtype: Any, shape: tuple[int | None, ...], name: str) -> npt.NDArray[Any]:
    """A read-only, finite copy of `values` in the dtype and shape named (None: any length); ValueError otherwise.

    An array that is read-only and has memory of its own is taken as it is.
    """
    own = isinstance(values, np.ndarray) and values.base is None and not values.flags.writeable and values.flags.c_contiguous
    array = np.array(values, dtype=dtype, copy=None if own else True)
    if array.ndim != len(shape) or any(want not in (None, have) for want, have in zip(shape, array.shape, strict=False)):
        want = " by ".join("n" if side is None else str(side) for side in shape)
        raise ValueError(f"{name} has shape {array.shape}; it takes {want}")
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise ValueError(f"{name} has a value that is not finite; it takes numbers only")
    array.setflags(write=False)
    return array


def fixed(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """An array that nobody else has, read-only from now on, so that frozen() need not copy it; what shows another's memory stays."""
    if values.base is None:
        values.setflags(write=False)
    return values


@dataclass(frozen=True, eq=False)
class Paths:
    """Many paths as one array of points and the index where each starts.

    xy      (m, 2) mm
    start   (n + 1,) rising from 0 to m; equal neighbours are an empty path
    closed  rings, whose first point is not repeated, or open lines
    cubic   anchor, control, control, anchor, ...: 3k points a ring, 3k + 1 a line; straight otherwise
    """

    xy: Array
    start: Index
    closed: bool = True
    cubic: bool = False

    def __post_init__(self) -> None:
        xy = frozen(self.xy, np.float64, (None, 2), "xy")
        start = frozen(self.start, np.int64, (None,), "start")
        counts = np.diff(start)
        if start.size == 0 or start[0] != 0 or start[-1] != len(xy) or (counts < 0).any():
            raise ValueError(f"start must rise from 0 to {len(xy)}, the number of points")
        if self.cubic and (counts[counts > 0] % 3 != (0 if self.closed else 1)).any():
            raise ValueError(f"a cubic {'ring' if self.closed else 'line'} has {'3k' if self.closed else '3k + 1'} points")
        object.__setattr__(self, "xy", xy)
        object.__setattr__(self, "start", start)

    @classmethod
    def of(cls, paths: Iterable[npt.ArrayLike], *, closed: bool = True, cubic: bool = False) -> Paths:
        """Paths from a list of point lists.

        >>> len(Paths.of([[(0, 0), (1, 0), (0, 1)]]))
        1
        """
        parts = [np.asarray(path, np.float64).reshape(-1, 2) for path in paths]
        start = np.cumsum([0, *map(len, parts)])
        return cls(np.concatenate([np.empty((0, 2)), *parts]), start, closed, cubic)

    @classmethod
    def of_polygons(cls, polygons: npt.ArrayLike) -> tuple[Paths, Index]:
        """The rings of shapely (Multi)Polygons and the polygon each is of: outer rings turn from x to y, holes the other way."""
        parts, whole = shapely.get_parts(shapely.orient_polygons(polygons), return_index=True)
        rings, part = shapely.get_rings(parts, return_index=True)
        xy, ring = shapely.get_coordinates(rings, return_index=True)
        last = np.append(ring[1:] != ring[:-1], True)[: len(ring)]  # shapely repeats the first point of a ring
        start = np.concatenate([[0], np.cumsum(np.bincount(ring[~last], minlength=len(rings)))])
        return cls(xy[~last], start), np.asarray(whole[part], np.int64)

    def __len__(self) -> int:
        return len(self.start) - 1

    def __getitem__(self, i: int) -> Array:
        """The points of path i, (k, 2)."""
        i = range(len(self))[i]
        return self.xy[self.start[i] : self.start[i + 1]]

    def __iter__(self) -> Iterator[Array]:
        return (self[i] for i in range(len(self)))

    @property
    def path(self) -> Index:
        """The path each point belongs to, (m,)."""
        return np.repeat(np.arange(len(self)), np.diff(self.start))

    def take(self, which: npt.ArrayLike) -> Paths:
        """The paths at these indices, in this order."""
        which = np.arange(len(self))[np.asarray(which, np.int64)]
        counts = np.diff(self.start)[which]
        start = np.concatenate([[0], np.cumsum(counts)])
        points = np.repeat(self.start[which] - start[:-1], counts) + np.arange(start[-1])
        return Paths(self.xy[points], start, self.closed, self.cubic)

    def moved(self, matrix: npt.ArrayLike, offset: npt.ArrayLike = (0, 0)) -> Paths:
        """Every point p as matrix @ p + offset; matrix (2, 2), offset (2,) mm."""
        (a, b), (c, d) = np.asarray(matrix, np.float64)
        x, y = self.xy.T
        # written out: a matrix product rounds differently with the number of rows
        xy = np.stack([a * x + b * y, c * x + d * y], axis=1) + np.asarray(offset, np.float64)
        return Paths(xy, self.start, self.closed, self.cubic)

    def flat(self, tolerance: float) -> Paths:
        """The same paths in straight pieces, nowhere further than `tolerance` mm from the curve.

        Straight paths come back as they are. A cubic in k even steps strays at most an
        eighth of its greatest second derivative over k^2, which is 6 times a second difference of its points.
        """
        if not 0 < tolerance < np.inf:
            raise ValueError(f"tolerance is {tolerance} mm; it takes a length over 0")
        if not self.cubic:
            return self
        a, b, c, d, path = self._curves()
        bend = np.maximum(np.hypot(*(a - 2 * b + c).T), np.hypot(*(b - 2 * c + d).T))
        steps = np.maximum(1, np.ceil(np.sqrt(6 / 8 * bend / tolerance))).astype(np.int64)
        curve = np.repeat(np.arange(len(steps)), steps)
        first = np.cumsum(steps) - steps
        t = ((np.arange(len(curve)) - first[curve]) / steps[curve])[:, None]
        s = 1 - t
        xy = s**3 * a[curve] + 3 * s * s * t * b[curve] + 3 * s * t * t * c[curve] + t**3 * d[curve]
        counts = np.bincount(path, steps, len(self)).astype(np.int64)
        if not self.closed:  # the last anchor of each line has no curve of its own
            filled = np.flatnonzero(np.diff(self.start))
            ends = np.cumsum(counts)[filled]
            xy = np.insert(xy, ends, self.xy[self.start[filled + 1] - 1], axis=0)
            counts[filled] += 1
        return Paths(xy, np.concatenate([[0], np.cumsum(counts)]), self.closed)

    def curved(self) -> Paths:
        """The same closed paths as cubics; straight sides become cubics along the same line."""
        if self.cubic or not self.closed:
            return self
        a, b, c, _, _ = self._curves()
        return Paths(np.stack([a, b, c], axis=1).reshape(-1, 2), self.start * 3, True, True)

    def green(self) -> Array:
        """The integrals of 1, x, y, xx, xy, yy inside each closed path, about its own first point: (n, 6).

        Exact for straight sides and for cubics: by Green's theorem each is an integral
        along the outline. About a far origin the digits cancel. An empty path gives zeros.
        """
        if not self.cubic:
            return self._green_straight()
        a, b, c, d, path = self._curves()
        origin = a[np.searchsorted(path, path)]
        a, b, c, d = a - origin, b - origin, c - origin, d - origin
        sums = np.zeros((len(self), 6))
        for node, weight in zip(*_GAUSS, strict=True):
            t, s, w = (1 + node) / 2, (1 - node) / 2, weight / 2
            x, y = (s**3 * a + 3 * s * s * t * b + 3 * s * t * t * c + t**3 * d).T
            dy = (3 * s * s * (b - a) + 6 * s * t * (c - b) + 3 * t * t * (d - c))[:, 1] * w
            for k, term in enumerate((x, x * x / 2, x * y, x * x * x / 3, x * x * y / 2, x * y * y)):
                sums[:, k] += np.bincount(path, term * dy, len(self))
        return sums

    def _green_straight(self) -> Array:
        a, _, _, b, path = self._curves()
        origin = a[np.searchsorted(path, path)]
        (u, v), (x, y) = (a - origin).T, (b - origin).T
        cross = u * y - x * v
        terms = (
            cross / 2,
            (u + x) * cross / 6,
            (v + y) * cross / 6,
            (u * u + u * x + x * x) * cross / 12,
            (2 * u * v + u * y + x * v + 2 * x * y) * cross / 24,
            (v * v + v * y + y * y) * cross / 12,
        )
        return np.stack([np.bincount(path, term, len(self)).astype(np.float64) for term in terms], axis=1)

    @property
    def areas(self) -> Array:
        """The area of each closed path, (n,) mm^2: positive when x turns towards y."""
        if self.cubic:
            return self.green()[:, 0]
        areas = np.zeros(len(self))
        _areas(self.xy, self.start, areas)
        return areas

    def polygons(self) -> npt.NDArray[np.object_]:
        """Each ring as a shapely Polygon, (n,); rings of fewer than 3 points are empty Polygons."""
        sound = np.diff(self.start) >= 3
        polygons = np.full(len(self), shapely.Polygon(), dtype=object)
        if sound.any():
            kept = self.take(np.flatnonzero(sound))
            polygons[sound] = shapely.polygons(shapely.linearrings(kept.xy, indices=kept.path))
        return polygons

    def _curves(self) -> tuple[Array, Array, Array, Array, Index]:
        """Each side as a cubic (a, b, c, d) and its path; straight sides are thirds of themselves."""
        step = 3 if self.cubic else 1
        last = self.start[1:] - 1
        at = np.arange(len(self.xy))
        path = self.path
        anchor = (at - self.start[path]) % step == 0 if len(at) else np.zeros(0, bool)
        if not self.closed:
            anchor = anchor & (at != last[path])
        i, path = at[anchor], path[anchor]

        def after(k: int) -> Array:
            j = i + k
            found: Array = self.xy[np.where(j > last[path], self.start[path], j)]
            return found

        a, d = self.xy[i], after(step)
        if self.cubic:
            return a, self.xy[i + 1], self.xy[i + 2], d, path
        return a, a + (d - a) / 3, d - (d - a) / 3, d, path


@compiled
def _areas(xy: Array, start: Index, areas: Array) -> None:
    """Fills the area of each ring of straight sides, summed about its first point."""
    for ring in range(len(start) - 1):
        begin, end = start[ring], start[ring + 1]
        for k in range(begin + 1, end - 1):
            u, v = xy[k, 0] - xy[begin, 0], xy[k, 1] - xy[begin, 1]
            x, y = xy[k + 1, 0] - xy[begin, 0], xy[k + 1, 1] - xy[begin, 1]
            areas[ring] += (u * y - x * v) / 2
