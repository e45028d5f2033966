"""A triangulation mended after its sites moved: the cells are those built anew, bit for bit."""

import numpy as np
import pytest
import shapely

from crowquill import mending, relax
from crowquill.cells import voronoi
from crowquill.delaunay import triangulated
from crowquill.exact import depth
from crowquill.moments import of_tone
from crowquill.tone import Tone

BOX = shapely.box(0, 0, 30, 20)
HOLED = BOX.difference(shapely.Point(12, 9).buffer(4))
y, x = np.mgrid[0:200, 0:300] / 200
TONE = Tone(0.4 + 0.35 * np.sin(9 * x + 4 * y * y) * np.cos(7 * y), (30, 20))
GRID = np.stack(np.meshgrid(np.arange(0.5, 30), np.arange(0.5, 20)), axis=-1).reshape(-1, 2)


@pytest.fixture
def mended(monkeypatch):
    """How often a triangulation was mended, and how often that was given up."""
    told = []
    real = mending.moved
    monkeypatch.setattr(mending, "moved", lambda *given: told.append(real(*given)) or told[-1])
    return told


def assert_same(one, other):
    assert (one.rings.xy == other.rings.xy).all() and (one.rings.start == other.rings.start).all()
    assert (one.owner == other.owner).all() and (one.areas == other.areas).all() and (one.pairs == other.pairs).all()
    assert all((mine == theirs).all() for mine, theirs in zip(one.net.edges, other.net.edges, strict=True))


@pytest.mark.parametrize("canvas", [BOX, HOLED], ids=["box", "holed"])
@pytest.mark.parametrize("how", ["even", "random", "floyd-steinberg"])
def test_cells_of_sites_on_their_way_are_those_built_anew(mended, how, canvas):
    tone = Tone(TONE.coverage, TONE.size, canvas)
    sites, cells = relax.scatter(tone, 3000, np.random.default_rng(1), how), None
    for _ in range(12):
        cells = voronoi(sites, canvas, cells)
        assert_same(cells, voronoi(sites, canvas))
        moments = of_tone(cells, tone)
        sites = relax.held(tone, None, sites + 1.8 * (moments.centroid - sites), moments.centroid, sites)
    assert mended == [True] * 11


@pytest.mark.parametrize("way", [1e-12, 1e-3, 0.5, 3.0])
def test_sites_of_a_grid_with_four_on_every_circle_are_followed_however_far(way):
    rng = np.random.default_rng(2)
    still = voronoi(GRID, BOX)
    moved = np.clip(GRID + way * rng.normal(size=GRID.shape), 0, (30, 20))
    assert_same(voronoi(moved, BOX, still), voronoi(moved, BOX))
    assert_same(voronoi(GRID, BOX, voronoi(moved, BOX)), still)  # and back: ties are broken by the sites alone


def test_sites_that_change_places_are_led_past_each_other(mended):
    sites = np.random.default_rng(3).random((500, 2)) * (30, 20)
    swapped = sites.copy()
    swapped[:100] = np.roll(sites[:100], 1, axis=0)
    assert_same(voronoi(swapped, BOX, voronoi(sites, BOX)), voronoi(swapped, BOX))
    assert len(mended) == 1


@pytest.mark.parametrize("k", [1, 2, 3])
def test_few_sites_too(k):
    sites = np.random.default_rng(4).random((k, 2)) * (30, 20)
    assert_same(voronoi(sites[::-1], BOX, voronoi(sites, BOX)), voronoi(sites[::-1], BOX))


def test_sites_that_come_to_coincide_are_built_anew_and_so_are_those_after_them(mended):
    sites = np.random.default_rng(5).random((300, 2)) * (30, 20)
    met = sites.copy()
    met[7] = met[8]
    both = voronoi(met, BOX, voronoi(sites, BOX))
    assert mended == [False]
    assert_same(both, voronoi(met, BOX))
    assert_same(voronoi(sites, BOX, both), voronoi(sites, BOX))


def test_the_cells_of_other_sites_or_of_another_canvas_are_no_hindrance():
    rng = np.random.default_rng(6)
    sites = rng.random((300, 2)) * (30, 20)
    for last in (voronoi(sites[:200], BOX), voronoi(sites, shapely.box(0, 0, 60, 50)), voronoi(np.zeros((0, 2)), BOX)):
        assert_same(voronoi(sites, BOX, last), voronoi(sites, BOX))


def test_triangles_are_delaunays_and_of_ties_the_least_has_the_edge():
    net = triangulated(GRID, np.array([15.0, 10.0]), 20.0)
    flat = 0
    for t in range(len(net.vertices)):
        for k in range(3):
            u = net.neighbours[t, k]
            if u >= 0:
                a, b, c = np.roll(net.vertices[t], -k)
                d = next(v for v in net.vertices[u] if v not in (a, b))
                inside = depth(net.points, None, a, b, c, d)
                flat += inside == 0
                assert inside < 0 or (inside == 0 and min(a, b) < min(c, d))
    assert flat == 2 * 29 * 19  # every square of the grid, seen from both its halves


def test_what_is_not_mended_is_seen():
    sites = np.random.default_rng(8).random((300, 2)) * (30, 20)
    with pytest.raises(AssertionError):
        assert_same(voronoi(sites, BOX), voronoi(sites + 1e-15 * sites, BOX))
