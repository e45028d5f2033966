"""Tesserae: what the stones of a mosaic are laid on, how they are turned there and how large they are.

Source: A. Hausner, Simulating Decorative Mosaics, SIGGRAPH 2001, for directions and sizes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.field import Distances, Field, between, distances, weighed
from crowquill.paths import Array, Index, Paths
from crowquill.tiles import Stones, rings_of, squares
from crowquill.tone import Tone

FINE = 12  # squares of the grid to the side of a tile; with 7 centroids stick to them, and a third fewer tiles find their lattice
MOST = 6_000_000  # squares of the grid
REACH = 4.0  # tiles from a line within which its direction holds
APART = 0.6  # tiles; of two that begin nearer one goes
HOLLOW = 0.27  # tiles: as far from any stone is room for another


@dataclass(frozen=True, eq=False)
class Tiles:
    """Where tiles lie: centres (n, 2) mm, and the angle (n,) rad of the first of each one's sides (n, 2) mm."""

    xy: Array
    angle: Array
    sides: Array

    def __len__(self) -> int:
        return len(self.xy)

    def stones(self, grow: float = 1.0) -> Stones:
        """The tiles as polygons, as many times as large as `grow` says."""
        return squares(self.xy, self.angle, self.sides * grow)


@dataclass(frozen=True, eq=False)
class Ground:
    """What tiles are laid on.

    canvas   shapely, mm, on a rectangle of `size`
    lines    edges that tiles follow and do not cross; the canvas's outline is followed too
    pitch    (2,) mm from tile to tile along its sides, grout and all, where tiles are as large as they get by themselves
    gap      mm of grout
    wish     (h, w) how much finer tiles are wished for, or None
    """

    canvas: shapely.Geometry
    size: tuple[float, float]
    lines: Paths
    pitch: Array
    gap: float
    wish: Array | None = None

    @property
    def mean(self) -> float:
        """The pitch of a square tile of the same area, mm."""
        return float(np.sqrt(np.prod(self.pitch)))

    @property
    def finest(self) -> float:
        """The greatest wish."""
        return 1.0 if self.wish is None else float(self.wish.max())

    @cached_property
    def grid(self) -> tuple[int, int]:
        """Rows and columns of squares fine enough for the smallest tiles."""
        width, height = self.size
        fine = max(float(self.pitch.min()) / self.finest / FINE, float(np.sqrt(width * height / MOST)))
        return max(2, int(np.ceil(height / fine))), max(2, int(np.ceil(width / fine)))

    @property
    def pixel(self) -> tuple[float, float]:
        """Width and height of a square of the grid, mm."""
        return self.size[0] / self.grid[1], self.size[1] / self.grid[0]

    @cached_property
    def places(self) -> tuple[Array, Array]:
        """x of the columns' and y of the rows' middles, mm."""
        (h, w), (dx, dy) = self.grid, self.pixel
        return np.asarray((np.arange(w) + 0.5) * dx, np.float64), np.asarray((np.arange(h) + 0.5) * dy, np.float64)

    @cached_property
    def inside(self) -> npt.NDArray[np.bool_]:
        """Which squares have their middle on the canvas."""
        x, y = np.meshgrid(*self.places)
        return np.asarray(shapely.contains_xy(self.canvas, x, y))

    @cached_property
    def finer(self) -> Array:
        """The wish on the grid, (h, w)."""
        x, y = np.meshgrid(*self.places)
        return self.wished(np.stack([x.ravel(), y.ravel()], axis=1)).reshape(self.grid)

    @cached_property
    def edges(self) -> Distances:
        """How far each square is from the lines."""
        return distances(self.lines, self.size, self.grid)

    @cached_property
    def far(self) -> Distances:
        """How far each square is from the lines and the canvas's outline."""
        rim = Paths.of_polygons(shapely.simplify(self.canvas, self.mean / 50))[0]
        return weighed([(self.edges, 1.0), (distances(rim, self.size, self.grid), 1.0)])

    @cached_property
    def field(self) -> Field:
        """The direction of the first side of a tile: along the nearest line; of square tiles the other side is as good."""
        fold = 4 if self.pitch[0] == self.pitch[1] else 2
        away = self.far.field(REACH * self.mean, fold).eased(0.5 * self.mean)
        return away.turned(np.pi / 2)

    def angles(self, xy: Array) -> Array:
        """The direction at places (n, 2), rad."""
        return self.field.at(xy)[0] if len(xy) else np.zeros(0)

    def wished(self, xy: Array) -> Array:
        """How much finer than by themselves tiles are to be at places (n, 2)."""
        return np.ones(len(xy)) if self.wish is None else between(self.wish, self.size, xy)

    def sides(self, xy: Array) -> Array:
        """The sides (n, 2) mm of tiles at places (n, 2)."""
        return np.maximum(self.pitch / self.wished(xy)[:, None] - self.gap, 0.05 * self.pitch)

    def tiles(self, xy: Array) -> Tiles:
        """Tiles at places (n, 2)."""
        return Tiles(xy, self.angles(xy), self.sides(xy))

    def crowd(self, tone: Tone) -> tuple[Tone, int]:
        """Where tiles go, as a tone over its densest, and how many the canvas takes."""
        wish = np.ones_like(tone.coverage) if self.wish is None else self.wish
        demand = Tone((wish / self.finest) ** 2, tone.size, tone.canvas)
        return demand, max(1, round(demand.ink * self.finest**2 / float(np.prod(self.pitch))))


@dataclass(frozen=True)
class Progress:
    """Tiles after `done` steps; energy in mm^4; how far they moved on the mean, in tiles. `cells` are stones that are no rectangles."""

    done: int
    tiles: Tiles
    energy: float = 0.0
    movement: float = 0.0
    cells: Stones | None = None


def hollows(ground: Ground, stones: Stones) -> Array:
    """Places (k, 2) mm in the middle of hollows between stones and edges where there is room for more."""
    from scipy.ndimage import distance_transform_edt, maximum_filter

    from crowquill.raster import covered

    (dx, dy), x, y = ground.pixel, *ground.places
    room = ground.inside & (ground.edges.mm > ground.gap / 2)
    room &= covered(rings_of(stones), ground.grid, pixel=ground.pixel, lines=4) < 0.5
    deep = distance_transform_edt(np.pad(room, 1), sampling=(dy, dx))[1:-1, 1:-1] * ground.finer
    near = 2 * max(1, round(APART * ground.mean / ground.finest / max(dx, dy) / 2)) + 1
    row, column = np.nonzero((deep > HOLLOW * ground.mean) & (deep == maximum_filter(deep, near)))
    order = np.argsort(-deep[row, column], kind="stable")
    xy = np.stack([x[column[order]], y[row[order]]], axis=1)
    return xy[spaced(xy, APART * ground.mean / ground.wished(xy))]


def spaced(xy: Array, least: Array) -> Index:
    """The places (n, 2) that stay when each that is nearer than its least distance (n,) to an earlier one goes."""
    from scipy.spatial import cKDTree

    stay = np.ones(len(xy), bool)
    if len(xy):
        pairs = np.sort(cKDTree(xy).query_pairs(float(least.max()), output_type="ndarray"), axis=1)
        near = np.hypot(*(xy[pairs[:, 0]] - xy[pairs[:, 1]]).T) < least[pairs[:, 1]]
        pairs = pairs[near]
        for i, j in pairs[np.lexsort((pairs[:, 0], pairs[:, 1]))].tolist():
            stay[j] &= not stay[i]
    return np.flatnonzero(stay)
