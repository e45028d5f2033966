"""Parting: convex stones of a mosaic cut so that the grout between any two has its width, and grown into the room that is left.

Source: G. Di Blasi, G. Gallo, Artificial Mosaics, The Visual Computer 21(6), 2005, for stones that are cut.
"""

from __future__ import annotations

import numpy as np
import shapely

from crowquill.kernel import compiled
from crowquill.paths import Array, Index
from crowquill.tiles import SNAP, Stones

CORNERS = 64  # of a stone while it is cut


def parted(stones: Stones, angle: Array, gap: float) -> Stones:
    """Convex stones cut until no two are nearer than the gap in mm, even once their corners are whole micrometres.

    angle  (n,) rad, of one side of each

    Of each pair that is too near both lose what lies in or beyond a slab as wide as the gap, where they would first come so near
    if both grew from their middles: along a side of either, or half way between. Pairs come in the order in which they would.
    Stones only shrink, so that what was parted stays parted. What nothing is left of is an empty Polygon.
    """
    corners, count, middle, pairs = _ready(stones, gap + SNAP)
    touch = np.zeros((len(pairs), 4))
    _touch(corners, count, angle, middle, pairs, gap + SNAP, touch)
    order = np.argsort(touch[:, 0], kind="stable")
    _part(corners, count, angle, middle, pairs[order], touch[order], gap + SNAP)
    return _polygons(corners, count)


def grown(stones: Stones, full: Stones, angle: Array, gap: float) -> Stones:
    """Parted stones, each in turn made as large a part of what it is `full` as the others leave room for; empty ones may begin so.

    From a full stone goes what is too near another, in the direction that costs it least area; what becomes no larger stays.
    """
    corners, count, middle, pairs = _ready(full, gap + SNAP)
    now, left = _corners(stones)
    both = np.concatenate([pairs, pairs[:, ::-1]])
    far = np.hypot(*(middle[both[:, 0]] - middle[both[:, 1]]).T)
    both = both[np.lexsort((far, both[:, 0]))]
    start = np.searchsorted(both[:, 0], np.arange(len(full) + 1))
    _grow(corners, count, now, left, angle, middle, both[:, 1].copy(), start, gap + SNAP)
    return _polygons(now, left)


def _ready(stones: Stones, gap: float) -> tuple[Array, Index, Array, Index]:
    """Corners (n, CORNERS, 2) of stones, how many each has, their middles, and which pairs i < j are nearer than the gap.

    Stones of very many corners count as their boxes.
    """
    rough = stones.copy()
    many = shapely.get_num_coordinates(stones) > CORNERS // 2
    rough[many] = shapely.oriented_envelope(stones[many])
    corners, count = _corners(rough)
    middle = np.zeros((len(stones), 2))
    middle[count > 0] = shapely.get_coordinates(shapely.centroid(rough[count > 0]))
    first, second = shapely.STRtree(rough).query(rough, predicate="dwithin", distance=gap)
    return corners, count, middle, np.stack([first, second], axis=1)[first < second]


def _corners(stones: Stones) -> tuple[Array, Index]:
    """Corners (n, CORNERS, 2) of stones of no more, and how many each has."""
    xy, stone = shapely.get_coordinates(shapely.get_exterior_ring(shapely.orient_polygons(stones)), return_index=True)
    last = np.append(stone[1:] != stone[:-1], True)[: len(xy)]  # shapely repeats the first point of a ring
    xy, stone = xy[~last], stone[~last]
    count = np.bincount(stone, minlength=len(stones)).astype(np.int64)
    corners = np.zeros((len(stones), CORNERS, 2))
    corners[stone, np.arange(len(xy)) - (np.cumsum(count) - count)[stone]] = xy
    return corners, count


def _polygons(corners: Array, count: Index) -> Stones:
    """Rings of so many corners (n, k, 2) as Polygons, empty ones of fewer than three."""
    found = np.full(len(count), shapely.Polygon(), dtype=object)
    some = count > 2
    here = np.arange(corners.shape[1]) < count[some, None]
    if some.any():
        found[some] = shapely.polygons(shapely.linearrings(corners[some][here], indices=np.nonzero(here)[0]))
    return found


@compiled
def _way(trial: int, first: float, second: float) -> tuple[float, float]:
    """One of six directions across sides of two stones: of the first, of the second, and half way between."""
    quarter = np.pi / 2
    turn = (second - first + quarter / 2) % quarter - quarter / 2
    way = first + turn * (trial % 3) / 2 + quarter * (trial // 3)
    return np.cos(way), np.sin(way)


@compiled
def _touch(corners: Array, count: Index, angle: Array, middle: Array, pairs: Index, gap: float, touch: Array) -> None:
    """Where two stones that grow from their middles come within the gap: at what part of their size, in what direction, at which place."""
    for k in range(len(pairs)):
        i, j = pairs[k, 0], pairs[k, 1]
        wx, wy = middle[j, 0] - middle[i, 0], middle[j, 1] - middle[i, 1]
        touch[k, 0] = -np.inf
        for trial in range(6):
            x, y = _way(trial, angle[i], angle[j])
            if x * wx + y * wy < 0:
                x, y = -x, -y
            at_i, at_j = x * middle[i, 0] + y * middle[i, 1], x * middle[j, 0] + y * middle[j, 1]
            reach_i, reach_j = _end(corners[i], count[i], x, y) - at_i, _end(corners[j], count[j], -x, -y) + at_j
            part = (at_j - at_i - gap) / (reach_i + reach_j)
            if part > touch[k, 0] + 1e-9:
                touch[k, 0], touch[k, 1], touch[k, 2], touch[k, 3] = part, x, y, at_i + part * reach_i


@compiled
def _part(corners: Array, count: Index, angle: Array, middle: Array, pairs: Index, touch: Array, gap: float) -> None:
    """Cuts stones pair by pair where they touch, but those that earlier cuts have parted."""
    for k in range(len(pairs)):
        i, j = pairs[k, 0], pairs[k, 1]
        if count[i] < 3 or count[j] < 3:
            continue
        if _least(corners[i], count[i], angle[i], middle[i], corners[j], count[j], angle[j], middle[j], gap)[0] >= 0:
            x, y, at = touch[k, 1], touch[k, 2], touch[k, 3]
            count[i] = _clip(corners[i], count[i], x, y, at)
            count[j] = _clip(corners[j], count[j], -x, -y, -at - gap)


@compiled
def _grow(full: Array, whole: Index, now: Array, left: Index, angle: Array, middle: Array, others: Index, start: Index, gap: float) -> None:
    """Gives each stone in turn what its neighbours, as they are by now, leave it."""
    for i in range(len(full)):
        ring, n = full[i].copy(), whole[i]
        for j in others[start[i] : start[i + 1]]:
            if left[j] > 2 and n > 2:
                cost, x, y, at = _least(ring, n, angle[i], middle[i], now[j], left[j], angle[j], middle[j], gap)
                if cost >= 0:
                    n = _clip(ring, n, x, y, at)
        if n > 2 and _area(ring, n) > _area(now[i], left[i]):
            now[i], left[i] = ring, n


@compiled
def _least(
    ring: Array, n: int, angle: float, middle: Array, other: Array, m: int, turn: float, there: Array, gap: float
) -> tuple[float, float, float, float]:
    """The cut that takes a ring out of the gap to another at the least cost in area: its cost, direction and place; -1 if it is out."""
    wx, wy = there[0] - middle[0], there[1] - middle[1]
    far = max(np.sqrt(wx * wx + wy * wy), 1e-9)
    least, ux, uy, where = np.inf, 1.0, 0.0, 0.0
    for trial in range(7):
        x, y = _way(trial, angle, turn) if trial < 6 else (wx / far, wy / far)
        if x * wx + y * wy < 0:
            x, y = -x, -y
        at = -_end(other, m, -x, -y) - gap
        if _end(ring, n, x, y) <= at:
            return -1.0, x, y, at
        cost = _beyond(ring, n, x, y, at)
        if cost < least:
            least, ux, uy, where = cost, x, y, at
    return least, ux, uy, where


@compiled
def _end(ring: Array, n: int, x: float, y: float) -> float:
    """How far a ring reaches in a direction."""
    most = -np.inf
    for k in range(n):
        most = max(most, ring[k, 0] * x + ring[k, 1] * y)
    return most


@compiled
def _area(ring: Array, n: int) -> float:
    """The area of a ring, summed about its first corner."""
    total = 0.0
    for k in range(1, n - 1):
        u, v = ring[k] - ring[0], ring[k + 1] - ring[0]
        total += (u[0] * v[1] - v[0] * u[1]) / 2
    return abs(total)


@compiled
def _beyond(ring: Array, n: int, x: float, y: float, at: float) -> float:
    """The area of the part of a convex ring that lies beyond a line across a direction."""
    total, began, fx, fy, px, py = 0.0, False, 0.0, 0.0, 0.0, 0.0
    for k in range(n):
        m = (k + 1) % n
        a, b = ring[k, 0] * x + ring[k, 1] * y - at, ring[m, 0] * x + ring[m, 1] * y - at
        for corner in range(2):
            if (corner == 0 and a <= 0) or (corner == 1 and (a > 0) == (b > 0)):
                continue
            t = 0.0 if corner == 0 else a / (a - b)
            qx, qy = ring[k, 0] + t * (ring[m, 0] - ring[k, 0]), ring[k, 1] + t * (ring[m, 1] - ring[k, 1])
            if not began:
                began, fx, fy = True, qx, qy
            else:
                total += ((px - fx) * (qy - fy) - (qx - fx) * (py - fy)) / 2
            px, py = qx, qy
    return abs(total)


@compiled
def _clip(ring: Array, n: int, x: float, y: float, at: float) -> int:
    """Cuts off in place what of a convex ring lies beyond a line across a direction; the number of corners left."""
    old = ring[:n].copy()
    made = 0
    for k in range(n):
        m = (k + 1) % n
        a, b = old[k, 0] * x + old[k, 1] * y - at, old[m, 0] * x + old[m, 1] * y - at
        if a <= 0:
            ring[made] = old[k]
            made += 1
        if (a > 0) != (b > 0) and made < CORNERS:
            ring[made] = old[k] + a / (a - b) * (old[m] - old[k])
            made += 1
    while made > CORNERS - 2:  # without its flattest corner a convex ring is smaller, and no nearer to others
        flat, which = np.inf, 0
        for k in range(made):
            p, q = ring[(k - 1) % made], ring[(k + 1) % made]
            area = abs((ring[k, 0] - p[0]) * (q[1] - p[1]) - (q[0] - p[0]) * (ring[k, 1] - p[1]))
            if area < flat:
                flat, which = area, k
        for k in range(which, made - 1):
            ring[k] = ring[k + 1]
        made -= 1
    return made
