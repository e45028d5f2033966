"""Many rings or lines in one pair of arrays."""

import numpy as np
import pytest
import shapely
from checks import check_paths
from hypothesis import given, settings
from hypothesis import strategies as st

from crowquill.paths import Paths

SQUARE = [(0, 0), (2, 0), (2, 2), (0, 2)]
TRIANGLE = [(5, 5), (6, 5), (5, 6)]
KAPPA = 4 / 3 * (np.sqrt(2) - 1)  # a quarter circle as one cubic
QUARTER = np.array([(1, 0), (1, KAPPA), (KAPPA, 1)])
CIRCLE = np.concatenate([QUARTER @ np.array([[c, s], [-s, c]]) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))])
coordinate = st.floats(-1e6, 1e6).map(lambda x: round(x, 3))
ragged = st.lists(st.lists(st.tuples(coordinate, coordinate), max_size=7), max_size=6)
found = settings(max_examples=80)


def star(rng: np.random.Generator, corners: int) -> np.ndarray:
    """A polygon about the origin that sees its middle from everywhere, turning from x to y."""
    angle = (np.arange(corners) + rng.uniform(0, 0.9, corners)) * 2 * np.pi / corners
    return rng.uniform(0.2, 1, corners)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


@found
@given(ragged)
def test_what_goes_in_as_lists_comes_out_as_the_same_lists(lists: list[list[tuple[float, float]]]) -> None:
    paths = Paths.of(lists, closed=False)
    check_paths(paths)
    assert len(paths) == len(lists)
    assert [part.tolist() for part in paths] == [[list(p) for p in part] for part in lists]
    assert paths.path.tolist() == [i for i, part in enumerate(lists) for _ in part]


@found
@given(ragged, st.data())
def test_take_gives_these_paths_in_this_order(lists: list[list[tuple[float, float]]], data: st.DataObject) -> None:
    paths = Paths.of(lists, closed=False)
    which = data.draw(st.lists(st.integers(0, len(lists) - 1), max_size=8) if lists else st.just([]))
    taken = paths.take(which)
    check_paths(taken)
    assert [part.tolist() for part in taken] == [paths[i].tolist() for i in which]
    assert (taken.closed, taken.cubic) == (paths.closed, paths.cubic)


def test_an_index_that_is_not_there_is_never_an_empty_path() -> None:
    paths = Paths.of([SQUARE, TRIANGLE])
    for i in (-1, 2, -3):
        try:
            part = paths[i]
        except IndexError:
            continue
        assert i in (-1, -2) and part.tolist() == [list(map(float, p)) for p in (SQUARE, TRIANGLE)[i]]


def test_arrays_are_copied_and_cannot_be_written() -> None:
    xy, start = np.array(SQUARE, float), np.array([0, 4])
    paths = Paths(xy, start)
    xy[0], start[1] = 99, 3
    assert paths[0].tolist() == [list(map(float, p)) for p in SQUARE]
    for array in (paths.xy, paths.start):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


@pytest.mark.parametrize(
    ("xy", "start", "options", "words"),
    [
        ([(0, 0, 0)], [0, 1], {}, "xy has shape"),
        ([0, 1], [0, 1], {}, "xy has shape"),
        ([(0, np.nan)], [0, 1], {}, "xy has a value that is not finite"),
        ([(0, np.inf)], [0, 1], {}, "xy has a value that is not finite"),
        (SQUARE, [[0, 4]], {}, "start has shape"),
        (SQUARE, [], {}, "start must rise from 0 to 4"),
        (SQUARE, [1, 4], {}, "start must rise from 0 to 4"),
        (SQUARE, [0, 3], {}, "start must rise from 0 to 4"),
        (SQUARE, [0, 3, 2, 4], {}, "start must rise from 0 to 4"),
        (SQUARE, [0, 4], {"cubic": True}, "a cubic ring has 3k points"),
        (SQUARE[:3], [0, 3], {"cubic": True, "closed": False}, r"a cubic line has 3k \+ 1 points"),
    ],
)
def test_wrong_arrays_are_refused_by_name(xy: list, start: list, options: dict, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Paths(np.array(xy, float), np.array(start), **options)


def test_no_paths_and_empty_paths_have_answers() -> None:
    none, empty = Paths.of([]), Paths.of([[], SQUARE, []])
    assert len(none) == 0 and none.areas.shape == (0,) and none.green().shape == (0, 6) and none.polygons().shape == (0,)
    assert len(none.take([])) == 0 and len(none.moved(np.eye(2))) == 0
    assert empty.areas.tolist() == [0, 4, 0]
    assert [p.is_empty for p in empty.polygons()] == [True, False, True]
    assert empty.green()[[0, 2]].tolist() == [[0.0] * 6] * 2


def test_area_is_positive_when_x_turns_towards_y() -> None:
    rings = Paths.of([SQUARE, SQUARE[::-1], TRIANGLE, [(0, 0), (1, 1)], [(3, 3)]])
    assert rings.areas.tolist() == [4, -4, 0.5, 0, 0]


@found
@given(st.integers(0, 10**6), st.integers(3, 40), st.sampled_from([1e-6, 1.0, 1e6]))
def test_areas_are_shapelys_at_every_size(seed: int, corners: int, size: float) -> None:
    ring = star(np.random.default_rng(seed), corners) * size
    rings = Paths.of([ring, ring[::-1]])
    area = shapely.Polygon(ring).area
    # 40 roundings of 1e-16, against an area that may be a hundredth of the box
    np.testing.assert_allclose(rings.areas, [area, -area], rtol=1e-12)
    np.testing.assert_allclose(rings.green()[:, 0], [area, -area], rtol=1e-12)


def test_moved_turns_shears_and_shifts_every_point() -> None:
    paths = Paths.of([SQUARE, TRIANGLE])
    matrix, offset = [[0, -3], [2, 1]], (10, 20)
    moved = paths.moved(matrix, offset)
    assert moved.xy.tolist() == (paths.xy @ np.transpose(matrix) + offset).tolist()  # small whole numbers: exact
    assert moved.areas.tolist() == [4 * 6, 0.5 * 6]  # by the determinant
    assert paths.moved([[-1, 0], [0, 1]]).areas.tolist() == [-4, -0.5]  # a flip turns rings round


@found
@given(st.integers(0, 10**6))
def test_moved_there_and_back_is_the_same(seed: int) -> None:
    rng = np.random.default_rng(seed)
    paths, matrix, offset = Paths.of([rng.random((9, 2))]), rng.random((2, 2)) + np.eye(2), rng.random(2)
    back = np.linalg.inv(matrix)
    again = paths.moved(matrix, offset).moved(back, -back @ offset)
    np.testing.assert_allclose(again.xy, paths.xy, atol=1e-13)  # a dozen roundings of numbers below 4


def test_a_point_moves_alike_whatever_travels_with_it() -> None:
    points = np.random.default_rng(1).random((101, 2))
    turn = np.array([[np.cos(1), -np.sin(1)], [np.sin(1), np.cos(1)]])
    together = Paths.of([points]).moved(turn, (0.1, 0.2)).xy
    assert all((Paths.of([[p]]).moved(turn, (0.1, 0.2)).xy == q).all() for p, q in zip(points, together, strict=True))


def test_four_cubics_make_a_circle_within_their_known_error() -> None:
    circle = Paths.of([CIRCLE], cubic=True)
    by_hand = 4 * (10 + 12 * KAPPA - 3 * KAPPA**2) / 20  # (x dy - y dx) / 2 along (1, 0), (1, k), (k, 1), (0, 1)
    assert circle.areas[0] == pytest.approx(by_hand, rel=1e-14)  # Gauss is exact: rounding only
    assert circle.areas[0] == pytest.approx(np.pi, rel=5.5e-4)  # radial error of this cubic: up to 2.7e-4, outwards
    assert circle.areas[0] > np.pi
    back = Paths.of([np.roll(CIRCLE[::-1], 1, axis=0)], cubic=True)
    assert back.areas[0] == pytest.approx(-by_hand, rel=1e-14)


@pytest.mark.parametrize("closed", [True, False])
@pytest.mark.parametrize("tolerance", [0.1, 1e-3, 1e-6])
def test_flat_strays_no_further_than_it_says(tolerance: float, closed: bool) -> None:
    rng = np.random.default_rng(7)
    points = [rng.random((3 * k + (not closed), 2)) * 10 for k in (1, 2, 5)]
    curves = Paths.of([points[0], [], *points[1:]], cubic=True, closed=closed)
    flat = curves.flat(tolerance)
    check_paths(flat)
    assert (flat.cubic, flat.closed, len(flat)) == (False, closed, 4) and len(flat[1]) == 0
    t = np.linspace(0, 1, 50)[:, None]
    for curve, line in zip(curves, flat, strict=True):
        if not len(curve):
            continue
        ends = np.concatenate([curve, curve[:1]]) if closed else curve
        exact = np.concatenate(
            [
                (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d
                for a, b, c, d in ((ends[k : k + 4]) for k in range(0, len(ends) - 1, 3))
            ]
        )
        drawn = shapely.linearrings(line) if closed else shapely.linestrings(line)
        assert shapely.distance(shapely.points(exact), drawn).max() <= tolerance
        anchors = ends[::3]
        assert {tuple(p) for p in anchors} <= {tuple(p) for p in line}  # anchors are met bit for bit


def test_flat_leaves_straight_paths_as_they_are() -> None:
    paths = Paths.of([SQUARE])
    assert paths.flat(0.1) is paths


def test_flat_keeps_a_cubic_line_of_one_point() -> None:
    line = Paths.of([[(1, 2)], [(0, 0), (1, 0), (1, 1), (2, 1)]], closed=False, cubic=True)
    assert line.flat(0.1)[0].tolist() == [[1.0, 2.0]]


@pytest.mark.parametrize("tolerance", [0.0, -1.0, float("nan")])
def test_flat_takes_a_tolerance_over_zero_only(tolerance: float) -> None:
    with pytest.raises(ValueError, match="tolerance"):
        Paths.of([CIRCLE], cubic=True).flat(tolerance)


@found
@given(st.integers(0, 10**6), st.integers(1, 5))
def test_polygons_there_and_back_are_the_same_rings(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    rings = Paths.of([star(rng, int(rng.integers(3, 20))) + 3 * i for i in range(n)])
    again, polygon = Paths.of_polygons(rings.polygons())
    check_paths(again)
    assert polygon.tolist() == list(range(n))
    assert shapely.equals_exact(shapely.normalize(again.polygons()), shapely.normalize(rings.polygons())).all()


def test_holes_turn_the_other_way_and_know_their_polygon() -> None:
    frame = shapely.box(0, 0, 4, 4).difference(shapely.box(1, 1, 2, 2)).difference(shapely.box(2.5, 2.5, 3, 3))
    pair = shapely.MultiPolygon([shapely.box(10, 0, 11, 1), shapely.box(12, 0, 14, 1)])
    # as given, and with every ring walked the other way
    for polygons in ([frame, pair], [shapely.reverse(frame), shapely.reverse(pair)]):
        rings, polygon = Paths.of_polygons(polygons)
        check_paths(rings)
        assert polygon.tolist() == [0, 0, 0, 1, 1]
        first, *holes = rings.areas[:3].tolist()
        assert first == 16 and sorted(holes) == [-1, -0.25] and rings.areas[3:].tolist() == [1, 2]


def test_empty_polygons_have_no_rings_and_shift_nobodys_index() -> None:
    rings, polygon = Paths.of_polygons([shapely.Polygon(), shapely.box(0, 0, 1, 1), shapely.Polygon(), shapely.box(2, 0, 4, 1)])
    assert polygon.tolist() == [1, 3] and rings.areas.tolist() == [1, 2]
    none, nobody = Paths.of_polygons([])
    assert len(none) == len(nobody) == 0


def test_rings_of_fewer_than_three_points_are_empty_polygons() -> None:
    polygons = Paths.of([[], [(0, 0)], [(0, 0), (1, 1)], TRIANGLE]).polygons()
    assert [p.is_empty for p in polygons] == [True, True, True, False]
    assert polygons[3].area == 0.5
