"""Routes: all strokes once, little travel, and lines through points that cross nowhere."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise, permutations, product
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import shapely

from crowquill import Paths, route
from crowquill.route.crossings import crossings, turn

Array = npt.NDArray[np.float64]
SHORTEST = 0.7124  # sqrt(n A) of a shortest tour through many points at random; Johnson and McGeoch, 1996


def chance(*shape: int, seed: int = 0) -> Array:
    return np.random.default_rng(seed).random(shape)


def dots(xy: npt.ArrayLike) -> Array:
    return np.repeat(np.asarray(xy, np.float64).reshape(-1, 1, 2), 2, axis=1)


def links(xy: Array, path: npt.NDArray[np.int64], closed: bool) -> tuple[Array, Array]:
    a, b = xy[path], np.roll(xy[path], -1, axis=0)
    return (a, b) if closed else (a[:-1], b[:-1])


def length(xy: Array, path: npt.NDArray[np.int64], closed: bool) -> float:
    a, b = links(xy, path, closed)
    return float(np.hypot(*(b - a).T).sum())


def crossed(xy: Array, path: npt.NDArray[np.int64], closed: bool) -> int:
    """How many pairs of links cross, as shapely finds them."""
    lines = shapely.linestrings(np.stack(links(xy, path, closed), axis=1))
    return len(shapely.STRtree(lines).query(lines, predicate="crosses")[0]) // 2


LATTICE = np.stack(np.meshgrid(np.arange(31.0), np.arange(31.0)), axis=-1).reshape(-1, 2)
AWKWARD = {
    "none": np.zeros((0, 2)),
    "one": np.array([[3.0, 4.0]]),
    "two": np.array([[3.0, 4.0], [0.0, 1.0]]),
    "three in a row": np.array([[0.0, 0.0], [2.0, 0.0], [1.0, 0.0]]),
    "four of a square": np.array([[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]),
    "20 000 in one place": np.ones((20_000, 2)),
    "each thrice": np.repeat(chance(400, 2), 3, axis=0),
    "half of them in one place": np.concatenate([chance(3000, 2), np.full((3000, 2), 0.5)]),
    "in a row": chance(2000, 1) * (1.0, 0.0),
    "in a row aslant": np.floor(chance(2000, 1) * 999) * (1.0, 3.0),
    "on a lattice": LATTICE,
    "far off": chance(2000, 2) + 1e7,
    "tiny": chance(2000, 2) * 1e-9,
    "on a ring": np.stack([np.cos(np.arange(500.0)), np.sin(np.arange(500.0))], axis=1),
}


@pytest.mark.parametrize("name", AWKWARD)
def test_every_dot_is_drawn_once_and_on_the_shorter_way(name):
    strokes = dots(AWKWARD[name])
    found = route.order(strokes)
    assert sorted(found.index) == list(range(len(strokes))) and not found.turned.any()
    given = route.Order(np.arange(len(strokes)), np.zeros(len(strokes), bool))
    assert route.travel(strokes, found) <= route.travel(strokes, given) * (1 + 1e-9) + 1e-9


@pytest.mark.parametrize("closed", [False, True], ids=["open", "closed"])
@pytest.mark.parametrize("name", AWKWARD)
def test_every_point_is_passed_once_and_no_two_links_cross(name, closed):
    xy = AWKWARD[name]
    path = route.tour(xy, closed)
    assert sorted(path) == list(range(len(xy))) and (not closed or not len(xy) or path[0] == 0)
    places, which = np.unique(xy, axis=0, return_inverse=True)
    row = which[path]
    row = row[np.append(True, row[1:] != row[:-1])[: len(row)]]
    assert len(row) == len(places)  # what coincides follows each other
    if len(places) > 1 and "row" not in name:
        assert crossed(places, row, closed) == 0
        assert len(crossings(*links(places, row, closed))) == (1 if closed and len(places) == 2 else 0)


def test_a_row_is_passed_from_end_to_end_and_back():
    xy = AWKWARD["in a row"]
    span = float(np.ptp(xy[:, 0]))
    assert length(xy, route.tour(xy, False), False) == pytest.approx(span)
    assert length(xy, route.tour(xy), True) == pytest.approx(2 * span)


@pytest.mark.parametrize("closed", [False, True], ids=["open", "closed"])
def test_the_way_between_many_dots_is_within_an_eighth_of_the_shortest(closed):
    strokes = dots(chance(30_000, 2) * 300)
    found = route.order(strokes, closed)
    assert route.travel(strokes, found, closed) <= 1.12 * SHORTEST * np.sqrt(30_000 * 300**2)


@pytest.mark.parametrize("closed", [False, True], ids=["open", "closed"])
def test_a_line_through_random_points_is_short_and_crosses_nowhere(closed):
    xy = chance(20_000, 2) * 100
    path = route.tour(xy, closed)
    assert crossed(xy, path, closed) == 0
    assert length(xy, path, closed) <= 0.80 * np.sqrt(20_000 * 100**2)


def test_few_dots_are_drawn_in_the_best_order_or_nearly():
    """All 5040 orders of seven dots: a search that only mends cannot find the best every time; it is within a tenth, mostly at it."""
    over = []
    for seed in range(20):
        xy = chance(7, 2, seed=seed)
        stops = [(0.0, 0.0), *map(tuple, xy)]
        way = np.hypot(*(np.array(stops)[:, None] - np.array(stops)).transpose(2, 0, 1))
        best = min(sum(way[i, j] for i, j in pairwise((0, *order))) for order in permutations(range(1, 8)))
        over.append(route.travel(dots(xy), route.order(dots(xy))) / best)
    assert min(over) >= 1 - 1e-12 and max(over) < 1.1 and np.median(over) < 1 + 1e-9


def test_strokes_are_turned_where_that_is_shorter():
    """Lines across a page, all drawn from the left, side by side: the pen goes to and fro."""
    y = np.arange(50.0)
    strokes = np.stack([np.stack([0 * y, y], axis=1), np.stack([0 * y + 100, y], axis=1)], axis=1)[np.random.default_rng(0).permutation(50)]
    found = route.order(strokes)
    assert route.travel(strokes, found) == pytest.approx(49)
    assert (strokes[found.index, 0, 1] == y).all() and (found.turned == (y % 2 == 1)).all()


def test_travel_is_from_home_to_the_last_and_home_again_when_closed():
    strokes = np.array([[(1, 0), (2, 0)], [(5, 0), (3, 0)]])
    found = route.order(strokes)
    assert found.index.tolist() == [0, 1] and found.turned.tolist() == [False, True]
    assert route.travel(strokes, found) == 2 and route.travel(strokes, found, True) == 7
    far = route.order(strokes, home=(6, 0))
    assert far.index.tolist() == [1, 0] and far.turned.tolist() == [False, True]
    assert route.travel(strokes, far, home=(6, 0)) == 2
    assert route.travel(np.zeros((0, 2, 2)), route.order(np.zeros((0, 2, 2)))) == 0


def test_short_strokes_take_less_way_than_as_they_came():
    starts = chance(3000, 2) * 200
    strokes = np.stack([starts, starts + chance(3000, 2, seed=1) * 5 - 2.5], axis=1)
    found = route.order(strokes)
    assert sorted(found.index) == list(range(3000))
    assert 0.3 < found.turned.mean() < 0.7
    assert route.travel(strokes, found) < 0.8 * np.sqrt(3000 * 200**2)


def test_a_star_of_strokes_from_one_place_has_its_order_too():
    angle = np.linspace(0, 2 * np.pi, 20_000, endpoint=False)
    strokes = np.stack([np.zeros((20_000, 2)), np.stack([np.cos(angle), np.sin(angle)], axis=1)], axis=1)
    assert route.travel(strokes, route.order(strokes)) < 20  # mm; pi at best, out and in by turns, and 20 000 as they came


def test_rings_begin_where_the_pen_comes_by():
    x = np.array([0.0, 10.0, 20.0])
    rings = Paths.of([[(a + 1, 1), (a + 1, -1), (a - 1, -1), (a - 1, 1)] for a in x])

    def way(corners: Any) -> float:
        stops = np.array([(0.5, -3), *(rings[k][corner] for k, corner in enumerate(corners))])
        return float(np.hypot(*np.diff(stops, axis=0).T).sum())

    best = min(way(corners) for corners in product(range(4), repeat=3))
    assert way(route.begun(rings, [0, 1, 2], home=(0.5, -3))) == pytest.approx(best, rel=0.02)  # each mends its own place only
    assert way((0, 0, 0)) > 1.05 * best
    assert (route.begun(rings.curved(), [2, 1, 0], home=(25, 3)) % 3 == 0).all()
    assert route.begun(Paths.of([]), []).tolist() == []
    with pytest.raises(ValueError, match="closed paths"):
        route.begun(Paths.of([[(0, 0), (1, 1)]], closed=False), [0])


def test_the_same_strokes_give_the_same_route_and_moved_ones_the_same_length():
    strokes = chance(5000, 2, 2)
    one, same = route.order(strokes), route.order(strokes)
    assert (one.index == same.index).all() and (one.turned == same.turned).all()
    assert (route.tour(strokes[:, 0]) == route.tour(strokes[:, 0].copy())).all()
    xy = strokes[:, 0]
    lengths = [length(p, route.tour(p), True) for p in (xy, xy[::-1], xy[:, ::-1] * 3 + 7)]
    assert lengths[1] == pytest.approx(lengths[0], rel=0.02)  # as good, though not the same way
    assert lengths[2] == pytest.approx(3 * lengths[0], rel=0.02)


@pytest.mark.parametrize("bad", [np.zeros((3, 2)), np.full((1, 2, 2), np.nan), [[[0, 0]]]], ids=["points", "nan", "one end"])
def test_what_is_no_list_of_ends_is_refused(bad):
    with pytest.raises(ValueError, match="ends"):
        route.order(bad)
    with pytest.raises(ValueError, match="points"):
        route.tour(np.full((2, 2), np.inf))
    with pytest.raises(ValueError, match="home"):
        route.order(np.zeros((1, 2, 2)), home=(np.nan, 0))


def test_the_side_of_a_point_is_what_fractions_say():
    rng = np.random.default_rng(3)
    flat = 0
    for _ in range(500):
        a, b = rng.random((2, 2))
        p = a + (b - a) * rng.random() if rng.random() < 0.8 else a + 3 * (b - a)
        (ax, ay), (bx, by), (px, py) = ([Fraction(float(v)) for v in place] for place in (a, b, p))
        exact = (bx - ax) * (py - ay) - (by - ay) * (px - ax)
        assert turn(*a, *b, *p) == (exact > 0) - (exact < 0)
        flat += (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) == 0 and exact != 0
    assert flat > 10  # where plain floats say that it lies on the line, and it does not


def test_crossings_are_those_of_shapely_and_touches_are_seen():
    ends = chance(400, 2, 2)
    ends[200:, 1] = ends[200:, 0] + (ends[200:, 1] - 0.5) * 0.05
    lines = shapely.linestrings(ends)
    i, j = shapely.STRtree(lines).query(lines, predicate="crosses")
    assert crossings(ends[:, 0], ends[:, 1]).tolist() == sorted([a, b] for a, b in zip(i.tolist(), j.tolist(), strict=True) if a < b)
    a, b = np.array([(0, 0), (1, 1), (4, 0), (2, 5)], float), np.array([(4, 0), (2, 0), (4, 3), (2, 5)], float)
    assert crossings(a, b).tolist() == [[0, 1]]  # an end inside the first; a common end, and a link of no length, are none
    again = np.array([[0, 0], [0, 0], [3, 0]], float)
    assert crossings(again, np.array([[2, 0], [2, 0], [1, 0]], float)).tolist() == [[0, 1], [0, 2], [1, 2]]


def test_the_crossing_count_sees_a_line_that_crosses():
    xy = AWKWARD["four of a square"]
    assert crossed(xy, np.arange(4), True) == 1 and len(crossings(*links(xy, np.arange(4), True))) == 1
    rough = chance(500, 2)
    assert crossed(rough, np.arange(500), False) == len(crossings(*links(rough, np.arange(500), False))) > 1000
