"""Direction fields, edges and distances of a picture, in millimetres: what marks turn by, and what rows of tiles follow.

Source: J. Canny, A Computational Approach to Edge Detection, IEEE PAMI 8(6), 1986; T. Lindeberg, Edge Detection and Ridge
Detection with Automatic Scale Selection, IJCV 30(2), 1998, for edges between pixels; A. Hausner, Simulating Decorative
Mosaics, SIGGRAPH 2001, for directions from distances.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import vector
from crowquill.paths import Array, Paths, frozen
from crowquill.tone import Tone

MOST = 40_000  # squares of a grid on which directions are eased: a second's work
FINE = 0.05  # of a pixel: how far an edge is simplified, as canvases are
FAINT = 0.01  # of the mean square gradient; texture below it has no direction to speak of

Complex = npt.NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Field:
    """A direction for each pixel of a rectangle, and how sure it is.

    angle     (h, w) rad, from x towards y
    strength  (h, w), 0 where there is no direction, to 1
    size      (width, height) mm
    fold      in how many turns a full one repeats a direction: 1 arrows, 2 lines, 4 crosses
    """

    angle: Array
    strength: Array
    size: tuple[float, float]
    fold: int = 2

    def __post_init__(self) -> None:
        angle = frozen(self.angle, np.float64, (None, None), "angle")
        strength = frozen(self.strength, np.float64, angle.shape, "strength")
        if not angle.size or not (strength.min() >= 0 and strength.max() <= 1 + 1e-9):
            raise ValueError(f"strength of shape {strength.shape} is no field's; it takes one pixel or more of 0 to 1")
        object.__setattr__(self, "angle", angle)
        object.__setattr__(self, "strength", np.minimum(strength, 1.0))
        self.strength.setflags(write=False)

    @classmethod
    def of(cls, waves: Complex, size: tuple[float, float], fold: int = 2) -> Field:
        """The field of numbers strength * e^(i fold angle), (h, w); longer ones count as 1."""
        return cls(np.angle(waves) / fold, np.minimum(np.abs(waves), 1.0), size, fold)

    @property
    def waves(self) -> Complex:
        """strength * e^(i fold angle), (h, w): what may be averaged, as angles may not."""
        return np.asarray(self.strength * np.exp(1j * self.fold * self.angle))

    def at(self, xy: npt.ArrayLike) -> tuple[Array, Array]:
        """Angle, 0 to a full turn over `fold`, and strength at points (n, 2) mm, each (n,).

        Between the pixels' centres waves run straight; beyond the outermost the nearest counts.
        """
        waves = self.waves
        found = between(waves.real, self.size, xy) + 1j * between(waves.imag, self.size, xy)
        return np.asarray(np.angle(found) / self.fold % (2 * np.pi / self.fold)), np.asarray(np.abs(found))

    def turned(self, angle: float) -> Field:
        """Every direction turned: by a quarter turn normals become tangents."""
        return replace(self, angle=self.angle + angle)

    def folded(self, fold: int) -> Field:
        """The same directions, alike after fewer or more parts of a turn: lines as crosses, so that x is as good as y."""
        return replace(self, fold=fold)

    def eased(self, length: float) -> Field:
        """Directions smoothed over `length` mm where strength is 1, further where it is less; those of none come from around.

        The waves u that least change and least differ from the field's own d: the sum of strength |u - d|^2 +
        length^2 |grad u|^2 is least, on a grid of 40 000 squares at most, which the result is on. In fold 4
        this leads directions across medial axes and into corners. Where there is no strength at all, none comes back.
        """
        from scipy.sparse import diags_array, kron
        from scipy.sparse.linalg import splu

        if not 0 < length < np.inf:
            raise ValueError(f"length is {length} mm; it takes a length over 0")
        k = max(1.0, float(np.sqrt(self.angle.size / MOST)))
        (h, w), (width, height) = (max(1, min(MOST, int(side / k))) for side in self.angle.shape), self.size
        weight, real, imaginary = _coarser((h, w), self.strength, self.waves.real, self.waves.imag)
        across = kron(diags_array(np.ones(h)), _second(w) * (length * w / width) ** 2)
        down = kron(_second(h) * (length * h / height) ** 2, diags_array(np.ones(w)))
        system = splu((diags_array(weight.ravel() + 1e-9) + across + down).tocsc())
        found = system.solve(np.stack([real.ravel(), imaginary.ravel()], axis=1))
        return Field.of((found[:, 0] + 1j * found[:, 1]).reshape(h, w), self.size, self.fold)


@dataclass(frozen=True, eq=False)
class Distances:
    """How far the centre of each pixel of a rectangle is from the nearest line: mm (h, w), on a size (width, height) mm."""

    mm: Array
    size: tuple[float, float]

    def __post_init__(self) -> None:
        object.__setattr__(self, "mm", frozen(self.mm, np.float64, (None, None), "mm"))

    def at(self, xy: npt.ArrayLike) -> Array:
        """The distance at points (n, 2) mm, straight between the pixels' centres, (n,)."""
        return between(self.mm, self.size, xy)

    def field(self, reach: float | None = None, fold: int = 2) -> Field:
        """The directions in which distance grows: straight away from the nearest line.

        Strength is the slope, 1 but where two lines are as near; with a reach in mm it falls off with the distance d
        as e^-(d / reach)^2, so that what is near a line holds and `eased` leads the rest.
        """
        h, w = self.mm.shape
        slope = [
            np.gradient(self.mm, side / count, axis=k) if count > 1 else np.zeros((h, w))
            for k, side, count in ((1, self.size[0], w), (0, self.size[1], h))
        ]
        fall = 1.0 if reach is None else np.exp(-((self.mm / reach) ** 2))
        return Field(np.arctan2(slope[1], slope[0]), np.minimum(np.hypot(*slope), 1.0) * fall, self.size, fold)


def between(values: Array, size: tuple[float, float], xy: npt.ArrayLike) -> Array:
    """Values (h, w) at the centres of pixels on a size in mm, straight between them, at points (n, 2)."""
    from scipy.ndimage import map_coordinates

    place = np.asarray(xy, np.float64).reshape(-1, 2).T[::-1] * (np.array(values.shape) / size[::-1])[:, None] - 0.5
    return np.asarray(map_coordinates(values, place, order=1, mode="nearest"), np.float64)


def along(tone: Tone, sigma: float) -> Field:
    """The directions along which a tone changes least, over a sigma of so many mm: those of stripes, hair and edges.

    On a grid of half a sigma, or the tone's own where that is coarser. Strength is the coherence, 1 where all gradients around
    are parallel, and falls to 0 where there are next to none.
    Source: J. Bigun, G. Granlund, Optimal Orientation Detection of Linear Symmetry, ICCV 1987.
    """
    from scipy.ndimage import gaussian_filter

    gx, gy = (_derived(tone, max(tone.pixel), *order) for order in ((1, 0), (0, 1)))
    h, w = tone.coverage.shape
    grid = min(h, int(np.ceil(2 * tone.size[1] / sigma))), min(w, int(np.ceil(2 * tone.size[0] / sigma)))
    wide = [sigma * count / side for count, side in zip(grid, reversed(tone.size), strict=True)]
    means = _coarser(grid, gx * gx, gx * gy, gy * gy)
    xx, xy, yy = (gaussian_filter(term, wide, mode="nearest") for term in means)
    energy = xx + yy
    least = max(FAINT * float(energy.mean()), np.finfo(float).tiny)
    strength = np.hypot(xx - yy, 2 * xy) / (energy + least)
    return Field(np.arctan2(2 * xy, xx - yy) / 2 + np.pi / 2, strength, tone.size)


def strokes(data: bytes, name: str, size: tuple[float, float]) -> Field:
    """The directions of the lines drawn in an SVG file, its page laid over a rectangle of this size in mm, and led from there
    to all other places.

    Raises ValueError for a file without lines or without a page.
    """
    page, found = vector.shapes(data, name)
    fine = 1e-4 * max(page)
    parts = [_sides(paths.flat(fine)) for paths, _ in found] if fine else []
    ends = np.concatenate([np.empty((0, 2, 2)), *parts]) * (np.array(size) / page if min(page) > 0 else 0)
    way = ends[:, 1] - ends[:, 0]
    length = np.hypot(*way.T)
    h, w = grid = _grid(size)
    step = min(size[0] / w, size[1] / h) / 2
    if not length.sum() > 0:
        raise ValueError(f"{name}: has no lines to take directions from; draw strokes on a page the shape of the picture")
    count = np.ceil(length / step).astype(np.int64)
    side = np.repeat(np.arange(len(ends)), count)
    part = (np.arange(len(side)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[side]
    place = ends[side, 0] + part[:, None] * way[side]
    column, row = np.floor(place / size * (w, h)).astype(np.int64).T
    seen = (column >= 0) & (column < w) & (row >= 0) & (row < h)
    waves = np.zeros(grid, np.complex128)
    wave = (length / np.maximum(count, 1) / (2 * step) * np.exp(2j * np.arctan2(way[:, 1], way[:, 0])))[side]
    np.add.at(waves, (row[seen], column[seen]), wave[seen])
    return Field.of(waves, size).eased(2 * step)


def edges(tone: Tone, sigma: float, *, low: float = 0.05, high: float = 0.15, least: float = 0.0) -> Paths:
    """Edges of a tone seen through a blur of sigma mm, as open lines between the pixels, those that close ending where they begin.

    low, high  an edge is where the tone changes as a step of coverage `low` would, if somewhere it does as one of `high`
    least      mm; shorter ones are left out

    On an edge the gradient is greatest along its own direction: its second derivative there is 0 and its third
    negative. Blur draws an edge of radius r in by about sigma^2 / 2r.
    """
    from contourpy import contour_generator

    one = {(i, j): _derived(tone, sigma, i, j) for i in range(4) for j in range(4 - i) if i + j}
    x, y = one[1, 0], one[0, 1]
    step = np.hypot(x, y) * sigma * np.sqrt(2 * np.pi)  # the step that would have such a gradient at its middle
    second = x * x * one[2, 0] + 2 * x * y * one[1, 1] + y * y * one[0, 2]
    third = x**3 * one[3, 0] + 3 * x * x * y * one[2, 1] + 3 * x * y * y * one[1, 2] + y**3 * one[0, 3]
    h, w = step.shape
    if min(h, w) < 2:
        return Paths.of([], closed=False)
    at = [(np.arange(count) + 0.5) * side for count, side in zip((w, h), tone.pixel, strict=True)]
    lines: Any = contour_generator(x=at[0], y=at[1], z=np.ma.array(second, mask=(step < low) | (third >= 0))).lines(0.0)
    kept = []
    for line in lines:
        if len(line) > 1 and between(step, tone.size, line).max() >= high:
            whole = shapely.simplify(shapely.LineString(line), FINE * min(tone.pixel))
            if whole.length > 0 and whole.length >= least:
                kept.append(shapely.get_coordinates(whole))
    return Paths.of(kept, closed=False)


def distances(lines: Paths, size: tuple[float, float], grid: tuple[int, int] | None = None) -> Distances:
    """How far each square's centre is from the nearest of some lines, exact for straight ones; curves are made straight to 1e-4
    of the size.

    grid  (h, w) of squares on a size in mm; left out, 40 000 in the shape of the size

    The outline of a canvas is `Paths.of_polygons(tone.canvas)[0]`. Where there are no lines all is as far as the rectangle
    is across.
    """
    h, w = _grid(size) if grid is None else grid
    ends = _sides(lines.flat(1e-4 * max(size)))
    if not len(ends):
        return Distances(np.full((h, w), np.hypot(*size)), size)
    x, y = np.meshgrid((np.arange(w) + 0.5) * size[0] / w, (np.arange(h) + 0.5) * size[1] / h)
    tree = shapely.STRtree(shapely.linestrings(ends))
    (point, _), far = tree.query_nearest(shapely.points(x.ravel(), y.ravel()), return_distance=True, all_matches=False)
    mm = np.empty(h * w)
    mm[point] = far
    return Distances(mm.reshape(h, w), size)


def _derived(tone: Tone, sigma: float, i: int, j: int) -> Array:
    """The i-th derivative along x and j-th along y of a tone blurred by sigma mm, per mm."""
    from scipy.ndimage import gaussian_filter

    dx, dy = tone.pixel
    blurred = gaussian_filter(tone.coverage, (sigma / dy, sigma / dx), order=(j, i), mode="nearest")
    return np.asarray(blurred / (dx**i * dy**j))


def _sides(paths: Paths) -> Array:
    """The straight sides of paths from end to end, (n, 2, 2); a ring's last leads back."""
    rings = [np.concatenate([path, path[:1]]) if paths.closed else path for path in paths if len(path)]
    return np.concatenate([np.empty((0, 2, 2)), *(np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings)])


def _grid(size: tuple[float, float]) -> tuple[int, int]:
    """Rows and columns of nearly square pixels, MOST at most, on a size in mm."""
    width, height = size
    pitch = np.sqrt(width * height / MOST)
    return max(1, min(MOST, int(height / pitch))), max(1, min(MOST, int(width / pitch)))


def _coarser(grid: tuple[int, int], *values: Array) -> list[Array]:
    """Means of values (h, w) over the squares of a grid that has no more rows and columns; whole pixels go to one square each."""
    (h, w), (rows, columns) = values[0].shape, grid
    if (h, w) == (rows, columns):
        return list(values)
    square = ((np.arange(h) * rows // h)[:, None] * columns + np.arange(w) * columns // w).ravel()
    count = np.bincount(square, minlength=rows * columns)
    return [(np.bincount(square, part.ravel(), rows * columns) / count).reshape(rows, columns) for part in values]


def _second(n: int) -> Any:
    """Minus the second difference of n values in a row, whose ends are free: (n, n)."""
    from scipy.sparse import diags_array

    whole = np.full(n, 2.0)
    whole[[0, -1]] -= 1
    return diags_array([whole, np.full(n - 1, -1.0), np.full(n - 1, -1.0)], offsets=[0, 1, -1]) if n > 1 else diags_array([0.0])
