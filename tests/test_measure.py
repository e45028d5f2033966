"""Ink as measured line by line is the area of the union that shapely makes of the same outlines."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
import shapely
from hypothesis import given
from hypothesis import settings as setting
from hypothesis import strategies as st

from crowquill import glyphs, measure
from crowquill.marks import Glyph, Marks
from crowquill.paths import Paths

Array = npt.NDArray[np.float64]
NIB = glyphs.load("nib-03").glyphs
DISC = glyphs.load("disc").glyphs
SQUARE = (Glyph.of(Paths.of([[(0, 0), (1, 0), (1, 1), (0, 1)]])),)
KINDS = pytest.mark.parametrize("shapes", [NIB, DISC, SQUARE], ids=["nib", "disc", "square"])
# Curves are measured as polygons inside them that have lost 2e-4 of their area, spans along lines err by 1e-4 more.
LOST = 3e-4


def scattered(shapes: tuple[Glyph, ...], n: int, seed: int, *, side: float = 10.0, scale: tuple[float, float] = (0.2, 1.0)) -> Marks:
    rng = np.random.default_rng(seed)
    return Marks.of(
        rng.uniform(0, side, (n, 2)),
        shapes,
        scale=rng.uniform(*scale, n),
        angle=rng.uniform(0, 7, n),
        glyph=rng.integers(len(shapes), size=n),
    )


def union(marks: Marks) -> shapely.Geometry:
    """What the marks cover, from outlines within 1e-6 of the curves."""
    return shapely.union_all(marks.outlines().flat(1e-6).polygons())


def by_pixel(shape: shapely.Geometry, size: tuple[float, float], grid: tuple[int, int]) -> Array:
    (h, w), (width, height) = grid, size
    row, column = np.indices(grid)
    dx, dy = width / w, height / h
    boxes = shapely.box(column * dx, row * dy, (column + 1) * dx, (row + 1) * dy)
    return np.asarray(shapely.area(shapely.intersection(boxes, shape)) / (dx * dy))


@KINDS
@pytest.mark.parametrize("diameter", [1e-6, 0.1, 0.3, 5.0, 1e6])
def test_the_ink_of_one_mark_is_its_own_area(shapes: tuple[Glyph, ...], diameter: float) -> None:
    mark = Marks.of([(3, 4)], shapes[:1], scale=diameter, angle=1.0)
    assert measure.ink(mark) == pytest.approx(diameter**2, rel=LOST)


@KINDS
@pytest.mark.parametrize("n", [2, 30, 1000])  # from marks apart to a page nearly black
def test_ink_is_the_area_of_the_union(shapes: tuple[Glyph, ...], n: int) -> None:
    marks = scattered(shapes, n, seed=n)
    assert measure.ink(marks) == pytest.approx(union(marks).area, rel=LOST)


def test_covering_a_mark_by_itself_adds_no_ink() -> None:
    marks = scattered(NIB, 50, seed=2)
    twice = marks.take(np.repeat(np.arange(50), 2))
    # lines are nearer together for more ink, hence not bit for bit
    assert measure.ink(twice) == pytest.approx(measure.ink(marks), rel=1e-4)


@KINDS
@given(st.integers(0, 2**32 - 1))
@setting(max_examples=15)
def test_each_pixel_is_covered_by_its_share_of_the_union(shapes: tuple[Glyph, ...], seed: int) -> None:
    rng = np.random.default_rng(seed)
    marks = scattered(shapes, int(rng.integers(1, 60)), seed, side=5, scale=(0.2, 1.5))
    size, grid = (5.0, 4.0), (8, 7)
    got = measure.rendered(marks, size, grid, pitch=0.004)
    # a pixel has 125 lines; a level border would err by 1 / 250, and borders of turned marks do by half of that at most
    np.testing.assert_allclose(got, by_pixel(union(marks), size, grid), atol=2e-3)
    assert got.mean() * 20 == pytest.approx(shapely.intersection(union(marks), shapely.box(0, 0, *size)).area, rel=1e-3)


def test_what_lies_over_the_edge_is_not_on_the_paper() -> None:
    corners = Marks.of([(0, 0), (3, 0), (0, 2), (3, 2), (1.5, 0)], DISC, scale=0.5)
    got = measure.rendered(corners, (3, 2), (2, 3), pitch=0.001)
    # a quarter of a disc of 0.25 mm^2 in each corner pixel of 1 mm^2, a half at the middle of the top
    np.testing.assert_allclose(got, [[0.0625, 0.125, 0.0625], [0.0625, 0, 0.0625]], atol=1e-4)  # a thousand lines a pixel
    assert measure.ink(corners) == pytest.approx(5 * 0.25, rel=LOST)  # ink itself is seen past the edge
    assert not measure.rendered(corners.moved((9, 9)), (3, 2), (2, 3)).any()


def test_a_pixel_inside_a_mark_is_full_and_one_outside_is_empty() -> None:
    got = measure.rendered(Marks.of([(5, 5)], SQUARE, scale=6.0), (10, 10), (10, 10))
    assert got[2:8, 2:8].tolist() == np.ones((6, 6)).tolist()
    assert got.sum() == 36


@KINDS
def test_a_crowd_too_great_for_shapely_has_the_ink_of_the_union(shapes: tuple[Glyph, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(measure, "JOINED", 100)
    marks = scattered(shapes, 1000, seed=4, side=18)
    assert measure.ink(marks) == pytest.approx(union(marks).area, rel=LOST)


def test_no_marks_are_no_ink() -> None:
    for marks in (Marks.of([], DISC, scale=1), Marks.of([], (), scale=1)):
        assert measure.ink(marks) == 0
        assert measure.rendered(marks, (2, 1), (1, 2)).tolist() == [[0, 0]]


@pytest.mark.parametrize("n", [1, 2])
def test_marks_of_no_size_are_no_ink(n: int) -> None:
    marks = Marks.of([(1, 0.5)] * n, DISC, scale=0)
    assert measure.ink(marks) == 0
    assert measure.rendered(marks, (2, 1), (1, 2)).tolist() == [[0, 0]]


def test_marks_of_no_size_among_others_do_not_matter() -> None:
    marks = Marks.of([(1, 1), (5, 5)], DISC, scale=[1, 0])
    assert measure.ink(marks) == pytest.approx(1, rel=LOST)


def test_the_measure_notices_a_mark_too_many() -> None:
    """The tolerance is fine enough: of a thousand marks apart, one more or one grown by a quarter is seen."""
    places = np.stack(np.meshgrid(np.arange(32), np.arange(32)), axis=-1).reshape(-1, 2)[:1000]
    marks = Marks.of(places, NIB, scale=0.3)
    true = union(marks).area
    assert measure.ink(marks) == pytest.approx(true, rel=LOST)
    assert measure.ink(Marks.of([*places, (40, 40)], NIB, scale=0.3)) != pytest.approx(true, rel=LOST)
    grown = np.where(np.arange(1000) == 7, 0.3 * 1.25, 0.3)
    assert measure.ink(Marks.of(places, NIB, scale=grown)) != pytest.approx(true, rel=LOST)


@pytest.mark.parametrize("seed", range(4))
def test_circles_that_meet_are_those_of_all_pairs(seed: int) -> None:
    rng = np.random.default_rng(seed)
    xy, reach = rng.random((300, 2)) * (100, 1 if seed == 3 else 60), rng.random(300) * 3
    apart = np.hypot(*(xy[:, None] - xy[None]).transpose(2, 0, 1)) + np.diag(np.full(300, np.inf))
    assert (measure.meeting(xy, reach) == (apart < reach[:, None] + reach).any(axis=1)).all()


def test_circles_at_one_place_and_a_single_one_are_told() -> None:
    assert measure.meeting(np.zeros((3, 2)), np.ones(3)).all()
    assert not measure.meeting(np.zeros((1, 2)), np.ones(1)).any()


def test_many_marks_measured_strip_by_strip_and_by_few_lines_cover_what_they_do_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    rng, n = np.random.default_rng(0), 6000
    discs = Marks.of(rng.random((n, 2)) * (60, 50), glyphs.load("nib-03").glyphs, scale=0.2 + 0.5 * rng.random(n))
    whole = measure.ink(discs)
    monkeypatch.setattr(measure, "MANY", 400)
    assert measure.ink(discs) == pytest.approx(whole, rel=1e-3)  # 3 % of a mark by four lines, over the root of their number
