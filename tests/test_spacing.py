"""Distances, gaps, evenness, hexagons and capacity: lattices by hand, published figures, and faults put in on purpose."""

import json
from itertools import islice

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from crowquill import glyphs, spacing
from crowquill.cells import voronoi
from crowquill.marks import Glyph, Marks
from crowquill.paths import Paths
from crowquill.relax import lloyd, scatter
from crowquill.tone import Tone

UNIT = Tone(np.ones((1, 1)), (1, 1))
PLATE = Tone(np.full((1, 1), 0.5), (12, 12))  # for 1600 dots 0.3 mm apart
RAMP = Tone(np.tile(np.linspace(0.2, 0.8, 60), (40, 1)), (60, 40))
DISC, NIB = glyphs.load("disc").glyphs, glyphs.load("nib-03").glyphs
SQUARE = (Glyph.of(Paths.of([[(0, 0), (1, 0), (1, 1), (0, 1)]])),)
found = settings(max_examples=30, deadline=None)


def hexagonal(columns: int, rows: int) -> tuple[np.ndarray, shapely.Geometry]:
    """A hexagonal lattice of side 1, an even number of rows, on a canvas of as many cells' area."""
    row, column = np.indices((rows, columns)).reshape(2, -1)
    sites = np.stack([column + 0.25 + row % 2 / 2, (row + 0.5) * np.sqrt(3) / 2], axis=1)
    return sites, shapely.box(0, 0, columns, rows * np.sqrt(3) / 2)


@pytest.fixture(scope="module")
def even() -> np.ndarray:
    """A good set on the plate."""
    return next(islice(lloyd(scatter(PLATE, 1600, np.random.default_rng(1)), PLATE), 30, None)).sites


def test_a_hexagonal_lattice_is_the_measure_of_evenness() -> None:
    sites, canvas = hexagonal(20, 22)
    got = spacing.of(sites, canvas)
    assert got.evenness == pytest.approx(1, rel=1e-12) and got.hexagons == 1  # rounding
    assert got.alpha == pytest.approx(1, rel=1e-12)
    assert (got.nearest, got.nearest_least) == (pytest.approx(1, rel=1e-12), pytest.approx(1, rel=1e-12))
    assert got.nearest_cv == pytest.approx(0, abs=1e-12)


def test_a_square_lattice_by_hand() -> None:
    sites = np.stack(np.meshgrid(np.arange(12), np.arange(9)), axis=-1).reshape(-1, 2) + 0.5
    got = spacing.of(sites, shapely.box(0, 0, 12, 9))
    assert got.evenness == pytest.approx(np.sqrt(np.sqrt(3) / 2), rel=1e-12) and got.hexagons == 0
    assert got.alpha == pytest.approx(np.sqrt(np.sqrt(3) / 2), rel=1e-12)
    assert got.capacity_cv == pytest.approx(0, abs=1e-12) and got.nearest == 1
    cells = voronoi(sites, shapely.box(0, 0, 12, 9))
    assert spacing.whole(cells).sum() == 10 * 7  # on an endless canvas the outer ones would be larger


@pytest.mark.parametrize("seed", range(3))
def test_random_sites_have_the_published_figures(seed: int) -> None:
    got = spacing.of(np.random.default_rng(seed).random((20_000, 2)), UNIT)
    assert got.evenness == pytest.approx(0.471, abs=0.006)  # a distance spreads by .25: 20 000 of them by .002
    assert got.capacity_cv == pytest.approx(0.537, abs=0.012)  # a set strays by some .003
    assert got.nearest_cv == pytest.approx(np.sqrt(4 / np.pi - 1), abs=0.012)  # of a Rayleigh distribution
    assert got.nearest == pytest.approx(0.5 / np.sqrt(20_000), rel=0.02)
    assert got.hexagons == pytest.approx(0.295, abs=0.012)  # published for Poisson cells; sqrt(.3 .7 / 20 000) = .003
    assert got.pairs_close == pytest.approx(1, abs=0.06)  # 7700 pairs in 20 000 half discs of 0.79
    assert got.low_power == pytest.approx(1, abs=0.2) and got.anisotropy is not None and got.anisotropy < -14


def test_whole_cells_are_those_away_from_the_border() -> None:
    cells = voronoi(np.random.default_rng(3).random((500, 2)), UNIT.canvas)
    at_border = ((cells.rings.xy <= 1e-9) | (cells.rings.xy >= 1 - 1e-9)).any(axis=1)
    touching = np.unique(cells.owner[cells.rings.path[at_border]])
    whole = spacing.whole(cells)
    assert not whole[touching].any() and whole.sum() == 500 - len(touching)
    sides = np.bincount(cells.pairs.ravel(), minlength=500)
    assert spacing.hexagons(cells) == pytest.approx((sides[whole] == 6).mean(), abs=1e-12)


def test_capacity_of_two_cells_by_hand() -> None:
    tone = Tone(np.array([[0.8, 0.2]]), (2, 1))
    cells = voronoi([(0.5, 0.5), (1.5, 0.5)], tone.canvas)
    assert spacing.capacity_error(cells, tone) == pytest.approx(0.6**2, rel=1e-12)


@found
@given(st.integers(0, 2**32 - 1), st.integers(2, 120))
def test_distances_are_those_of_all_pairs(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    sites = rng.random((n, 2))
    sites[rng.random(n) < 0.2] = sites[0]
    apart = np.hypot(*(sites[:, None] - sites[None]).transpose(2, 0, 1)) + np.diag(np.full(n, np.inf))
    np.testing.assert_allclose(spacing.nearest(sites), apart.min(axis=1), rtol=1e-12)


@found
@given(st.integers(0, 2**32 - 1), st.integers(2, 40), st.sampled_from([DISC, NIB, SQUARE]))
def test_the_gap_is_the_least_distance_of_all_outlines(seed: int, n: int, shapes: tuple[Glyph, ...]) -> None:
    rng = np.random.default_rng(seed)
    marks = Marks.of(
        rng.random((n, 2)) * rng.uniform(2, 30),
        shapes,
        scale=10 ** rng.uniform(-2, 0.5, n),
        angle=rng.uniform(0, 7, n),
        glyph=rng.integers(len(shapes), size=n),
    )
    outlines = marks.outlines().flat(1e-5).polygons()
    every = shapely.distance(outlines[:, None], outlines[None]) + np.diag(np.full(n, np.inf))
    assert spacing.gap(marks) == pytest.approx(every.min(), abs=2e-4)  # of mm, as promised


def test_gaps_by_hand() -> None:
    two = Marks.of([(0, 0), (3, 0)], SQUARE, scale=[2, 1])
    assert spacing.gap(two) == pytest.approx(1.5, rel=1e-12)
    assert spacing.gap(Marks.of([(0, 0), (1.2, 0)], SQUARE, scale=[2, 1])) == 0
    assert spacing.gap(Marks.of([(0, 0), (0.2, 0)], SQUARE, scale=[3, 0.1])) == 0  # one inside the other
    assert spacing.gap(Marks.of([(1, 1)] * 20_000, DISC, scale=1)) == 0
    assert spacing.gap(two.take([0])) is None and spacing.gap(Marks.of([], DISC, scale=1)) is None
    assert spacing.gap(Marks.of([(0, 0), (3, 0), (1.4, 0)], SQUARE, scale=[2, 1, 0])) == pytest.approx(1.5, rel=1e-12)
    assert spacing.of([(0, 0), (3, 0)], shapely.box(-2, -2, 5, 2), marks=two).gap == pytest.approx(1.5, rel=1e-12)


def test_a_good_set_is_found_good(even: np.ndarray) -> None:
    got = spacing.of(even, PLATE)
    assert got.evenness > 0.88 and got.capacity_cv < 0.15 and got.alpha > 0.65 and got.hexagons > 0.6
    assert 2 < got.power < 4.5 and got.frequency == pytest.approx(1.05) and got.low_power < 0.03
    assert got.pairs_close == 0 and 2 < got.pair_peak < 5 and abs(got.pair_distance - 1.05) < 0.08 and not got.notes


def test_a_lattice_is_found() -> None:
    sites, canvas = hexagonal(40, 46)
    got = spacing.of(sites, canvas)
    assert got.power > 6 and got.anisotropy > 3 and got.pair_peak > 15 and got.evenness > 0.999
    turned = sites @ [[0.8, 0.6], [-0.6, 0.8]]  # in no step with the squares
    inside = shapely.box(-10, 15, 10, 35)
    assert spacing.of(turned[shapely.contains_xy(inside, turned)], inside).anisotropy > 3


def test_a_clump_is_found(even: np.ndarray) -> None:
    near = np.argsort(np.hypot(*(even - (5, 6)).T))[:20]
    clumped = even.copy()
    clumped[near] = (5, 6) + 0.2 * (clumped[near] - (5, 6))
    good, bad = spacing.of(even, PLATE), spacing.of(clumped, PLATE)
    assert bad.alpha < 0.3 * good.alpha and bad.capacity_cv > 2 * good.capacity_cv and bad.nearest_cv > 1.5 * good.nearest_cv
    assert bad.pairs_close > 0.1 and bad.low_power > 2 * good.low_power


def test_a_shift_of_half_the_dots_by_30_micrometres_is_found(even: np.ndarray) -> None:
    shifted = even + np.where(np.random.default_rng(1).random(len(even)) < 0.5, 0.03, 0)[:, None] * (1, 0)
    good, bad = spacing.of(even, PLATE), spacing.of(shifted, PLATE)
    # 1600 distances spread by a tenth: a chance change of evenness is below .004
    assert bad.evenness < good.evenness - 0.02 and bad.nearest_cv > 1.1 * good.nearest_cv and bad.alpha < good.alpha - 0.03
    assert bad.capacity_cv > 1.1 * good.capacity_cv and bad.low_power > 1.3 * good.low_power and bad.power < good.power


@pytest.mark.parametrize("tone", [PLATE, RAMP], ids=["even", "ramp"])
def test_figures_do_not_see_scale_or_order(tone: Tone) -> None:
    sites = scatter(tone, 1200, np.random.default_rng(4))
    one = spacing.of(sites, tone).figures()
    larger = Tone(tone.coverage, (tone.size[0] * 3, tone.size[1] * 3))
    other = spacing.of(np.random.default_rng(5).permutation(sites) * 3, larger).figures()
    for name in ("nearest", "nearest_least"):
        other[name] /= 3
    for name, value in one.items():
        assert other[name] == pytest.approx(value, rel=1e-9) if value is not None else other[name] is None, name  # sums in another order


def test_a_canvas_may_lie_anywhere_and_have_any_shape(even: np.ndarray) -> None:
    here, there = spacing.of(even, PLATE), spacing.of(np.add(even, (100, -50)), shapely.box(100, -50, 112, -38))
    assert there.evenness == pytest.approx(here.evenness, rel=1e-9) and there.power == pytest.approx(here.power, rel=1e-6)
    round_plate = shapely.Point(6, 6).buffer(5)
    kept = even[shapely.contains_xy(round_plate, *even.T)]
    cut = spacing.of(kept, round_plate)  # its squares hold a third as many sites, and a window so narrow lowers a peak
    assert cut.evenness == pytest.approx(here.evenness, abs=0.01) and cut.power == pytest.approx(here.power, rel=0.25)
    assert cut.pair_peak == pytest.approx(here.pair_peak, rel=0.1)


@pytest.mark.parametrize(
    ("sites", "gone"),
    [
        ([], "nearest nearest_least nearest_cv evenness alpha hexagons capacity_cv capacity_error quadrature random regular"),
        ([(0.3, 0.4)], "nearest nearest_least nearest_cv evenness alpha hexagons"),
        ([(0.3, 0.4)] * 4, "nearest_cv evenness hexagons"),
        ([(0.1, 0.5), (0.4, 0.5), (0.9, 0.5)], "evenness hexagons"),
        ([(3, 3), (4, 4)], "evenness alpha hexagons"),
    ],
    ids=["none", "one", "coincident", "a row", "off the canvas"],
)
def test_what_awkward_sites_leave_open_is_none_and_said(sites: list, gone: str) -> None:
    found = spacing.of(np.reshape(sites, (-1, 2)), UNIT)
    got = found.figures()
    json.dumps(got, allow_nan=False)
    always = "gap frequency power low_power anisotropy pairs_close pair_distance pair_peak"
    assert {name for name, value in got.items() if value is None} == {*gone.split(), *always.split()}
    assert any("spectrum" in note for note in found.notes) and any("hexagons" in note for note in found.notes)


def test_coincident_sites_are_0_apart_and_one_alone_is_endlessly_far() -> None:
    assert spacing.nearest([(1, 1), (2, 2), (1, 1)]).tolist() == [0, pytest.approx(np.sqrt(2)), 0]
    assert spacing.nearest([(1, 1)]).tolist() == [np.inf] and spacing.nearest(np.zeros((0, 2))).shape == (0,)
    got = spacing.of([(0.5, 0.5)] * 20_000, UNIT)
    assert got.nearest == 0 and got.alpha == 0 and got.capacity_error == pytest.approx(19_999)


def test_without_ink_there_is_no_density() -> None:
    got = spacing.of(np.random.default_rng(1).random((400, 2)), Tone(np.zeros((4, 4)), (1, 1)))
    assert got.alpha is None and got.capacity_error is None and got.power is None and got.quadrature is None
    assert got.evenness is not None and any("no ink" in note for note in got.notes)


@pytest.mark.parametrize("canvas", [shapely.Polygon(), shapely.LineString([(0, 0), (1, 1)])])
def test_a_canvas_without_area_is_refused(canvas: shapely.Geometry) -> None:
    with pytest.raises(ValueError, match="without area; give a polygon"):
        spacing.of([(0, 0)], canvas)
