"""Mass, centroid and covariance: by hand, by shapely, by clipping every pixel, and what must not change them."""

import numpy as np
import pytest
import shapely
from checks import check_moments, shape_of
from hypothesis import given, settings
from hypothesis import strategies as st

from crowquill.cells import Cells, voronoi
from crowquill.moments import of_rings, of_tone
from crowquill.paths import Paths
from crowquill.tone import Tone

found = settings(max_examples=40)
KAPPA = 4 / 3 * (np.sqrt(2) - 1)
FRAME = shapely.box(0, 0, 30, 20).difference(shapely.box(10, 5, 20, 15)).difference(shapely.Polygon([(1, 1), (2, 1), (2, 3)]))
# rows, columns, mm, sites
PICTURES = {
    "some pixels a cell": (10, 12, (12, 10), 8),
    "pixels taller than wide": (10, 12, (12, 30), 20),
    "pixels wider than tall": (10, 12, (120, 3), 20),
    "pixels of a tenth of a millimetre": (40, 50, (5, 4), 200),
    "cells within one pixel": (1, 1, (3, 2), 9),
    "one cell, one pixel": (1, 1, (3, 2), 1),
    "five blocks of columns, cells across two": (7, 300, (300, 7), 6),
    "five blocks, thin pixels": (7, 300, (30, 70), 30),
    "cells across a dozen blocks": (3, 5000, (5000, 3), 5),
    "far columns, every cell across many": (3, 5000, (500, 300), 40),
    "tall": (300, 3, (3, 300), 6),
    "one block, all of it": (8, 64, (64, 8), 9),
    "one block and one column": (8, 65, (65, 8), 9),
}


def seconds(polygon: shapely.Polygon, about: np.ndarray) -> np.ndarray:
    """Integrals of 1, x, y, xx, xy, yy over a polygon about a point: the textbook's sums over edges, holes included."""
    total = np.zeros(6)
    for ring in shapely.get_rings(shapely.orient_polygons(polygon)):  # holes turn the other way and take off
        xy = shapely.get_coordinates(ring) - about
        (x, y), (u, v) = xy[:-1].T, xy[1:].T
        parts = [np.full(len(x), 1 / 2), (x + u) / 6, (y + v) / 6]
        parts += [(x * x + x * u + u * u) / 12, (2 * x * y + x * v + u * y + 2 * u * v) / 24, (y * y + y * v + v * v) / 12]
        total += [((x * v - u * y) * part).sum() for part in parts]
    return total


def by_clipping(cells: Cells, tone: Tone) -> np.ndarray:
    """Mass, centroid and covariance (xx, xy, yy) of each cell, from shapely's clip of the cell with every pixel near it."""
    (h, w), (dx, dy) = tone.coverage.shape, tone.pixel
    rows = []
    for i in range(len(cells.sites)):
        shape = shape_of(cells, i)
        x0, y0, x1, y1 = shape.bounds / np.array([dx, dy, dx, dy])
        column = np.arange(max(0, int(x0) - 1), min(w, int(x1) + 2))
        row = np.arange(max(0, int(y0) - 1), min(h, int(y1) + 2))
        column, row = (grid.ravel() for grid in np.meshgrid(column, row))
        boxes = shapely.box(column * dx, row * dy, (column + 1) * dx, (row + 1) * dy)
        parts, pixel = shapely.get_parts(shapely.intersection(boxes, shape), return_index=True)
        about = np.array(shape.centroid.coords[0])
        sums = sum(tone.coverage[row[k], column[k]] * seconds(p, about) for p, k in zip(parts, pixel, strict=True) if p.area > 0)
        x, y, xx, xy, yy = sums[1:] / sums[0]
        rows.append([sums[0], about[0] + x, about[1] + y, xx - x * x, xy - x * y, yy - y * y])
    return np.array(rows)


def assert_same(tone: Tone, cells: Cells) -> None:
    """of_tone is within 1e-10 of clipping: lengths by the cell's own width, or by the pixel's where that is wider."""
    moments, twin = of_tone(cells, tone), by_clipping(cells, tone)
    width = np.maximum(np.sqrt(np.bincount(cells.owner, cells.rings.areas)), max(tone.pixel))
    # sums over a block of 64 pixels cancel round a ring: 64^3 / 3 times 1e-16, 1e-11 of a pixel
    np.testing.assert_allclose(moments.mass, twin[:, 0], rtol=1e-10)
    assert (np.abs(moments.centroid - twin[:, 1:3]).max(axis=1) / width).max() <= 1e-10
    assert (np.abs(moments.covariance.reshape(-1, 4)[:, [0, 1, 3]] - twin[:, 3:]).max(axis=1) / width**2).max() <= 1e-10


def picture(seed: int, h: int, w: int, size: tuple[float, float], canvas: shapely.Geometry | None = None) -> Tone:
    return Tone(np.random.default_rng(seed).uniform(0.02, 1, (h, w)), size, canvas)


def cells_of(tone: Tone, seed: int, n: int) -> Cells:
    sites = np.random.default_rng(seed).random((n, 2)) * tone.size
    return voronoi(sites[tone.holds(sites)], tone.canvas)


def test_closed_cases_by_hand() -> None:
    rings = Paths.of([[(0, 0), (1, 0), (0, 1)], [(0, 0), (4, 0), (4, 2), (0, 2)], [(0, 1), (1, 0), (0, 0)]])
    moments = of_rings(rings)
    assert moments.mass.tolist() == [0.5, 8, -0.5]
    np.testing.assert_allclose(moments.centroid, [(1 / 3, 1 / 3), (2, 1), (1 / 3, 1 / 3)], rtol=1e-15)
    raw = moments.covariance + moments.centroid[:, :, None] * moments.centroid[:, None, :]
    np.testing.assert_allclose(raw[0] * 0.5, [[1 / 12, 1 / 24], [1 / 24, 1 / 12]], rtol=1e-14)  # about the origin
    # w^2 / 12 and h^2 / 12 of a box; a ring walked back has the same
    np.testing.assert_allclose(moments.covariance[1], [[16 / 12, 0], [0, 4 / 12]], atol=1e-15)
    np.testing.assert_allclose(moments.covariance[2], moments.covariance[0], rtol=1e-14)


@pytest.mark.parametrize("ring", [[], [(3, 4)], [(3, 4), (5, 6)], [(3, 4), (5, 6), (7, 8)]], ids=["empty", "point", "line", "flat"])
def test_a_ring_without_area_has_its_fallback_as_centroid(ring: list) -> None:
    rings = Paths.of([ring, [(0, 0), (1, 0), (0, 1)]])
    plain, told = of_rings(rings), of_rings(rings, [(8, 9), (8, 9)])
    assert plain.mass[0] == 0 and not plain.covariance[0].any()
    assert plain.centroid[0].tolist() == ([3, 4] if ring else [0, 0]) and told.centroid[0].tolist() == [8, 9]
    np.testing.assert_allclose(told.centroid[1], 1 / 3, rtol=1e-15)


@found
@given(st.integers(0, 10**6), st.integers(3, 30), st.sampled_from([1e-6, 1.0, 1e6]))
def test_rings_are_shapelys_and_the_textbooks(seed: int, corners: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    angle = (np.arange(corners) + rng.uniform(0, 0.9, corners)) * 2 * np.pi / corners
    ring = size * (2 + rng.uniform(0.2, 1, corners)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    polygon, moments = shapely.Polygon(ring), of_rings(Paths.of([ring]))
    centroid = np.array(polygon.centroid.coords[0])
    sums = seconds(polygon, centroid)
    # shapely sums about a corner of its own: some 1e-16 of a box that may be a hundred times the polygon
    assert moments.mass[0] == pytest.approx(polygon.area, rel=1e-12)
    np.testing.assert_allclose(moments.centroid[0], centroid, atol=1e-12 * size)
    np.testing.assert_allclose(moments.covariance[0][[0, 0, 1], [0, 1, 1]], sums[3:] / sums[0], atol=1e-11 * size**2)


def test_moments_about_a_far_origin_keep_their_digits() -> None:
    ring = np.random.default_rng(3).integers(0, 1024, (7, 2)) / 1024  # ten binary places: exact at 1e7 mm as well
    near, far = of_rings(Paths.of([ring])), of_rings(Paths.of([ring + 1e7]))
    assert far.mass == near.mass and (far.covariance == near.covariance).all()  # bit for bit: the same differences
    np.testing.assert_allclose(far.centroid - 1e7, near.centroid, atol=2e-9)  # mm: the last bit at 1e7


def test_cubic_rings_are_the_limit_of_their_flat_ones() -> None:
    petals = [np.random.default_rng(seed).random((9, 2)) * 4 for seed in range(5)]
    rings = Paths.of(petals, cubic=True)
    exact, drawn = of_rings(rings), of_rings(rings.flat(1e-7))
    # 1e-7 mm along outlines of some 10 mm, over areas that may cross themselves down to a hundredth
    np.testing.assert_allclose(drawn.mass, exact.mass, atol=1e-6)
    np.testing.assert_allclose(drawn.centroid, exact.centroid, atol=1e-4)
    np.testing.assert_allclose(drawn.covariance * drawn.mass[:, None, None], exact.covariance * exact.mass[:, None, None], atol=1e-4)


def test_a_cubic_box_has_the_moments_of_the_box() -> None:
    box = np.array([(0, 0), (4, 0), (4, 2), (0, 2)], float)
    after = np.roll(box, -1, axis=0)
    sides = np.stack([box, box + (after - box) / 3, after - (after - box) / 3], axis=1).reshape(-1, 2)
    moments = of_rings(Paths.of([sides], cubic=True))
    np.testing.assert_allclose(moments.covariance[0], [[16 / 12, 0], [0, 4 / 12]], atol=1e-14)  # rounding


def test_a_circle_of_cubics_has_a_quarter_of_its_squared_radius_as_covariance() -> None:
    quarter = np.array([(1, 0), (1, KAPPA), (KAPPA, 1)])
    circle = np.concatenate([quarter @ np.array([[c, s], [-s, c]]) for c, s in ((1, 0), (0, 1), (-1, 0), (0, -1))]) * 2 + 7
    moments = of_rings(Paths.of([circle], cubic=True))
    np.testing.assert_allclose(moments.centroid[0], 7, rtol=1e-15)
    np.testing.assert_allclose(moments.covariance[0], np.eye(2), atol=5.5e-4)  # radial error 2.7e-4 at most, squared


@pytest.mark.parametrize(("h", "w", "size", "n"), PICTURES.values(), ids=PICTURES)
def test_moments_of_tone_are_those_of_clipping_every_pixel(h: int, w: int, size: tuple, n: int) -> None:
    for seed in range(2):
        tone = picture(seed, h, w, size)
        cells = cells_of(tone, seed, n)
        assert_same(tone, cells)
        check_moments(of_tone(cells, tone), cells, tone)


@pytest.mark.parametrize("canvas", [FRAME, shapely.Point(15, 10).buffer(9.9), shapely.box(3, 2, 9, 8)], ids=["holes", "disc", "part"])
def test_moments_of_tone_are_exact_on_any_canvas(canvas: shapely.Geometry) -> None:
    tone = picture(5, 20, 200, (30, 20), canvas)
    cells = cells_of(tone, 5, 60)
    assert_same(tone, cells)
    check_moments(of_tone(cells, tone), cells, tone)


def test_cells_with_corners_on_pixel_corners_are_exact() -> None:
    tone = picture(6, 8, 8, (8, 8))
    even = np.stack(np.meshgrid([1.0, 3, 5, 7], [1.0, 3, 5, 7]), axis=-1).reshape(-1, 2)
    for sites in (even, even[::3], [(2, 4), (6, 4)], [(4, 4)], [(1.5, 1.5), (2.5, 1.5), (1.5, 2.5), (6, 6)]):
        cells = voronoi(sites, tone.canvas)
        assert_same(tone, cells)
        check_moments(of_tone(cells, tone), cells, tone)


@found
@given(st.integers(0, 10**6), st.integers(1, 90), st.integers(1, 70), st.integers(1, 60), st.sampled_from([1e-6, 1.0, 1e6]))
def test_facts_hold_for_whatever_picture_of_black_and_white(seed: int, w: int, h: int, n: int, mm: float) -> None:
    rng = np.random.default_rng(seed)
    coverage = np.where(rng.random((h, w)) < 0.3, rng.random((h, w)), 0.0)  # seven pixels in ten are white
    coverage[:, rng.integers(0, w) :] = 0
    tone = Tone(coverage, (w * mm, h * mm))
    cells = voronoi(rng.random((n, 2)) * tone.size, tone.canvas)
    check_moments(of_tone(cells, tone), cells, tone)


@pytest.mark.parametrize("canvas", [None, FRAME], ids=["rectangle", "holes"])
def test_constant_coverage_is_the_cells_own_moments_times_it(canvas: shapely.Geometry | None) -> None:
    tone = Tone(np.full((20, 300), 0.3), (30, 20), canvas)
    cells = cells_of(tone, 7, 50)
    alone = np.diff(cells.first) == 1  # a cell with a hole or in parts has no moments as one ring
    rings, moments = of_rings(cells.rings.take(cells.first[:-1][alone])), of_tone(cells, tone)
    np.testing.assert_allclose(moments.mass[alone], 0.3 * rings.mass, rtol=1e-9)
    np.testing.assert_allclose(moments.centroid[alone], rings.centroid, rtol=1e-9)
    np.testing.assert_allclose(moments.covariance[alone], rings.covariance, atol=1e-9 * 10)  # cells of some 10 mm^2


@pytest.mark.parametrize("scale", [2.0, 0.5, 1024.0])
def test_a_picture_twice_the_size_has_centroids_twice_as_far(scale: float) -> None:
    tone, cells = picture(8, 9, 130, (13, 9)), cells_of(picture(8, 9, 130, (13, 9)), 8, 20)
    large = Tone(tone.coverage, (13 * scale, 9 * scale))
    plain, scaled = of_tone(cells, tone), of_tone(voronoi(cells.sites * scale, large.canvas), large)
    # powers of two: every product is exact, but Delaunay may start a cell's ring elsewhere
    np.testing.assert_allclose(scaled.centroid, plain.centroid * scale, rtol=1e-12)
    np.testing.assert_allclose(scaled.mass, plain.mass * scale**2, rtol=1e-12)


def test_a_white_picture_leaves_every_site_where_it_is() -> None:
    tone = Tone(np.zeros((5, 70)), (70, 5))
    cells = cells_of(tone, 9, 12)
    moments = of_tone(cells, tone)
    assert not moments.mass.any() and (moments.centroid == cells.sites).all() and not moments.covariance.any()


def test_white_cells_beside_ink_have_no_mass_and_keep_their_sites() -> None:
    coverage = np.zeros((37, 61))
    coverage[:, :23] = np.random.default_rng(1).random((37, 23))
    tone = Tone(coverage, (18.3, 25.9))
    cells = cells_of(tone, 10, 300)
    white = np.array([shape_of(cells, i).bounds[0] > 23 * tone.pixel[0] for i in range(300)])
    moments = of_tone(cells, tone)
    assert white.sum() > 100 and not moments.mass[white].any()
    assert (moments.centroid[white] == cells.sites[white]).all()


@pytest.mark.parametrize("sliver", [1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16])
@pytest.mark.parametrize(("rows", "column"), [(1, 0), (40, 30), (7, 60)])
def test_a_sliver_of_ink_draws_the_centroid_no_further_than_the_cell(rows: int, column: int, sliver: float) -> None:
    coverage = np.zeros((rows, 70))
    coverage[:, : column + 1] = np.random.default_rng(12).random((rows, column + 1))
    tone, x = Tone(coverage, (70 * 0.3, rows * 0.7)), (column + 1 - sliver) * 0.3  # cells meet this much short of the white
    cells = voronoi([(x - 0.1, 0.31 * rows), (x + 0.1, 0.31 * rows), (x + 0.1, 0.33 * rows)], tone.canvas)
    check_moments(of_tone(cells, tone), cells, tone)


def test_sites_without_a_cell_and_no_sites_have_answers() -> None:
    tone = picture(11, 4, 4, (4, 4))
    twins = of_tone(voronoi([(1, 1), (1, 1), (9, 9)], tone.canvas), tone)
    assert twins.mass[0] == pytest.approx(tone.ink, rel=1e-12) and twins.mass[1:].tolist() == [0, 0]  # sums of 16 pixels
    assert twins.centroid[1:].tolist() == [[1, 1], [9, 9]]
    assert of_tone(voronoi(np.zeros((0, 2)), tone.canvas), tone).centroid.shape == (0, 2)
