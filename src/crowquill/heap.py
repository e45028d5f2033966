"""A heap in three arrays, for loops that always go on with the least of many things, whose keys change meanwhile.

Things are numbers from 0. `key` (m,) and `item` (m,) hold the heap from its root, in `place` (n,) each thing finds itself,
-1 outside; how many there are the caller counts. Each place has four children: half as many levels as with two.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.kernel import compiled

Key = float | np.floating[Any]
Keys = npt.NDArray[np.floating[Any]]
Small = npt.NDArray[np.int32]
CHILDREN = 4


@compiled
def ordered(key: Keys, item: Small, place: Small, size: int) -> None:
    """Makes a heap of the first `size` keys and items, in whatever order they are."""
    for at in range(size):
        place[item[at]] = at
    for at in range((size - 2) // CHILDREN, -1, -1):
        sunk(key, item, place, size, at, key[at], item[at])


@compiled
def risen(key: Keys, item: Small, place: Small, at: int, least: Key, thing: int) -> None:
    """Puts a thing where its key belongs, from a place of the heap, free or its own, towards the root: its key has not grown."""
    while at > 0:
        above = (at - 1) // CHILDREN
        if not least < key[above]:
            break
        key[at], item[at] = key[above], item[above]
        place[item[at]] = at
        at = above
    key[at], item[at], place[thing] = least, thing, at


@compiled
def sunk(key: Keys, item: Small, place: Small, size: int, at: int, most: Key, thing: int) -> None:
    """Puts a thing where its key belongs, from a place of a heap of `size`, free or its own, away from the root: it has not shrunk."""
    while True:
        first = CHILDREN * at + 1
        if first >= size:
            break
        best = first
        for other in range(first + 1, min(first + CHILDREN, size)):
            if key[other] < key[best]:
                best = other
        if not key[best] < most:
            break
        key[at], item[at] = key[best], item[best]
        place[item[at]] = at
        at = best
    key[at], item[at], place[thing] = most, thing, at


@compiled
def taken(key: Keys, item: Small, place: Small, size: int) -> int:
    """The thing with the least key, which is taken out of a heap of `size`: the caller counts one less."""
    thing = int(item[0])
    place[thing] = -1
    if size > 1:
        sunk(key, item, place, size - 1, 0, key[size - 1], item[size - 1])
    return thing
