"""Screens: rulings, the tone that lies under them, and the shapes that waves of a lattice cut out of it.

A wave rises from 0 in the middle of each dot to 1 where ink comes last; ink is where the wave is below a level, and each
coverage has its level. Source: R. Ulichney, Digital Halftoning, MIT Press 1987.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import raster
from crowquill.kernel import compiled
from crowquill.marks import whole
from crowquill.paths import Array, Index, Paths
from crowquill.printable import clipped, simplified
from crowquill.tone import Tone
from crowquill.units import INCH

LPI = 50.0  # lines to the inch where nothing is said: they are seen as lines at arm's length
MOST = 10_000_000  # pitches squared on the canvas: A4 at 320 lpi; a file of more takes gigabytes
NODE = 0.02  # mm: between nodes outlines are straight, and cut off corners; 8 to 32 to a pitch
TILE = 32  # pitches a side of what is contoured at a time
LEVELS = np.linspace(0, 1, 257)
OUT = 0.1  # how far beyond 0 and 1 levels go where there is no ink, or nothing but ink


def ruling(lpi: float | None, pitch: float | None, tone: Tone, families: int = 1) -> float:
    """The pitch in mm, of one given or neither. Raises ValueError for both, and for a ruling too fine for the canvas."""
    if lpi is not None and pitch is not None:
        raise ValueError(f"lpi {lpi:g} and pitch {pitch:g} mm are both given; leave one out")
    p = pitch if pitch is not None else INCH / (LPI if lpi is None else lpi)
    count = families * float(shapely.area(tone.canvas)) / p**2
    if count > MOST:
        least = float(np.sqrt(count / MOST)) * p
        raise ValueError(f"a pitch of {p:.4g} mm makes {count:.2g} dots, over the limit of {MOST:.0e}; take {least:.3g} mm or more")
    return p


def phases(phase: tuple[float, ...] | None, families: int, rng: np.random.Generator) -> Array:
    """Where lines lie, in shares of the pitch, (families,): as given, one for all or one for each, or by chance."""
    if phase is None:
        return rng.random(families)
    if len(phase) not in (1, families):
        raise ValueError(f"phase has {len(phase)} numbers for {families} families of lines; give one, or one for each")
    return np.broadcast_to(np.array(phase), families)


@dataclass(frozen=True, eq=False)
class Ground:
    """The coverage that a screen follows: straight between the middles of pixels, and beyond the canvas as at its edge.

    coverage  (h, w), inside (h, w) the share of each pixel in the canvas, pixel its sides in mm: the tone's own pixels, or
              whole numbers of them that are no wider than the detail a screen can show
    """

    coverage: Array
    inside: Array
    pixel: tuple[float, float]

    @classmethod
    def of(cls, tone: Tone, detail: float) -> Ground:
        """The ground of a tone for shapes that show no detail finer than so many mm."""
        from scipy.ndimage import distance_transform_edt

        across, down = (max(1, int(detail / side)) for side in tone.pixel)
        ink, inside = (_summed(part, down, across) for part in (tone.coverage * tone.inside, tone.inside))
        coverage = ink / np.where(inside > 0, inside, 1)
        nearest = distance_transform_edt(inside == 0, return_distances=False, return_indices=True)
        side = tone.pixel[0] * across, tone.pixel[1] * down
        return cls(np.clip(coverage[tuple(nearest)], 0, 1), inside / (across * down), side)

    def at(self, x: Array, y: Array) -> Array:
        """Coverage at places in mm, in the shape of x and y."""
        found = np.empty(x.shape)
        _read(self.coverage, (x / self.pixel[0]).ravel(), (y / self.pixel[1]).ravel(), found.ravel())
        return found

    def sum(self, share: Array) -> float:
        """The integral of a share (h, w) over the canvas, mm^2."""
        return float((share * self.inside).sum() * self.pixel[0] * self.pixel[1])


@dataclass(frozen=True, eq=False)
class Lattice:
    """Where two families of lines cross: place = origin + u a + v b mm, dots at whole u and v; `back` (2, 2) leads from mm to u, v."""

    origin: Array
    steps: Array
    back: Array

    @classmethod
    def of(cls, angles: tuple[float, float], pitch: float, phase: Array) -> Lattice:
        """The lattice of lines that run at two angles in degrees from x towards y, `pitch` mm apart."""
        turn = np.radians(angles)
        back = np.stack([-np.sin(turn), np.cos(turn)], axis=1) / pitch
        origin = np.asarray(np.linalg.solve(back, phase), np.float64)
        back[1] *= np.sign(np.linalg.det(back))  # so that what turns from u to v turns from x to y
        return cls(origin, np.asarray(np.linalg.inv(back), np.float64), back)

    def places(self, u: npt.ArrayLike, v: npt.ArrayLike) -> tuple[Array, Array]:
        """x and y in mm of u and v."""
        (a, b), (c, d) = self.steps
        u, v = np.asarray(u, np.float64), np.asarray(v, np.float64)
        return self.origin[0] + a * u + b * v, self.origin[1] + c * u + d * v

    def reach(self, canvas: shapely.Geometry) -> tuple[Index, Index]:
        """The least and the greatest whole u and v of dots whose cells may touch a canvas, each (2,)."""
        left, top, right, bottom = shapely.bounds(canvas)
        corners = (np.array([(left, top), (right, top), (right, bottom), (left, bottom)]) - self.origin) @ self.back.T
        return np.floor(corners.min(axis=0)).astype(np.int64), np.ceil(corners.max(axis=0)).astype(np.int64)


@dataclass(frozen=True, eq=False)
class Wave:
    """A wave over a cell of the lattice, at nodes (n, n) from the middle of a dot on, and what each level covers.

    coverage  (257,) of LEVELS
    square    dots have corners on the diagonals of their cells, and straight sides
    """

    nodes: Array
    square: bool
    coverage: Array

    @classmethod
    def of(cls, rule: Callable[[Array, Array], Array], pitch: float, square: bool = False) -> Wave:
        """The wave of a rule that takes u and v, whole numbers being the middles of dots, at nodes as dense as the pitch in mm asks for.

        Levels are measured on the very outlines that will be drawn, so that what their straight pieces cut off corners is made up
        for: eight nodes else lose as much as 0.02 of a cell.
        """
        nodes = 2 * int(np.clip(pitch / NODE / 2, 4, 16))
        part = np.arange(nodes + 1) / nodes
        cell = rule(part, part[:, None])
        coverage = np.array([float(_contours(cell - s, nodes * square).areas.sum()) for s in LEVELS]) / nodes**2
        coverage[0], coverage[-1] = 0.0, 1.0
        return cls(cell[:-1, :-1], square, np.maximum.accumulate(coverage))

    def levels(self, coverage: Array, least: float, most: float) -> Array:
        """The level at which so much is covered; below all of the wave where less than `least` is, above it over `most`."""
        level = np.interp(coverage, self.coverage, LEVELS)
        return np.where(coverage >= most, 1 + OUT, np.where((coverage < least) | (coverage == 0), -OUT, level))


def triangle(u: Array) -> Array:
    """The wave of one family of lines, 0 in their middles, 1 half way: each value from 0 to 1 as often as any other."""
    return np.asarray(1 - np.abs(2 * (u % 1) - 1))


def contoured(ground: Ground, tone: Tone, lattice: Lattice, wave: Wave, least: float = 0.0, most: float = 1.0) -> Iterator[Paths]:
    """The shapes where the wave is below the level that the coverage there takes, cut at the canvas, some pitches square at a time.

    least, most  coverage below which there is no ink, and from which on there is nothing but ink
    gives        for each square outlines and behind each its holes, which turn the other way; squares overlap by a node
    """
    for square, paths in squares(ground, tone, lattice, wave, least, most):
        yield paths if shapely.contains_properly(tone.canvas, square) else clipped(paths, tone.canvas)


def squares(
    ground: Ground, tone: Tone, lattice: Lattice, wave: Wave, least: float, most: float, beyond: int = 0
) -> Iterator[tuple[shapely.Geometry, Paths]]:
    """Squares that cover the canvas, and the outlines as of contoured() in each, not cut, as many pitches beyond it as are asked for."""
    n = len(wave.nodes)
    low, high = lattice.reach(tone.canvas)
    for v in range(low[1], high[1] + 1, TILE):
        for u in range(low[0], high[0] + 1, TILE):
            corners = lattice.places([u, u + TILE, u + TILE, u], [v, v, v + TILE, v + TILE])
            square = shapely.buffer(shapely.polygons(np.stack(corners, axis=1)), float(np.abs(lattice.steps).sum()) / n)
            if not shapely.intersects(tone.canvas, square):
                continue
            along = np.arange((TILE + 2 * beyond) * n + 2)
            left, top = u - beyond, v - beyond
            x, y = lattice.places(left + along / n, top + along[:, None] / n)
            level = wave.levels(ground.at(x, y), least, most)
            rings = _contours(wave.nodes[np.ix_(along % n, along % n)] - level, n * wave.square)
            xy = np.stack(lattice.places(left + rings.xy[:, 0] / n, top + rings.xy[:, 1] / n), axis=1)
            yield square, simplified(Paths(xy, rings.start))


def joined(parts: list[Paths], closed: bool = True) -> Paths:
    """All paths of several, in their order."""
    start = np.concatenate([[0], np.cumsum(np.concatenate([np.zeros(0, np.int64), *(np.diff(part.start) for part in parts)]))])
    return Paths(np.concatenate([np.zeros((0, 2)), *(part.xy for part in parts)]), start.astype(np.int64), closed)


def inked(paths: Paths, angles: tuple[float, ...], pitch: float, pen: float | None = None) -> float:
    """The area that a screen's outlines, or strokes of a pen, cover in the whole micrometres of a sheet, mm^2, within about 1e-4.

    It is turned first, so that no family of lines runs along the lines it is measured by: they would meet or miss whole edges.
    """
    if not len(paths.xy):
        return 0.0
    turns = np.radians(np.arange(180) + 0.5)
    slope = np.abs(np.sin(np.radians(angles) + turns[:, None])).min(axis=1)
    cos, sin = np.cos(turns[slope.argmax()]), np.sin(turns[slope.argmax()])
    turned = replace(paths, xy=whole(paths.xy)).moved(((cos, -sin), (sin, cos)))
    low, high = turned.xy.min(axis=0) - (pen or 0), turned.xy.max(axis=0) + (pen or 0)
    pixel = max(4 * pitch, float(np.sqrt(np.prod(high - low) / 4e7)))
    columns, rows = np.ceil((high - low) / pixel).astype(int)
    lines = max(16, round(pixel / min(pitch / 16, float(high[1] - low[1]) / 4000)))
    cover = raster.covered(turned.moved(np.eye(2), -low), (rows, columns), pixel=(pixel, pixel), pen=pen, lines=lines)
    return float(cover.sum()) * pixel**2


def _summed(values: Array, down: int, across: int) -> Array:
    """Sums of blocks of pixels; the last of a row or column may be smaller."""
    h, w = values.shape
    padded = np.pad(values, ((0, -h % down), (0, -w % across)))
    return np.asarray(padded.reshape(len(padded) // down, down, -1, across).sum(axis=(1, 3)))


def _contours(height: Array, square: int = 0) -> Paths:
    """The outlines of where height (h, w) at whole places is below 0, cut off at its border, and behind each its holes.

    square  nodes to a cell whose dot has its corners on the diagonals; 0 leaves corners cut off
    """
    from contourpy import FillType, contour_generator

    made = contour_generator(z=height, fill_type=FillType.ChunkCombinedOffsetOffset).filled(-1e3, 0.0)
    points, offsets = made[0][0], made[1][0]
    if points is None or offsets is None:
        return Paths.of([])
    start = np.asarray(offsets, np.int64)
    rings = Paths(np.delete(points, start[1:] - 1, axis=0), start - np.arange(len(start)))  # each ring ends in its first point
    return _squared(rings, square) if square else rings


def _squared(rings: Paths, n: int) -> Paths:
    """Rings with the corners that were cut off between nodes: dots lie at every n-th, their corners on diagonals."""
    after = np.arange(1, len(rings.xy) + 1)
    after[rings.start[1:] - 1] = rings.start[:-1]
    a, b = rings.xy, rings.xy[after]
    middle = np.round((a + b) / (2 * n)) * n
    off = np.floor(np.abs((a + b) / 2 - middle))
    cut = np.flatnonzero((off[:, 0] == off[:, 1]) & (a != b).all(axis=1))
    one, other = np.stack([a[cut, 0], b[cut, 1]], axis=1), np.stack([b[cut, 0], a[cut, 1]], axis=1)
    outer = np.abs(one - middle[cut]).sum(axis=1) > np.abs(other - middle[cut]).sum(axis=1)
    xy = np.insert(rings.xy, cut + 1, np.where(outer[:, None], one, other), axis=0)
    return Paths(xy, rings.start + np.searchsorted(cut, rings.start))


@compiled
def value(coverage: Array, x: float, y: float) -> float:
    """Coverage at a place in pixels, straight between their middles."""
    h, w = coverage.shape
    x, y = min(max(x - 0.5, 0.0), w - 1.0), min(max(y - 0.5, 0.0), h - 1.0)
    i, j = min(int(x), max(w - 2, 0)), min(int(y), max(h - 2, 0))
    right, below, s, t = min(i + 1, w - 1), min(j + 1, h - 1), x - i, y - j
    upper = coverage[j, i] + s * (coverage[j, right] - coverage[j, i])
    lower = coverage[below, i] + s * (coverage[below, right] - coverage[below, i])
    return float(upper + t * (lower - upper))


def strips(ground: Ground, start: Array, along: Array, count: int, across: Array) -> Array:
    """The mean coverage of strips, (m, count): at start (m, 2) + k along, from there to as far as `across` reaches, all mm."""
    samples = max(1, int(np.ceil(np.hypot(*across) / min(ground.pixel))))
    found = np.empty((len(start), count))
    _read_strips(ground.coverage, start / ground.pixel, along / ground.pixel, across / ground.pixel, samples, found)
    return found


def held(ground: Ground, x: Array, y: Array) -> npt.NDArray[np.bool_]:
    """Which places lie in pixels of the canvas."""
    h, w = ground.inside.shape
    column, row = np.floor(x / ground.pixel[0]).astype(np.int64), np.floor(y / ground.pixel[1]).astype(np.int64)
    on = (column >= 0) & (column < w) & (row >= 0) & (row < h)
    return np.asarray(on & (ground.inside[np.clip(row, 0, h - 1), np.clip(column, 0, w - 1)] > 0.5))


@compiled
def _read(coverage: Array, x: Array, y: Array, found: Array) -> None:
    """Fills the coverage at places in pixels."""
    for k in range(len(x)):
        found[k] = value(coverage, x[k], y[k])


@compiled
def _read_strips(coverage: Array, start: Array, along: Array, across: Array, samples: int, found: Array) -> None:
    """Fills the mean of so many samples across each strip, all in pixels."""
    for m in range(found.shape[0]):
        for k in range(found.shape[1]):
            x, y = start[m, 0] + k * along[0], start[m, 1] + k * along[1]
            total = 0.0
            for n in range(samples):
                t = (n + 0.5) / samples
                total += value(coverage, x + t * across[0], y + t * across[1])
            found[m, k] = total / samples
