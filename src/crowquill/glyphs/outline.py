"""The outline of one dot of a scan: its contour between pixels, and few cubics that follow it."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from contourpy import contour_generator
from scipy import ndimage
from scipy.interpolate import make_interp_spline
from scipy.spatial import ConvexHull

from crowquill.paths import Array, Paths

Grey = npt.NDArray[np.floating[Any]]

STRAY = 0.14  # pixels an outline may lie off its contour: 3 um at 1200 dpi
EVEN = 160  # points of a contour that are fitted
SAMPLES = 16  # on a cubic, to measure from: their chords lie 0.005 pixels off a dot of 14


def iso_contour(patch: Grey, level: float) -> Array:
    """The longest closed line (n, 2) of x, y in pixels at a level, turning from x to y; pixel (r, c) has its centre at c + .5, r + .5.

    Between the centres runs a cubic spline, taken at thirds: straight sides of a pixel would lose 0.4 % of a dot of 14.
    Empty where no line closes. The patch has 4 pixels a side or more.
    """
    rows, columns = (np.arange(side) + 0.5 for side in patch.shape)
    y, x = (np.linspace(0.5, side - 0.5, 3 * side - 2) for side in patch.shape)
    spline = make_interp_spline(columns, make_interp_spline(rows, np.asarray(patch, np.float64))(y), axis=1)
    lines = (np.asarray(line) for line in contour_generator(x, y, spline(x)).lines(level))
    rings = [line[:-1] for line in lines if len(line) > 3 and np.array_equal(line[0], line[-1])]
    ring = max(rings, key=lambda ring: _arc(ring)[-1], default=np.empty((0, 2)))
    return ring[::-1] if len(ring) and Paths.of([ring]).areas[0] < 0 else ring


def edge_level(patch: Grey, ink: float) -> float:
    """The level at which a dot's outline lies: half way from paper (0) to ink, less what the optics drew a round edge in.

    A blur of standard deviation s draws the half level of a disc of radius r in by s^2 / 2r, where the darkness climbs
    by ink / (s sqrt(2 pi)) a pixel. At 1200 dpi and s = 0.8 pixels that is 1.5 % of the area of a 0.3 mm dot.
    """
    ring = iso_contour(patch, ink / 2)
    if len(ring) < 3:
        return ink / 2
    slope = np.hypot(*np.gradient(np.asarray(patch, np.float64)))
    climb = float(np.median(ndimage.map_coordinates(slope, ring.T[::-1] - 0.5, order=1)))
    blur = np.sqrt(max(ink * ink / (2 * np.pi * max(climb, 1e-9) ** 2) - 1 / 3, 0))  # 1/3: of differences over two pixels
    radius = np.sqrt(Paths.of([ring]).areas[0] / np.pi)
    return float(ink * (0.5 - min(blur / (2 * radius * np.sqrt(2 * np.pi)), 0.06)))  # over 0.06 the blur is as wide as the dot


def shape(ring: Array) -> tuple[float, float, float]:
    """Area, solidity (area by that of the convex hull) and axis ratio (by second moments, 1 for a circle) of a ring of 3 points or more."""
    m = Paths.of([ring]).green()[0]
    x, y = m[1:3] / m[0]
    xy = m[4] / m[0] - x * y
    narrow, wide = np.linalg.eigvalsh([[m[3] / m[0] - x * x, xy], [xy, m[5] / m[0] - y * y]])
    return float(m[0]), float(m[0] / ConvexHull(ring).volume), float(np.sqrt(max(narrow, 0) / wide))


def _arc(ring: Array) -> Array:
    """Length along a closed ring up to each of its points, and all round: (n + 1,)."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*(np.roll(ring, -1, 0) - ring).T))])


def fitted(contour: Array) -> tuple[Array, float]:
    """A closed ring of 5 to 8 smoothly joined cubics (3k points) near a closed contour, of its area; and how far off it is.

    The fewest cubics that stay within STRAY, or else the nearest eight or fewer.
    """
    points, dense = _evenly(contour)
    area = Paths.of([contour]).areas[0]
    best = np.empty((0, 2)), np.inf
    for count in range(5, 9):
        for phase in np.arange(4) / 4:  # where the first knot falls
            knots = np.interp((np.arange(count) + phase) / count, dense, np.arange(EVEN + 1) / EVEN)
            ring = _of_area(_least_squares(points, knots), area)
            stray = _stray(ring, contour)
            best = (ring, stray) if stray < best[1] else best
        if best[1] <= STRAY:
            break
    return best


def _evenly(contour: Array) -> tuple[Array, Array]:
    """EVEN points evenly round a contour, and the share of knots due up to each of them: more where it bends."""
    arc = _arc(contour)
    even = np.arange(EVEN) / EVEN * arc[-1]
    points = np.stack([np.interp(even, arc, np.append(side, side[0])) for side in contour.T], axis=1)
    turns = np.fft.fftfreq(EVEN, 1 / EVEN)
    wave = np.fft.fft(points @ (1, 1j)) * np.exp(-((turns / 12) ** 2))  # the pixels' steps are no bends
    first, second = np.fft.ifft(1j * turns * wave), np.fft.ifft(-(turns**2) * wave)
    bend = np.abs((first.conj() * second).imag) / np.maximum(np.abs(first), 1e-9) ** 2
    dense = np.concatenate([[0.0], np.cumsum(np.sqrt(bend + bend.mean()))])
    return points, dense / dense[-1]


def _least_squares(points: Array, knots: Array) -> Array:
    """The closed ring of cubics near evenly spaced points, its pieces parted at these shares of the way round.

    Points and velocities at the knots are the unknowns; each point's share is moved to its nearest on the curve, in turn.
    """
    count = len(knots)
    width = (np.roll(knots, -1) - knots) % 1
    share = (np.arange(len(points)) / len(points) - knots[0]) % 1
    begin = np.concatenate([[0.0], np.cumsum(width)])
    piece = np.clip(np.searchsorted(begin, share, side="right") - 1, 0, count - 1)
    at = piece + (share - begin[piece]) / width[piece]
    for _ in range(5):
        piece = np.floor(at).astype(int) % count
        t, after, every = at % 1, (piece + 1) % count, np.arange(len(at))
        matrix = np.zeros((len(at), 2 * count))
        matrix[every, piece] = (1 + 2 * t) * (1 - t) ** 2
        matrix[every, after] = t * t * (3 - 2 * t)
        matrix[every, count + piece] = t * (1 - t) ** 2 * width[piece]
        matrix[every, count + after] = t * t * (t - 1) * width[piece]
        normal = np.linalg.lstsq(matrix.T @ matrix, matrix.T @ points, rcond=None)[0]  # small, and never singular to it
        anchor, speed = np.split(normal, 2)
        heads = anchor + speed * width[:, None] / 3
        tails = np.roll(anchor, -1, 0) - np.roll(speed, -1, 0) * width[:, None] / 3
        ring = np.stack([anchor, heads, tails], 1).reshape(-1, 2)
        at = _nearest(points, _samples(ring))[1] / SAMPLES
    return ring


def _samples(ring: Array) -> Array:
    """SAMPLES points on each cubic of a closed ring."""
    t = (np.arange(SAMPLES) / SAMPLES)[:, None]
    a, b, c = (ring[k::3, None] for k in range(3))
    d = np.roll(a, -1, 0)
    return np.asarray(a * (1 - t) ** 3 + 3 * b * t * (1 - t) ** 2 + 3 * c * t * t * (1 - t) + d * t**3).reshape(-1, 2)


def _nearest(points: Array, ring: Array) -> tuple[Array, Array]:
    """Each point's distance from a closed ring of straight sides, and where on it that is: side and share of it."""
    side = np.roll(ring, -1, 0) - ring
    x, y = (points[:, k, None] - ring[:, k] for k in (0, 1))
    u, v = side.T / np.maximum((side**2).sum(1), 1e-18)
    share = np.clip(x * u + y * v, 0, 1)
    x -= share * side[:, 0]
    y -= share * side[:, 1]
    square = x * x + y * y
    best, every = square.argmin(1), np.arange(len(points))
    return np.sqrt(square[every, best]), best + share[every, best]


def _of_area(ring: Array, area: float) -> Array:
    """A cubic ring scaled about its centroid to an area."""
    m = Paths.of([ring], cubic=True).green()[0]
    centroid = ring[0] + m[1:3] / m[0]
    return np.asarray(centroid + (ring - centroid) * np.sqrt(area / m[0]))


def _stray(ring: Array, contour: Array) -> float:
    """The greatest distance of a closed cubic ring from a contour, or of the contour from the ring."""
    curve = _samples(ring)
    return float(max(_nearest(contour, curve)[0].max(), _nearest(curve, contour)[0].max()))
