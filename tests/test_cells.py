"""The exact partition of a canvas among sites: facts first, then relations, other roads and small cases by hand."""

import numpy as np
import pytest
import shapely
from checks import (
    check_areas,
    check_cells,
    check_handed_over,
    check_homes,
    check_nearest,
    check_owners,
    check_partition_of,
    check_shared_edges,
    rounding,
    shape_of,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Voronoi

from crowquill.cells import Cells, voronoi

BOX = shapely.box(0, 0, 3, 2)
CANVASES = {
    "rectangle": BOX,
    "concave": shapely.Polygon([(0, 0), (3, 0), (3, 2), (1.5, 0.2), (0, 2)]),
    "holes": BOX.difference(shapely.box(1, 0.5, 2, 1.5)).difference(shapely.Polygon([(0.1, 0.1), (0.2, 0.1), (0.2, 0.3)])),
    "islands": shapely.MultiPolygon([shapely.Point(0.5, 0.5).buffer(0.4), shapely.Point(2, 0.5).buffer(0.4), shapely.box(1, 1.2, 2.5, 2)]),
    "comb": shapely.union_all([shapely.box(0, 0, 3, 0.1), *(shapely.box(0.3 * i, 0, 0.3 * i + 0.1, 2) for i in range(10))]),
}
FACTS = [check_owners, check_areas, check_homes, check_nearest, check_shared_edges, check_handed_over]
PLACES = [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 1e4), (100.0, 1e4)]  # scale, and mm of the canvas's corner from the origin
found = settings(max_examples=40)

rng = np.random.default_rng(5)
turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
angle = np.arange(12)[:, None] * np.pi / 6
circle = (1.5, 1) + 0.8 * np.hstack([np.cos(angle), np.sin(angle)])
grid = np.stack(np.meshgrid(0.3 + 0.3 * np.arange(9), 0.2 + 0.8 / 3 * np.arange(7)), axis=-1).reshape(-1, 2)
some = rng.random((30, 2)) * (3, 2)
DEGENERATE = {
    "one site": [(1, 1)],
    "two sites": [(1, 1), (2, 1)],
    "a row: no triangle has an area": [(0.1 * i, 1) for i in range(1, 30)],
    "a slanting row: collinear but for rounding": np.linspace((0.1, 0.1), (2.9, 1.7), 20),
    "a row that wavers by 1e-15: triangles thinner than floats": np.linspace((0.1, 1), (2.9, 1), 20) + 1e-15 * rng.random((20, 2)),
    "all coincident": [(1.1, 0.7)] * 10,
    "some coincident, not side by side": np.concatenate([some[:10], some[:5], some[:10]]),
    "a grid: four sites on every circle": grid,
    "a turned grid: four on every circle but for rounding": (grid - (1.5, 1)) @ turn * 0.7 + (1.5, 1),
    "a circle: all cells meet in one point": circle,
    "a wheel: a hub and its rim": np.concatenate([[(1.5, 1)], circle]),
    "on the border and in the corners": [(0, 0), (3, 0), (3, 2), (0, 2), (1, 0), (3, 1), (2, 2), (0, 1)],
    "outside, all on one side": rng.random((10, 2)) + 5,
    "inside and outside": rng.random((50, 2)) * (6, 4) - (1.5, 1),
    "a cluster a millionth of the canvas wide": (1.7, 0.9) + 1e-6 * rng.random((40, 2)),
    "a cluster a million millionth wide among others": np.concatenate([(1.7, 0.9) + 1e-12 * rng.random((10, 2)), some]),
    "neighbours in floats": [(1, 1), (np.nextafter(1, 2), 1), (1, np.nextafter(1, 2)), *some],
    "one site a thousand canvases away": [(1, 1), (1.1, 1), (3000, 1)],
    "nought and minus nought are one place": [(0.0, 0.0), (-0.0, 0.0), (1, 1)],
}


def at(scale: float, corner: float, sites: np.ndarray, canvas: shapely.Geometry) -> Cells:
    return voronoi(np.asarray(sites, float) * scale + corner, shapely.transform(canvas, lambda xy: xy * scale + corner))


def areas(cells: Cells) -> np.ndarray:
    return np.bincount(cells.owner, cells.rings.areas, len(cells.sites))


def scattered(seed: int, n: int, canvas: shapely.Geometry) -> np.ndarray:
    """n sites at random in the canvas, which lies in 3 by 2 mm."""
    sites = np.random.default_rng(seed).random((60 * n, 2)) * (3, 2)  # no canvas here is under a twentieth of its box
    return sites[shapely.contains_xy(canvas, *sites.T)][:n]


@st.composite
def awkward(draw: st.DrawFn, canvas: shapely.Geometry) -> np.ndarray:
    """Up to 40 sites in the canvas: on a lattice of quarters, hence in rows, circles and heaps, or by the micrometre."""
    place = st.tuples(st.integers(0, 12).map(lambda i: i / 4), st.integers(0, 8).map(lambda i: i / 4))
    free = st.tuples(st.integers(0, 3000).map(lambda i: i / 1000), st.integers(0, 2000).map(lambda i: i / 1000))
    n, kind = draw(st.integers(1, 40)), draw(st.sampled_from([place, free, st.one_of(place, free)]))
    sites = np.array(draw(st.lists(kind, min_size=n, max_size=n)))
    return sites[shapely.intersects_xy(canvas, *sites.T)]


@pytest.mark.parametrize("check", FACTS)
@pytest.mark.parametrize("canvas", CANVASES.values(), ids=CANVASES)
@found
@given(data=st.data())
def test_facts_hold_for_whatever_sites_in_the_canvas(check, canvas: shapely.Geometry, data: st.DataObject) -> None:
    scale, corner = data.draw(st.sampled_from(PLACES))
    check(at(scale, corner, data.draw(awkward(canvas)), canvas))


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("story", DEGENERATE)
def test_degenerate_sites_have_sound_cells(story: str, place: tuple[float, float]) -> None:
    check_cells(at(*place, DEGENERATE[story], BOX))


@pytest.mark.parametrize("canvas", CANVASES.values(), ids=CANVASES)
def test_a_hundred_thousand_cells_fill_the_canvas(canvas: shapely.Geometry) -> None:
    sites = np.random.default_rng(1).random((100_000, 2)) * (3, 2)
    cells = voronoi(sites[shapely.contains_xy(canvas, *sites.T)], canvas)
    check_owners(cells)
    check_areas(cells)
    check_shared_edges(cells)


@pytest.mark.parametrize("canvas", CANVASES.values(), ids=CANVASES)
def test_sites_in_holes_and_bays_take_nothing_outside_the_canvas(canvas: shapely.Geometry) -> None:
    cells = voronoi(np.random.default_rng(2).random((400, 2)) * (3, 2), canvas)
    check_areas(cells)
    check_partition_of([shape_of(cells, i) for i in range(400)], canvas)


@pytest.mark.parametrize("canvas", CANVASES.values(), ids=CANVASES)
def test_cells_do_not_overlap_and_leave_no_gap(canvas: shapely.Geometry) -> None:
    cells = voronoi(scattered(3, 60, canvas), canvas)
    check_partition_of([shape_of(cells, i) for i in range(60)], canvas)


def test_every_place_belongs_to_its_nearest_site() -> None:
    sites, places = scattered(4, 300, BOX), scattered(5, 3000, BOX)
    cells = voronoi(sites, BOX)
    nearest = np.hypot(*(places[:, None] - sites).T).T.argmin(axis=1)
    rings = cells.rings.polygons()[np.searchsorted(cells.owner, nearest)]
    assert shapely.distance(rings, shapely.points(places)).max() <= rounding(cells)


@pytest.mark.parametrize("n", [2, 3, 7, 50, 400])
def test_cells_and_pairs_are_those_of_mirrored_qhull(n: int) -> None:
    sites = scattered(n, n, BOX)
    # the bisectors to sites mirrored in the four sides are the sides: Qhull's open diagram comes out clipped
    mirrored = [sites, sites * (-1, 1), sites * (1, -1), (6, 0) - sites * (1, -1), (0, 4) - sites * (-1, 1)]
    net = Voronoi(np.concatenate(mirrored))
    cells = voronoi(sites, BOX)
    oracle = np.sort(net.ridge_points[(net.ridge_points < n).all(axis=1)], axis=1)
    assert cells.pairs.tolist() == sorted(oracle.tolist())
    theirs = [shapely.convex_hull(shapely.MultiPoint(net.vertices[net.regions[net.point_region[i]]])).area for i in range(n)]
    np.testing.assert_allclose(areas(cells), theirs, rtol=1e-9, atol=1e-12)  # mm^2; Qhull keeps 1e-15 of its box


@pytest.mark.parametrize("canvas", CANVASES.values(), ids=CANVASES)
def test_pairs_are_those_whose_common_border_runs_on_the_canvas(canvas: shapely.Geometry) -> None:
    sites = scattered(6, 40, canvas)
    # the same sites' cells in the rectangle, cut by shapely: parts are not handed over
    plain = voronoi(sites, BOX)
    shapes = shapely.intersection(np.array([shape_of(plain, i) for i in range(40)]), canvas)
    i, j = np.triu_indices(40, 1)
    common = shapely.length(shapely.intersection(shapely.buffer(shapes[i], 1e-9), shapely.boundary(shapes[j])))
    touching = common > 1e-6  # mm: two buffers of a point are 4e-9 long, the shortest of these borders over 1e-4
    assert voronoi(sites, canvas).pairs.tolist() == np.stack([i, j], axis=1)[touching].tolist()


@pytest.mark.parametrize(
    ("matrix", "story"),
    [
        ([[0, -1], [1, 0]], "a quarter turn"),
        ([[-1, 0], [0, -1]], "half a turn"),
        ([[-1, 0], [0, 1]], "a flip"),
        ([[0, 1], [1, 0]], "a flip about the diagonal"),
        (0.7 * turn, "a turn by 0.3, smaller"),
        ([[1e5, 0], [0, 1e5]], "a hundred thousand times"),
    ],
)
@pytest.mark.parametrize("canvas", CANVASES.values(), ids=CANVASES)
def test_cells_turn_flip_and_scale_with_their_sites(canvas: shapely.Geometry, matrix: list, story: str) -> None:
    sites, matrix = scattered(7, 50, canvas), np.array(matrix)
    plain = voronoi(sites, canvas)
    moved = voronoi(sites @ matrix.T, shapely.transform(canvas, lambda xy: xy @ matrix.T))
    assert moved.pairs.tolist() == plain.pairs.tolist(), story
    factor = abs(np.linalg.det(matrix))
    # circle centres round at 1e-16 of the canvas, thin triangles a thousand times that
    np.testing.assert_allclose(areas(moved), areas(plain) * factor, rtol=1e-9, atol=1e-12 * canvas.area * factor)


@pytest.mark.parametrize("canvas", CANVASES.values(), ids=CANVASES)
def test_cells_follow_their_sites_when_these_are_shuffled(canvas: shapely.Geometry) -> None:
    sites = scattered(8, 50, canvas)
    order = np.random.default_rng(8).permutation(50)
    plain, shuffled = voronoi(sites, canvas), voronoi(sites[order], canvas)
    np.testing.assert_allclose(areas(shuffled), areas(plain)[order], rtol=1e-9)  # other triangles, other roundings
    place = np.argsort(order)
    assert sorted(np.sort(place[plain.pairs], axis=1).tolist()) == shuffled.pairs.tolist()


def test_one_site_has_the_whole_canvas() -> None:
    for canvas in CANVASES.values():
        cells = voronoi([(0.05, 0.05)], canvas)
        assert shapely.equals(shape_of(cells, 0), canvas) and len(cells.pairs) == 0


def test_two_sites_share_at_the_middle() -> None:
    cells = voronoi([(2, 1), (1, 1)], BOX)
    assert cells.pairs.tolist() == [[0, 1]]
    np.testing.assert_allclose([shape_of(cells, i).bounds for i in range(2)], [(1.5, 0, 3, 2), (0, 0, 1.5, 2)], atol=1e-14)


def test_of_coincident_sites_the_first_has_the_cell() -> None:
    cells = voronoi([(1, 1), (2, 1), (1, 1), (2, 1), (1, 1)], BOX)
    assert cells.owner.tolist() == [0, 1] and cells.first.tolist() == [0, 1, 2, 2, 2, 2] and cells.pairs.tolist() == [[0, 1]]


@pytest.mark.parametrize("place", PLACES)
def test_however_many_sites_on_a_circle_share_its_middle(place: tuple[float, float]) -> None:
    for n in range(3, 43):
        around = np.arange(n)[:, None] * 2 * np.pi / n + n  # turned, so that each n rounds in its own way
        cells = at(*place, (1.5, 1) + 0.02 * n * np.hstack([np.cos(around), np.sin(around)]), BOX)
        check_owners(cells)
        check_shared_edges(cells)
        assert len(cells.pairs) == n  # neighbours on the circle; across its middle no edge runs


def test_cells_that_meet_in_one_point_are_no_pair() -> None:
    assert voronoi([(0.5, 0.5), (1.5, 0.5), (0.5, 1.5), (1.5, 1.5)], BOX).pairs.tolist() == [[0, 1], [0, 2], [1, 3], [2, 3]]


def test_a_part_across_a_bay_goes_to_whom_it_touches() -> None:
    horseshoe = shapely.box(0, 0, 3, 3).difference(shapely.box(1, 0, 2, 2))
    cells = voronoi([(0.5, 0.5), (2.5, 2.9)], horseshoe)
    # by distance the top of the right arm is the left site's, down to the bisector from (2, 1.28) to (3, 0.45)
    check_handed_over(cells)
    assert shape_of(cells, 0).bounds[2] <= 2 and shape_of(cells, 1).bounds[1] == 0


@pytest.mark.parametrize(
    ("teeth", "sites"),
    [
        (4, [(2.5, 4), (1, 0.5), (6.5, 7), (6.5, 6.5)]),
        (5, [(6, 0.5), (2.5, 6), (2.5, 6.5), (4.5, 3.5)]),
    ],
)
def test_a_part_behind_another_part_finds_its_way(teeth: int, sites: list) -> None:
    rake = shapely.union_all([shapely.box(0, 0, 9, 1), *(shapely.box(2 * i, 0, 2 * i + 1, 8) for i in range(teeth))])
    check_handed_over(voronoi(sites, rake))


@pytest.mark.parametrize(
    "sites",
    [[(0.63, 3.13), (0.73, 1.43), (2.53, 7.93), (2.03, 0.03)], [(0.83, 0.33), (0.63, 0.83), (2.83, 6.73), (0.23, 2.63)]],
)
def test_who_gets_a_part_does_not_depend_on_the_order_of_sites(sites: list) -> None:
    fork = shapely.union_all([shapely.box(0, 0, 3, 1), shapely.box(0, 0, 1, 8), shapely.box(2, 0, 3, 8)])
    np.testing.assert_allclose(areas(voronoi(sites, fork)), areas(voronoi(sites[::-1], fork))[::-1], rtol=1e-9)  # roundings


@pytest.mark.parametrize("seed", range(60))
def test_in_a_comb_every_cell_holds_together(seed: int) -> None:
    cells = voronoi(scattered(seed, 3 + seed % 6, CANVASES["comb"]), CANVASES["comb"])
    check_handed_over(cells)
    check_homes(cells)


def test_an_island_without_a_site_is_still_given_away() -> None:
    cells = voronoi([(0.5, 0.5), (0.6, 0.5)], CANVASES["islands"])
    check_areas(cells)
    assert shapely.intersects(shape_of(cells, 1), shapely.box(1, 1.2, 2.5, 2))


def test_no_sites_give_no_cells() -> None:
    cells = voronoi(np.zeros((0, 2)), BOX)
    assert (len(cells.rings), len(cells.owner), cells.pairs.shape, cells.first.tolist()) == (0, 0, (0, 2), [0])


def test_a_site_without_a_cell_keeps_its_number() -> None:
    cells = voronoi([(50, 50), (1, 1), (60, 50)], BOX)
    assert cells.owner.tolist() == [1] and cells.first.tolist() == [0, 0, 1, 1]


@pytest.mark.parametrize("sites", [[(0, np.nan)], [(np.inf, 0)], [(0, 0, 0)], [0, 1], [[]]])
def test_sites_that_are_no_points_are_refused(sites: list) -> None:
    with pytest.raises(ValueError, match="sites has"):
        voronoi(sites, BOX)


@pytest.mark.parametrize("across", [3.0, 1e-9], ids=["all over", "in a column"])
def test_an_outline_of_many_corners_cuts_like_any_other(monkeypatch: pytest.MonkeyPatch, across: float) -> None:
    turn = np.linspace(0, 2 * np.pi, 4000, endpoint=False)
    reach = 0.9 + 0.05 * np.sin(60 * turn)
    canvas = shapely.Polygon(np.stack([1.5 + 1.6 * reach * np.cos(turn), 1 + reach * np.sin(turn)], axis=1))
    sites = np.random.default_rng(5).random((3000, 2)) * (across, 2) + (1.5 - across / 2, 0)
    cut = voronoi(sites, canvas)
    monkeypatch.setattr("crowquill.cells.MANY", np.inf)
    plain = voronoi(sites, canvas)
    assert shapely.area(canvas) == pytest.approx(cut.rings.areas.sum(), rel=1e-12)
    assert np.array_equal(cut.owner, plain.owner)
    np.testing.assert_allclose(cut.rings.areas, plain.rings.areas, rtol=1e-9, atol=1e-14)  # corners round at 1e-16
