"""Which ends of strokes lie near which."""

from __future__ import annotations

import numpy as np

from crowquill.kernel import compiled
from crowquill.paths import Array, Index

SPREAD = 1e-7  # of the extent; where ports coincide the tree of neighbours would take the square of their number


def neighbours_of(ports: Array, count: int) -> Index:
    """The nearest ports of other strokes to each port, (2 n, count), nearest first, -1 where there are no more; of a dot its even one."""
    near = np.full((len(ports), count), -1, np.int64)
    dot = (ports[::2] == ports[1::2]).all(axis=1)
    listed = ~np.isnan(ports[:, 0])
    listed[1::2] &= ~dot
    which = np.flatnonzero(listed)
    near[which] = nearest(ports[which], which, count)
    near[1::2][dot] = near[::2][dot]
    return near


def nearest(xy: Array, names: Index, count: int) -> Index:
    """The names of the nearest of points to each other, (m, count), nearest first, -1 where there are no more."""
    from scipy.spatial import cKDTree

    found = np.full((len(xy), count), -1, np.int64)
    k = min(count + 1, len(xy))
    if k < 2:
        return found
    apart = _spread(xy)
    _without_self(np.asarray(cKDTree(apart).query(apart, k)[1], np.int64), names, found)
    return found


def _spread(xy: Array) -> Array:
    """Points of which those that coincide are moved along by nothing that can be seen, each a little further."""
    order = np.lexsort(xy.T)
    new = np.append(True, (xy[order[1:]] != xy[order[:-1]]).any(axis=1))
    at = np.arange(len(xy))
    rank = np.empty(len(xy))
    rank[order] = at - np.maximum.accumulate(np.where(new, at, 0))
    if not rank.any():
        return xy
    step = SPREAD * max(float(np.ptp(xy, axis=0).max()), 1e-3) / (rank.max() + 1)
    apart: Array = xy - xy.min(axis=0) + step * rank[:, None]
    return apart


@compiled
def _without_self(near: Index, names: Index, found: Index) -> None:
    for i in range(len(near)):
        at = 0
        for j in near[i]:
            if j != i and at < found.shape[1]:
                found[i, at] = names[j]
                at += 1
