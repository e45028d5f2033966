"""Where a canvas lies on a grid of pixels: the share of each that is inside, and those that its outline touches."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.levels import Levels
from crowquill.paths import Array

TILE = 32  # pixels: the side of the pieces in which a canvas's outline is cut to pixels


def shares(canvas: shapely.Geometry, shape: tuple[int, int], pixel: tuple[float, float]) -> Levels:
    """The share of each of (h, w) pixels of this width and height in mm that lies in a canvas, exact; see Levels.filled."""
    (h, w), (dx, dy) = shape, pixel
    edge = touched(canvas, (0.0, 0.0), (dx, dy), (h, w))
    middle = np.arange(w) * dx + dx / 2
    shapely.contains_xy(canvas, 0.0, 0.0)  # what a prepared canvas makes at its first question is made before cores share it

    def rows(top: int, bottom: int) -> Array:
        low = np.arange(top, bottom) * dy
        share: Array = shapely.contains_xy(canvas, *np.meshgrid(middle, low + dy / 2)).astype(np.float64)
        row, column = np.nonzero(edge[top:bottom])
        if len(row):
            share[row, column] = _cut(canvas, row + top, column, pixel)
        return share

    return Levels.filled(shape, rows)


def _cut(canvas: shapely.Geometry, row: npt.NDArray[np.int64], column: npt.NDArray[np.int64], pixel: tuple[float, float]) -> Array:
    """The shares of these pixels, (n,). The canvas is cut into tiles first: an outline of thousands of corners would be walked for each."""
    dx, dy = pixel
    tile, tiles = np.unique(np.stack([row, column], axis=1) // TILE, axis=0, return_inverse=True)
    y, x = tile.T * TILE
    parts = shapely.intersection(shapely.box(x * dx, y * dy, (x + TILE) * dx, (y + TILE) * dy), canvas)
    boxes = shapely.box(column * dx, row * dy, column * dx + dx, row * dy + dy)
    return np.asarray(shapely.area(shapely.intersection(boxes, parts[tiles.ravel()])) / (dx * dy))


def touched(
    shape: shapely.Geometry, corner: tuple[float, float], step: tuple[float, float], grid: tuple[int, int]
) -> npt.NDArray[np.bool_]:
    """The squares of a grid (rows, columns) that the shape's outline may touch: none that it does touch is missing.

    Each piece of the outline shorter than half a square is marked at its ends, and so are all neighbours.
    """
    from scipy.ndimage import binary_dilation

    line = shapely.transform(shapely.boundary(shape), lambda xy: (xy - corner) / step)
    column, row = np.floor(shapely.get_coordinates(shapely.segmentize(line, 0.5))).astype(np.int64).T
    marks = np.zeros(grid, bool)
    marks[np.clip(row, 0, grid[0] - 1), np.clip(column, 0, grid[1] - 1)] = True
    return np.asarray(binary_dilation(marks, np.ones((3, 3), bool)))
