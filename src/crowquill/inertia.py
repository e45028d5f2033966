"""Inertia: long axes, symmetry, the moments of lines and of wholes made of parts."""

from __future__ import annotations

import numpy as np
import shapely

from crowquill.moments import NOTHING, Moments
from crowquill.paths import Array, Index, Paths

ALIKE = 0.02  # of the greatest distance from the centre: outlines this close look the same
FOLDS = range(15, 1, -1)  # a regular ring of 16 corners or more comes as close to itself at every turn, as a disc does
ROUND = 0.05  # anisotropy; below, the direction of a long axis is noise


def main_axis(covariance: Array) -> tuple[Array, Array]:
    """The direction of the long axis, rad in (-pi/2, pi/2], and the anisotropy, 0 to 1, of covariances (n, 2, 2).

    Anisotropy is the difference of the two eigenvalues over their sum: 0 for a disc or a square, 1 for a line; 0 where both are 0.
    """
    xx, xy, yy = covariance[:, 0, 0], covariance[:, 0, 1], covariance[:, 1, 1]
    total = xx + yy
    phi = 0.5 * np.arctan2(2 * xy, xx - yy)
    spread = np.hypot(xx - yy, 2 * xy) / np.where(total > 0, total, 1.0)
    return np.where(phi <= -np.pi / 2, np.pi / 2, phi), np.where(total > 0, spread, 0.0)


def pooled(parts: Moments, owner: Index, n: int, fallback: Array) -> Moments:
    """The moments of n wholes from those of their parts; owner (k,) tells which whole a part is of.

    A whole without mass has its fallback (n, 2) as centroid and covariance 0. Sums are taken about the fallback and then about
    the centroid, so that a far origin costs no digits.
    """

    def summed(values: Array) -> Array:
        return np.bincount(owner, values, n).astype(np.float64)

    mass = summed(parts.mass)
    some = np.abs(mass) > NOTHING * summed(np.abs(parts.mass))
    over = np.where(some, mass, 1.0)
    off = parts.centroid - fallback[owner]
    mean = np.stack([summed(parts.mass * axis) for axis in off.T], axis=1) / over[:, None]
    mean = np.where(some[:, None], mean, 0.0)
    x, y = (off - mean[owner]).T
    xx, xy, yy = (
        summed(parts.mass * (parts.covariance[:, i, j] + u * v)) / over for i, j, u, v in ((0, 0, x, x), (0, 1, x, y), (1, 1, y, y))
    )
    covariance = np.stack([xx, xy, xy, yy], axis=1).reshape(-1, 2, 2)
    return Moments(np.where(some, mass, 0.0), fallback + mean, np.where(some[:, None, None], covariance, 0.0))


def of_sides(lines: Paths) -> Moments:
    """Length, middle and covariance of each straight side of open lines."""
    inner = np.ones(len(lines.xy), bool)
    inner[lines.start[1:][np.diff(lines.start) > 0] - 1] = False
    a = np.flatnonzero(inner)
    begin, side = lines.xy[a], lines.xy[a + 1] - lines.xy[a]
    return Moments(np.hypot(*side.T), begin + side / 2, side[:, :, None] * side[:, None, :] / 12)


def crosses(xy: Array, angle: Array, reach: Array) -> Paths:
    """Two segments through each place (n, 2): along `angle` (n,) and across, reaching so far (n, 2) to either side."""
    along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    half = np.stack([along * reach[:, :1], across * reach[:, 1:]], axis=1)
    ends = np.stack([xy[:, None] - half, xy[:, None] + half], axis=2)
    return Paths.of(ends.reshape(-1, 2, 2), closed=False)


def drawn(paths: Paths) -> shapely.Geometry:
    """The outlines as one shapely MultiLineString."""
    lines = [np.concatenate([path, path[:1]]) if paths.closed else path for path in paths if len(path) > 1]
    return shapely.multilinestrings([shapely.LineString(line) for line in lines])


def long_axis(lines: shapely.Geometry, covariance: Array) -> float:
    """The direction of a shape's long axis, rad in (-pi/2, pi/2], of its covariance (1, 2, 2).

    Where inertia knows none, as in a square, the long side of the box around the lines that is tightest.
    """
    (axis,), (spread,) = main_axis(covariance)
    if spread < ROUND:
        box = shapely.get_coordinates(shapely.oriented_envelope(lines))[:3]
        side = max(np.diff(box, axis=0), key=lambda along: float(np.hypot(*along)))
        (axis,), _ = main_axis(np.outer(side, side)[None])
    return float(axis)


def fold_of(lines: shapely.Geometry, covariance: Array) -> int:
    """How often in a full turn a shape centred on the origin looks the same; 0 for a disc, at every turn.

    Turned so, its lines come within 2 % of the reach of themselves, and five times as close as when turned
    half as far. Only a shape without a long axis can look the same more than twice.
    """
    reach = float(np.hypot(*shapely.get_coordinates(lines).T).max())

    def off(angle: float) -> float:
        cos, sin = np.cos(angle), np.sin(angle)
        turned = shapely.transform(lines, lambda xy: xy @ np.array([[cos, sin], [-sin, cos]]))
        return float(shapely.hausdorff_distance(lines, turned, densify=0.25)) / reach

    folds = FOLDS if main_axis(covariance)[1][0] < ROUND else (2,)
    if all(off(np.pi / n) < ALIKE for n in folds):
        return 0
    # a ring of 12 corners turned by a 13th or 14th is close to itself as well, but then also when turned by half of that
    return next((n for n in folds if off(2 * np.pi / n) < min(ALIKE, off(np.pi / n) / 5)), 1)
