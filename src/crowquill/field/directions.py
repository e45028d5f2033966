"""Directions: a field of them, smoothed and led on; those of a picture's stripes, and of strokes drawn for the purpose."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill import vector
from crowquill.field.grids import MOST, between, coarse, coarser, derived, sides
from crowquill.paths import Array, frozen
from crowquill.tone import Tone

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
        weight, real, imaginary = coarser((h, w), self.strength, self.waves.real, self.waves.imag)
        across = kron(diags_array(np.ones(h)), _second(w) * (length * w / width) ** 2)
        down = kron(_second(h) * (length * h / height) ** 2, diags_array(np.ones(w)))
        system = splu((diags_array(weight.ravel() + 1e-9) + across + down).tocsc())
        found = system.solve(np.stack([real.ravel(), imaginary.ravel()], axis=1))
        return Field.of((found[:, 0] + 1j * found[:, 1]).reshape(h, w), self.size, self.fold)


def along(tone: Tone, sigma: float) -> Field:
    """The directions along which a tone changes least, over a sigma of so many mm: those of stripes, hair and edges.

    On a grid of half a sigma, or the tone's own where that is coarser. Strength is the coherence, 1 where all gradients around
    are parallel, and falls to 0 where there are next to none.
    Source: J. Bigun, G. Granlund, Optimal Orientation Detection of Linear Symmetry, ICCV 1987.
    """
    from scipy.ndimage import gaussian_filter

    gx, gy = (derived(tone, max(tone.pixel), *order) for order in ((1, 0), (0, 1)))
    h, w = tone.coverage.shape
    grid = min(h, int(np.ceil(2 * tone.size[1] / sigma))), min(w, int(np.ceil(2 * tone.size[0] / sigma)))
    wide = [sigma * count / side for count, side in zip(grid, reversed(tone.size), strict=True)]
    means = coarser(grid, gx * gx, gx * gy, gy * gy)
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
    parts = [sides(paths.flat(fine)) for paths, _ in found] if fine else []
    ends = np.concatenate([np.empty((0, 2, 2)), *parts]) * (np.array(size) / page if min(page) > 0 else 0)
    way = ends[:, 1] - ends[:, 0]
    length = np.hypot(*way.T)
    h, w = grid = coarse(size)
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


def _second(n: int) -> Any:
    """Minus the second difference of n values in a row, whose ends are free: (n, n)."""
    from scipy.sparse import diags_array

    whole = np.full(n, 2.0)
    whole[[0, -1]] -= 1
    return diags_array([whole, np.full(n - 1, -1.0), np.full(n - 1, -1.0)], offsets=[0, 1, -1]) if n > 1 else diags_array([0.0])
