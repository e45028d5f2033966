"""Frames: what a page builds from them is the drawing, whatever came between, and small changes are small frames."""

from __future__ import annotations

import struct
from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest
from editing import Page, digest, do, drawing, items, shown, way, with_items

from crowquill.editor.drawing import Drawing
from crowquill.editor.frames import of_items, of_lines, of_maps
from crowquill.paths import Paths

BRUSH: dict[str, Any] = {"path": way((40, 30)), "size": 10}


def page() -> Page:
    return Page(cast(Any, None))


def follow(page: Page, old: Drawing | None, new: Drawing) -> int:
    """Has a page take the frames from one drawing to another; their bytes."""
    frames = [frame for frame in (of_items(old, new, 7), of_maps(old, new, 7)) if frame]
    for frame in frames:
        assert struct.unpack_from("<4I", frame)[1] == 7
        page._take(frame)
    return sum(map(len, frames))


CHAIN = [
    ("insert", {**BRUSH, "rate": 100}),
    ("select", {"by": "rectangle", "path": way((20, 20), (50, 40))}),
    ("freeze", {"path": way((30, 30)), "size": 5}),
    ("push", {"path": way((40, 30), (42, 33)), "size": 8}),
    ("layer add", {"cmyk": [0, 1, 1, 0]}),
    ("layer take", {"layer": 2}),
    ("resize", BRUSH),
    ("duplicate", {}),
    ("erase", {**BRUSH, "strength": 0.7}),
    ("turn", {"on": "selection", "by": "random"}),
    ("swap", {**BRUSH, "glyph": "leaves"}),
    ("relax", {}),
    ("tile", {"side": 8}),
    ("relax", {"variant": "mosaic"}),
    ("cut", {}),
    ("paint", BRUSH),
    ("paint", {**BRUSH, "map": "importance"}),
    ("layer order", {"layer": 2, "to": 0}),
    ("layer remove", {"layer": 2}),
]


def test_a_page_that_follows_frame_by_frame_has_the_drawing():
    here, state = page(), drawing(300)
    follow(here, None, state)
    for op, params in CHAIN:
        old, state = state, do(state, op, 1, **params)
        follow(here, old, state)
        assert here.items == shown(state), op
        assert (here.maps[0] == state.tone.values >> 8).all()
    assert state.wish and (here.maps[1] == state.wish.values >> 8).all()


def test_a_page_may_leave_out_states_and_go_back():
    states = [drawing(300)]
    for op, params in CHAIN:
        states.append(do(states[-1], op, 1, **params))
    here, at = page(), 0
    follow(here, None, states[0])
    for to in (9, 3, 16, 0, len(states) - 1, 5, 17, 12):
        follow(here, states[at], states[to])
        assert here.items == shown(states[to])
        at = to


def test_ids_that_come_again_for_others_are_followed():
    before = drawing(100)
    left = do(before, "insert", path=way((25, 25)), size=4, rate=50)
    right = do(before, "insert", path=way((60, 40)), size=4, rate=50)
    assert set(items(left).id) & set(items(right).id) - set(items(before).id)
    here = page()
    follow(here, None, left)
    follow(here, left, right)
    assert here.items == shown(right)


def test_nothing_changed_is_no_frame():
    state = drawing(100)
    assert of_items(state, state, 1) is None and of_maps(state, state, 1) is None
    same = with_items(state, um=items(state).um.copy())
    assert of_items(state, same, 1) is None


def test_what_moved_costs_four_bytes_a_mark_and_a_stroke_costs_what_is_under_it():
    state = drawing(2000)
    here = page()
    follow(here, None, state)
    moved = do(state, "jitter", on="all")
    assert follow(here, state, moved) <= 2000 * 4 + 32
    assert follow(here, moved, state) <= 2000 * 4 + 32
    holes = do(state, "erase", path=way((20, 30)), size=4)
    follow(here, state, holes)
    assert follow(here, holes, do(holes, "jitter", on="all")) <= 2000 * 8 + 32  # their numbers do not follow each other
    follow(here, do(holes, "jitter", on="all"), state)
    assert follow(here, state, do(state, "erase", **BRUSH)) < 600  # some 65 marks of 4 bytes, and heads
    painted = do(state, "paint", **BRUSH)
    assert follow(here, state, painted) <= 16 + 32 + 12 * 12


@pytest.mark.parametrize("way_um", [-(2**15), -(2**15) + 1, 2**15 - 1, 2**15, 60_000])
def test_steps_near_and_over_what_two_bytes_hold_arrive(way_um):
    before = drawing(101)
    um = items(before).um.copy()
    um[0] = 40_000 if way_um < 0 else 1_000
    before = with_items(before, um=um)
    um = um.copy()
    um[0, 1] += way_um
    after = with_items(before, um=um)
    here = page()
    follow(here, None, before)
    follow(here, before, after)
    assert here.items == shown(after)


def test_lines_come_as_they_are():
    here = page()
    lines = Paths.of([[(0, 0), (1.5, 2)], [(3, 3), (4, 4), (5, 5.25)]], closed=False)
    here._take(of_lines(1, lines, 3))
    what, found = here.lines[0]
    assert what == 1 and [line.tolist() for line in found] == [path.tolist() for path in lines]
    here._take(of_lines(0, Paths.of([]), 3))
    assert here.lines[1][0] == 0


@pytest.mark.parametrize("seed", range(3))
def test_chance_edits_are_followed(seed):
    rng = np.random.default_rng(seed)
    here, state = page(), do(drawing(150), "layer add")
    follow(here, None, state)
    for _ in range(25):
        op, params = CHAIN[rng.integers(4)] if rng.random() < 0.5 else CHAIN[rng.integers(6, 10)]
        at = way(tuple(rng.uniform((10, 10), (70, 50))))
        params = {**params, "path": at} if params.get("path") and op not in ("select", "push") else params
        old, state = state, do(state, op, int(rng.integers(1000)), **params)
        follow(here, old, state)
        assert here.items == shown(state)


def test_the_digest_of_a_drawing_sees_a_micrometre():
    state = drawing(10)
    um = items(state).um.copy()
    um[3, 1] += 1
    assert digest(with_items(state, um=um)) != digest(state) == digest(replace(state))
