"""The exact partition of a canvas by power, and the signs and triangles it stands on."""

from fractions import Fraction

import numpy as np
import pytest
import shapely
from checks import check_areas, check_least_power, check_owners, check_partition_of, check_shared_edges, rounding, shape_of
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from test_cells import BOX, CANVASES, DEGENERATE, PLACES, areas, awkward, found, scattered

from crowquill import regular
from crowquill.cells import Cells, power, voronoi
from crowquill.exact import turn, under

SQUARE = np.array([(30.0, 3.0), (-3.0, 30.0), (-30.0, -3.0), (3.0, -30.0)])  # turns from x to y, far around (3, 2)
near = st.sampled_from([0.0, 0.1, 0.3, 1 / 3, 0.7, 1.0, np.nextafter(1, 2), np.nextafter(0.1, 0), 2.0, 3.0, 1e-9])
place = st.tuples(near, near)


def by_fractions(points: list, weights: list) -> Fraction:
    """The determinant of (x, y, x^2 + y^2 - weight) of three points less those of the fourth, in whole numbers."""
    rows = [
        [Fraction(x), Fraction(y), Fraction(x) ** 2 + Fraction(y) ** 2 - Fraction(w)] for (x, y), w in zip(points, weights, strict=True)
    ]
    (a, b, c), d = rows[:3], rows[3]
    a, b, c = ([one - other for one, other in zip(row, d, strict=True)] for row in (a, b, c))
    return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])


@found
@given(st.tuples(place, place, place))
def test_a_turn_has_the_sign_that_fractions_give_it(points: tuple) -> None:
    (ax, ay), (bx, by), (cx, cy) = [(Fraction(x), Fraction(y)) for x, y in points]
    true = (ax - cx) * (by - cy) - (ay - cy) * (bx - cx)
    assert np.sign(turn(np.array(points), 0, 1, 2)) == np.sign(float(true) or 0.0)


@found
@given(st.tuples(place, place, place, place), st.tuples(near, near, near, near))
def test_under_a_plane_is_what_fractions_find_there(points: tuple, weights: tuple) -> None:
    assert under(np.array(points), np.array(weights), 0, 1, 2, 3) == (by_fractions(list(points), list(weights)) > 0)


def test_floats_alone_get_such_signs_wrong() -> None:
    wrong = 0
    for i in range(16):
        for j in range(16):  # last bits off the line through the two others
            points = np.array([(0.5 + i * 2**-53, 0.5 + j * 2**-53), (12.0, 12.0), (24.0, 24.0)])
            (ax, ay), (bx, by), (cx, cy) = points
            wrong += np.sign((ax - cx) * (by - cy) - (ay - cy) * (bx - cx)) != np.sign(j - i)
            assert np.sign(turn(points, 0, 1, 2)) == np.sign(j - i)
    assert wrong > 50


@pytest.mark.parametrize("spread", [0.0, 0.1, 1.0, 10.0, 1000.0])
@pytest.mark.parametrize("n", [1, 2, 3, 10, 100, 1000])
def test_triangles_are_the_underside_of_qhulls_hull(n: int, spread: float) -> None:
    rng = np.random.default_rng(n)
    points = np.concatenate([rng.random((n, 2)) * (3, 2), SQUARE])
    weights = np.append(rng.random(n) * spread * 6 / n, np.zeros(4))
    hull = ConvexHull(np.column_stack([points, (points**2).sum(axis=1) - weights]))
    below = hull.simplices[hull.equations[:, 2] < 0]
    vertices, neighbours = regular.triangulated(points, weights)
    assert sorted(map(sorted, vertices.tolist())) == sorted(map(sorted, below.tolist()))
    for k in range(3):  # across each side lies a triangle with the same side walked back, or nothing
        other = neighbours[:, k]
        inner = np.flatnonzero(other >= 0)
        back = (neighbours[other[inner]] == inner[:, None]).argmax(axis=1)
        assert (vertices[other[inner], (back + 1) % 3] == vertices[inner, k]).all()
        assert (vertices[other[inner], back] == vertices[inner, (k + 1) % 3]).all()
    assert (neighbours < 0).sum() == 4  # the sides of the ring


def moved(scale: float, corner: float, sites: np.ndarray) -> tuple[np.ndarray, shapely.Geometry]:
    return np.asarray(sites, float) * scale + corner, shapely.transform(BOX, lambda xy: xy * scale + corner)


@pytest.mark.parametrize("where", PLACES)
@pytest.mark.parametrize("story", DEGENERATE)
def test_equal_weights_give_the_voronoi_cells(story: str, where: tuple[float, float]) -> None:
    sites, canvas = moved(*where, DEGENERATE[story])
    plain, weighted = voronoi(sites, canvas), power(sites, np.full(len(sites), 0.3), canvas)
    check_shared_edges(weighted)
    assert weighted.owner.tolist() == plain.owner.tolist() and weighted.pairs.tolist() == plain.pairs.tolist()
    np.testing.assert_allclose(areas(weighted), areas(plain), rtol=1e-9, atol=1e-12 * canvas.area)  # the triangles' order rounds


@pytest.mark.parametrize("canvas", CANVASES.values(), ids=CANVASES)
def test_equal_weights_give_the_voronoi_cells_in_any_canvas(canvas: shapely.Geometry) -> None:
    sites = scattered(11, 60, canvas)
    plain, weighted = voronoi(sites, canvas), power(sites, np.ones(60), canvas)
    assert weighted.owner.tolist() == plain.owner.tolist() and weighted.pairs.tolist() == plain.pairs.tolist()
    np.testing.assert_allclose(areas(weighted), areas(plain), rtol=1e-9)


@pytest.mark.parametrize("spread", [1e-6, 0.01, 1.0, 100.0, 1e12])
@pytest.mark.parametrize("story", DEGENERATE)
def test_degenerate_sites_have_sound_power_cells(story: str, spread: float) -> None:
    for where in PLACES:
        sites, canvas = moved(*where, DEGENERATE[story])
        weights = np.random.default_rng(1).random(len(sites)) * spread * where[0] ** 2
        cells = power(sites, weights, canvas)
        check_owners(cells)
        check_areas(cells)
        check_shared_edges(cells)
        check_least_power(cells, weights)


@pytest.mark.parametrize("canvas", CANVASES.values(), ids=CANVASES)
@found
@given(data=st.data())
def test_whatever_sites_and_weights_share_the_canvas(canvas: shapely.Geometry, data: st.DataObject) -> None:
    sites = data.draw(awkward(canvas))
    weights = np.array(data.draw(st.lists(st.sampled_from([0.0, 0.01, 0.25, 1.0, 7.0]), min_size=len(sites), max_size=len(sites))))
    joined, exact = power(sites, weights, canvas), power(sites, weights, canvas, joined=False)
    for cells in (joined, exact):
        check_owners(cells)
        check_areas(cells)
    check_least_power(exact, weights)


@pytest.mark.parametrize("canvas", CANVASES.values(), ids=CANVASES)
def test_every_place_belongs_to_the_site_of_least_power(canvas: shapely.Geometry) -> None:
    rng = np.random.default_rng(4)
    sites, weights, places = rng.random((80, 2)) * (3, 2), rng.random(80) * 0.2, scattered(5, 500, canvas)
    cells = power(sites, weights, canvas, joined=False)
    least = (((places[:, None] - sites) ** 2).sum(axis=2) - weights).argmin(axis=1)
    shapes = np.array([shape_of(cells, i) for i in range(80)])
    assert shapely.distance(shapes[least], shapely.points(places)).max() <= rounding(cells)
    check_partition_of(list(shapes), canvas)
    assert 10 < (areas(cells) == 0).sum() < 70  # there are hidden sites, and others


def test_the_border_of_two_sites_by_hand() -> None:
    cells = power([(1, 1), (2, 1)], [1.0, 0.5], BOX)
    # (x - 1)^2 - 1 = (x - 2)^2 - 0.5 at x = 1.75
    np.testing.assert_allclose([shape_of(cells, i).bounds for i in range(2)], [(0, 0, 1.75, 2), (1.75, 0, 3, 2)], atol=1e-14)
    assert cells.pairs.tolist() == [[0, 1]]
    np.testing.assert_allclose(np.sort(cells.borders[1][0], axis=0), [(1.75, 0), (1.75, 2)], atol=1e-14)
    assert power([(1, 1), (2, 1)], [1.0, 5.0], BOX).owner.tolist() == [1]  # at x = -0.5, beyond the canvas


def test_a_site_may_lie_in_anothers_cell_and_have_its_own_beyond() -> None:
    cells = power([(1, 1), (1.2, 1)], [0.0, -0.5], BOX)
    assert shape_of(cells, 0).contains(shapely.Point(1.2, 1)) and shape_of(cells, 1).bounds[0] == pytest.approx(2.35)


def test_of_coincident_sites_the_heaviest_has_the_cell_and_of_equals_the_first() -> None:
    cells = power([(1, 1), (2, 1), (1, 1), (2, 1), (1, 1)], [0.0, 0.3, 0.2, 0.3, 0.2], BOX)
    assert cells.owner.tolist() == [1, 2] and cells.pairs.tolist() == [[1, 2]]


def test_weights_that_all_rise_together_change_nothing() -> None:
    rng = np.random.default_rng(9)
    sites, weights = rng.random((50, 2)) * (3, 2), rng.random(50) * 0.1
    plain = areas(power(sites, weights, BOX))
    for more in (-3.0, 1e3, 1e6):
        np.testing.assert_allclose(areas(power(sites, weights + more, BOX)), plain, rtol=1e-7, atol=1e-9)  # weights keep 1e-10 of 1e6


def test_no_sites_and_one_site() -> None:
    assert len(power(np.zeros((0, 2)), [], BOX).owner) == 0 and power(np.zeros((0, 2)), [], BOX).borders[1].shape == (0, 2, 2)
    for canvas in CANVASES.values():
        assert shapely.equals(shape_of(power([(0.05, 0.05)], [-4.0], canvas), 0), canvas)


@pytest.mark.parametrize("weights", [[1.0], [1.0, np.nan], [1.0, np.inf], [[1.0, 2.0]], [1.0, 2.0, 3.0]])
def test_weights_that_do_not_fit_are_refused(weights: list) -> None:
    with pytest.raises(ValueError, match="weights has"):
        power([(1, 1), (2, 1)], weights, BOX)


@pytest.mark.parametrize("canvas", CANVASES.values(), ids=CANVASES)
def test_borders_are_as_long_as_the_sides_of_cells_within_the_canvas(canvas: shapely.Geometry) -> None:
    rng = np.random.default_rng(6)
    sites, weights = rng.random((60, 2)) * (3, 2), rng.random(60) * 0.05
    cells = power(sites, weights, canvas, joined=False)
    pairs, lines = cells.borders
    around = sum(shapely.length(shape_of(cells, i)) for i in range(60))
    assert 2 * np.hypot(*(lines[:, 1] - lines[:, 0]).T).sum() + shapely.length(canvas) == pytest.approx(around, rel=1e-9)
    middles = lines.mean(axis=1)
    powers = ((middles[:, None] - sites) ** 2).sum(axis=2) - weights
    for side in pairs.T:
        np.testing.assert_allclose(powers[np.arange(len(pairs)), side], powers.min(axis=1), atol=1e-12)


def test_twenty_thousand_power_cells_fill_the_canvas() -> None:
    rng = np.random.default_rng(1)
    cells: Cells = power(rng.random((20_000, 2)) * (3, 2), rng.random(20_000) * 3e-4, BOX)
    check_owners(cells)
    check_areas(cells)
    check_shared_edges(cells)
