"""The heap gives the least thing first whatever keys do meanwhile; numpy's own order is the other road."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crowquill.heap import CHILDREN, ordered, risen, sunk, taken
from crowquill.paths import Array

KEYS = st.lists(st.integers(0, 20).map(float), min_size=1, max_size=70)  # few values, so that many are alike


class Heap:
    """The arrays of a heap of all things with these keys."""

    def __init__(self, keys: list[float]) -> None:
        self.size = len(keys)
        self.key, self.item = np.array(keys), np.arange(self.size, dtype=np.int32)
        self.place = np.full(self.size, -1, np.int32)
        ordered(self.key, self.item, self.place, self.size)

    def take(self) -> tuple[float, int]:
        least = float(self.key[0])
        thing = taken(self.key, self.item, self.place, self.size)
        self.size -= 1
        return least, thing

    def check(self) -> None:
        at = np.arange(1, self.size)
        assert (self.key[at] >= self.key[(at - 1) // CHILDREN]).all(), "a child is before its parent"
        held = self.item[: self.size]
        assert (self.place[held] == np.arange(self.size)).all() and (self.place >= 0).sum() == self.size, "a thing is not at its place"


@settings(max_examples=60, deadline=None)
@given(KEYS)
def test_things_come_in_the_order_of_their_keys_and_each_once(keys: list[float]) -> None:
    heap = Heap(keys)
    heap.check()
    came = [heap.take() for _ in keys]
    assert [key for key, _ in came] == sorted(keys) and sorted(thing for _, thing in came) == list(range(len(keys)))
    assert all(keys[thing] == key for key, thing in came) and (heap.place == -1).all()


@settings(max_examples=60, deadline=None)
@given(KEYS, st.lists(st.tuples(st.integers(0, 69), st.integers(0, 20).map(float)), max_size=40), st.integers(0, 5))
def test_a_key_may_change_while_a_thing_waits(keys: list[float], changes: list[tuple[int, float]], first: int) -> None:
    heap, now = Heap(keys), dict(enumerate(keys))
    for _ in range(min(first, len(keys) - 1)):
        del now[heap.take()[1]]
    for which, key in changes:
        thing = sorted(now)[which % len(now)]
        at = int(heap.place[thing])
        if key < now[thing]:
            risen(heap.key, heap.item, heap.place, at, key, thing)
        else:
            sunk(heap.key, heap.item, heap.place, heap.size, at, key, thing)
        now[thing] = key
        heap.check()
    assert [heap.take()[0] for _ in range(len(now))] == sorted(now.values())


def test_the_check_of_a_heap_sees_a_key_that_was_changed_behind_its_back() -> None:
    heap = Heap([1.0, 2.0, 3.0])
    heap.key[0] = 2.5
    with pytest.raises(AssertionError, match="before its parent"):
        heap.check()


def test_a_thing_may_be_put_in() -> None:
    heap = Heap([3.0, 1.0])
    room: tuple[Array, ...] = tuple(np.resize(part, 3) for part in (heap.key, heap.item, heap.place))
    risen(*room, 2, 0.5, 2)
    assert taken(*room, 3) == 2 and taken(*room, 2) == 1
