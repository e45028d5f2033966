"""Values on pixels, and pixels on millimetres: what directions, edges and distances are all taken from."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from crowquill.paths import Array, Paths
from crowquill.tone import Tone

MOST = 40_000  # squares of a grid on which directions are eased: a second's work


def between(values: Array, size: tuple[float, float], xy: npt.ArrayLike) -> Array:
    """Values (h, w) at the centres of pixels on a size in mm, straight between them, at points (n, 2)."""
    from scipy.ndimage import map_coordinates

    place = np.asarray(xy, np.float64).reshape(-1, 2).T[::-1] * (np.array(values.shape) / size[::-1])[:, None] - 0.5
    return np.asarray(map_coordinates(values, place, order=1, mode="nearest"), np.float64)


def derived(tone: Tone, sigma: float, i: int, j: int) -> Array:
    """The i-th derivative along x and j-th along y of a tone blurred by sigma mm, per mm."""
    from scipy.ndimage import gaussian_filter

    dx, dy = tone.pixel
    blurred = gaussian_filter(tone.coverage, (sigma / dy, sigma / dx), order=(j, i), mode="nearest")
    return np.asarray(blurred / (dx**i * dy**j))


def sides(paths: Paths) -> Array:
    """The straight sides of paths from end to end, (n, 2, 2); a ring's last leads back."""
    rings = [np.concatenate([path, path[:1]]) if paths.closed else path for path in paths if len(path)]
    return np.concatenate([np.empty((0, 2, 2)), *(np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings)])


def coarse(size: tuple[float, float]) -> tuple[int, int]:
    """Rows and columns of nearly square pixels, MOST at most, on a size in mm."""
    width, height = size
    pitch = np.sqrt(width * height / MOST)
    return max(1, min(MOST, int(height / pitch))), max(1, min(MOST, int(width / pitch)))


def coarser(grid: tuple[int, int], *values: Array) -> list[Array]:
    """Means of values (h, w) over the squares of a grid that has no more rows and columns; whole pixels go to one square each."""
    (h, w), (rows, columns) = values[0].shape, grid
    if (h, w) == (rows, columns):
        return list(values)
    square = ((np.arange(h) * rows // h)[:, None] * columns + np.arange(w) * columns // w).ravel()
    count = np.bincount(square, minlength=rows * columns)
    return [(np.bincount(square, part.ravel(), rows * columns) / count).reshape(rows, columns) for part in values]
