"""The borders of black pixels as rings: neighbours are one shape, so that no seam between them can shine through."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain

import numpy as np

from crowquill.halftone.diffusion import Bits
from crowquill.kernel import compiled
from crowquill.paths import Index, Paths

Nodes = tuple[Index, Index, Bits, Bits]


def corners(rows: Iterable[Bits], most: int) -> int:
    """How many points the rings of these pixels have; no more than `most` and those of one band are counted."""
    found = 0
    for y, *_ in _nodes(rows):
        found += len(y)
        if found > most:
            break
    return found


def rings(rows: Iterable[Bits]) -> Paths:
    """The borders of black pixels, given as bands (k, w) from the top, as closed Paths of corners; a pixel has side 1.

    Outer rings turn from x to y, holes the other way. Pixels that touch in a corner are two shapes; where that
    makes a shape touch itself, what lies between is a ring of its own: no ring comes to any place twice.
    """
    parts = list(_nodes(rows))
    y, x, below, down = (np.concatenate([part[k] for part in parts]) if parts else np.zeros(0, np.int64) for k in range(4))
    order = np.lexsort((down, y, x))
    other = np.empty(len(y), np.int64)  # the node at the other end of the upright side; that of the level one is a neighbour
    other[order[::2]], other[order[1::2]] = order[1::2], order[::2]
    first = 2 * np.arange(len(y) // 2) + ~below[::2].astype(bool)  # where each level side begins, its black to the right
    walk, start = _walked(other, first)
    ring = np.empty(len(y), np.int64)
    ring[walk] = np.repeat(np.arange(len(start) - 1), np.diff(start))
    twice = np.flatnonzero((y[1:] == y[:-1]) & (x[1:] == x[:-1]) & (ring[1:] == ring[:-1]))
    # a ring that comes to a place twice does not cross itself there: with its two ways on changed round it is two rings, and
    # as no two such places lie across one another on it, all can be changed at once
    turned = np.arange(len(y))
    turned[twice], turned[twice + 1] = twice + 1, twice
    other = turned[other[turned]]
    walk, start = _walked(other, first)
    return Paths(np.stack([x[walk], y[walk]], axis=1).astype(np.float64), start)


def _nodes(rows: Iterable[Bits]) -> Iterator[Nodes]:
    """Corners in the order of rows, then columns: y, x, whether the pixel right below is black, whether the upright side leads down.

    Those of a row are by twos the ends of its level sides. Where two pixels touch, their place comes twice: once as the
    end of the side on its left, once as that on its right.
    """
    above: Bits | None = None
    top = 0
    for band in chain(rows, [None]):
        if band is None:
            band = np.zeros((1, 0 if above is None else above.shape[1] - 2), np.bool_)
        framed = np.zeros((len(band) + 1, band.shape[1] + 2), np.bool_)
        if above is not None:
            framed[:1] = above
        framed[1:, 1:-1] = band
        nw, ne, sw, se = framed[:-1, :-1], framed[:-1, 1:], framed[1:, :-1], framed[1:, 1:]
        touch = (nw == se) & (ne == sw) & (nw != ne)
        y, x = np.nonzero((nw ^ ne ^ sw ^ se) | touch)
        times = 1 + touch[y, x].astype(np.int64)
        right = np.append(False, np.repeat(np.arange(len(y)), times)[1:] == np.repeat(np.arange(len(y)), times)[:-1])[: times.sum()]
        y, x = np.repeat(y, times), np.repeat(x, times)
        leads = np.where(touch[y, x], right == se[y, x], sw[y, x] != se[y, x])
        yield y + top, x, se[y, x], leads
        above, top = framed[-1:], top + len(band)


@compiled
def _walked(other: Index, first: Index) -> tuple[Index, Index]:
    """The nodes of all rings, one after another, and where each begins."""
    walk, start = np.empty(len(other), np.int64), np.zeros(len(first) + 1, np.int64)
    done = np.zeros(len(first), np.bool_)
    n, rings = 0, 0
    for side in range(len(first)):
        node = first[side]
        if done[side]:
            continue
        while not done[node // 2]:
            done[node // 2] = True
            walk[n], walk[n + 1] = node, node ^ 1
            n += 2
            node = other[node ^ 1]
        rings += 1
        start[rings] = n
    return walk, start[: rings + 1]
