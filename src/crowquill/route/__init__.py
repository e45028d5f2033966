"""Routes for pens: strokes in an order that takes little travel, and one line through all points without crossings.

Neither is the shortest there is, which nobody can find for so many: dots at random take 1.04 times as long, about.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from crowquill import hilbert
from crowquill.paths import Array, Index, Paths, frozen
from crowquill.route import search
from crowquill.route.crossings import crossings
from crowquill.route.near import neighbours_of

NEIGHBOURS = 8  # of each end in an order; ten make it 0.1 % shorter
NEAR = 12  # of each point in a line, which takes its time
PASSES = 3  # over all rings when their beginnings are chosen; a fourth changed nothing


class Order(NamedTuple):
    """Strokes as they are drawn: `index` (n,) which stroke is next, `turned` (n,) whether it is drawn from its end to its start."""

    index: Index  # type: ignore[assignment]  # a tuple's own index() looks for values; nobody does so in an order
    turned: npt.NDArray[np.bool_]


def order(ends: npt.ArrayLike, closed: bool = False, *, home: tuple[float, float] = (0.0, 0.0)) -> Order:
    """The order and direction of strokes that take the pen little way between them, from home on.

    ends    (n, 2, 2) start and end of each stroke, mm; a dot, or a ring that must begin where it does, has the same
            place twice, and is never turned. `begun` says where else rings may begin.
    closed  whether the pen comes home at the end, so that the way back counts

    Strokes that coincide, that lie in a row or on a lattice, one and none of them need no rule. The same strokes give the
    same order. Raises ValueError for ends that are not finite or of another shape.
    """
    given = frozen(ends, np.float64, (None, 2, 2), "ends")
    n = len(given)
    along = hilbert.of_points(given.mean(axis=1))  # neighbours in memory are neighbours on paper: twice as fast
    ports = np.full((n + 1, 2, 2), _place(home))
    ports[:n] = given[along]
    if not closed:
        ports[n, 1] = np.nan
    flat = ports.reshape(-1, 2)
    ring = _first(search.shortest(flat, neighbours_of(flat, NEIGHBOURS))[0], 2 * n + 1)[1:]
    index = along[ring >> 1]
    return Order(index, (ring & 1 == 1) & (given[index, 0] != given[index, 1]).any(axis=1))


def travel(ends: npt.ArrayLike, order: Order, closed: bool = False, *, home: tuple[float, float] = (0.0, 0.0)) -> float:
    """How far the pen goes between strokes drawn in this order, mm: from home to the first, and back when closed; 0 without any."""
    drawn = frozen(ends, np.float64, (None, 2, 2), "ends")[order.index]
    drawn = np.where(order.turned[:, None, None], drawn[:, ::-1], drawn)
    if not len(drawn):
        return 0.0
    stops = np.concatenate([_place(home)[None], drawn.reshape(-1, 2), _place(home)[None]])
    ways = np.hypot(*(stops[1::2] - stops[::2]).T)
    return float(ways.sum() if closed else ways[:-1].sum())


def begun(rings: Paths, index: npt.ArrayLike, *, home: tuple[float, float] = (0.0, 0.0)) -> Index:
    """The point of each closed path at which to begin it, (n,) counted within it, for little travel when drawn in this order.

    Of cubic ones an anchor. Each takes the point that is best between its neighbours' points, three times over.
    Raises ValueError for open or empty paths.
    """
    if not rings.closed or (np.diff(rings.start) == 0).any():
        raise ValueError("rings has lines or empty paths; it takes closed paths of a point or more")
    row = np.arange(len(rings))[np.asarray(index, np.int64)]
    step = 3 if rings.cubic else 1
    chosen = np.zeros(len(rings), np.int64)
    at = rings.xy[rings.start[:-1]] if len(rings) else np.zeros((0, 2))
    for _ in range(PASSES):
        before = _place(home)
        for k, ring in enumerate(row.tolist()):
            points = rings[ring][::step]
            way = np.hypot(*(points - before).T)
            if k + 1 < len(row):
                way += np.hypot(*(points - at[row[k + 1]]).T)
            chosen[ring] = step * int(np.argmin(way))
            before = at[ring] = rings[ring][chosen[ring]]
    return chosen


def tour(points: npt.ArrayLike, closed: bool = True) -> Index:
    """One line through all points that nowhere crosses itself, as the order (n,) of the points.

    closed  whether it comes back to its first point, the first of those given; else its ends are where it is shortest,
            and the one nearer to the first point comes first

    Points (n, 2) mm that coincide follow each other. No two links cross, exactly; they touch, in a point or along a row, only
    where no change would make the line shorter, as must be when all points lie in one row. Random points take
    0.74 sqrt(n A) of line, relaxed ones 1.03. White that points leave between them is
    jumped across. Raises ValueError for points that are not finite or of another shape.
    """
    xy = frozen(points, np.float64, (None, 2), "points")
    if len(xy) < 2:
        return np.arange(len(xy))
    _, first, which = np.unique(xy + 0.0, axis=0, return_index=True, return_inverse=True)
    along = first[hilbert.of_points(xy[first])]
    ports = np.repeat(xy[along], 2, axis=0)
    if not closed:
        ports = np.concatenate([ports, np.full((2, 2), np.nan)])
    ring = _uncrossed(ports)
    ring = _first(ring, 2 * len(along))[1:] if not closed else _first(ring, 2 * int(np.argmin(along)))
    path = along[ring >> 1]
    if not closed and np.hypot(*(xy[path[-1]] - xy[0])) < np.hypot(*(xy[path[0]] - xy[0])):
        path = path[::-1]
    rank = np.empty(len(first), np.int64)
    rank[which[path]] = np.arange(len(path))
    return np.argsort(rank[which], kind="stable")


def _uncrossed(ports: Array) -> Index:
    """A short ring through dots of which no two links cross.

    Of links that cross the ring is the shorter for linking their ends otherwise: so this comes to an end.
    """
    near = neighbours_of(ports, NEAR)
    ring, place = search.shortest(ports, near)
    while len(ring) > 3:
        left, entered = ring ^ 1, np.roll(ring, -1)
        pairs = crossings(ports[left], ports[entered])
        links = np.stack([left, entered], axis=1)[pairs]
        changed = search.undone(ports, ring, place, links.reshape(-1, 4))
        if not len(changed):
            break
        search.improve(ports, near, ring, place, changed)
    return ring


def _place(home: tuple[float, float]) -> Array:
    return np.asarray(frozen(home, np.float64, (2,), "home"), np.float64)


def _first(ring: Index, port: int) -> Index:
    """The same ring begun with the stroke of a port, which is the one to be entered."""
    if not (ring == port).any():
        ring = ring[::-1] ^ 1
    return np.roll(ring, -int(np.argmax(ring == port)))
