"""Equal shares of ink: the weights that give them, sites that move within them, and ink in islands."""

from itertools import islice

import numpy as np
import pytest
import shapely
from checks import check_areas, check_in_canvas
from hypothesis import given
from hypothesis import strategies as st
from test_cells import found

from crowquill import capacity, relax
from crowquill.cells import power, voronoi
from crowquill.moments import along, of_tone
from crowquill.tone import Tone

RIPPLE = Tone(0.4 + 0.35 * np.sin(np.arange(120) / 9) * np.cos(np.arange(80) / 7)[:, None], (30.0, 20.0))
NOISE = Tone(np.random.default_rng(0).random((80, 120)), (30.0, 20.0))
DISCS = np.zeros((80, 120))
for x, y, r, tone in np.random.default_rng(3).random((20, 4)):
    DISCS[np.hypot(np.arange(120) - 120 * x, (np.arange(80) - 80 * y)[:, None]) < 2 + 6 * r] = 0.1 + 0.8 * tone
ISLANDS = shapely.MultiPolygon([shapely.box(5 * i, 5 * j, 5 * i + 3, 5 * j + 2.5) for i in range(6) for j in range(4)])
TONES = {
    "even": Tone(np.full((2, 3), 0.5), (30.0, 20.0)),
    "ripples": RIPPLE,
    "noise": NOISE,
    "black and white by turns": Tone(np.indices((40, 60)).sum(axis=0) % 2.0, (30.0, 20.0)),
    "twenty discs on white": Tone(DISCS, (30.0, 20.0)),
    "rows with white between": Tone(np.where(np.arange(80)[:, None] % 5 == 0, 0.8, 0.0) * np.ones((80, 120)), (30.0, 20.0)),
    "steep": Tone(np.tile((np.arange(120) / 120) ** 4, (80, 1)), (30.0, 20.0)),
    "twenty-four islands": Tone(np.full((80, 120), 0.5), (30.0, 20.0), ISLANDS),
    "a horseshoe": Tone(RIPPLE.coverage, (30.0, 20.0), shapely.Point(15, 10).buffer(9) - shapely.box(13, 9, 17, 20)),
}


@found
@given(st.integers(0, 10**6))
def test_coverage_along_a_line_is_that_of_the_pixels_it_is_cut_into(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tone = Tone(rng.random((4, 6)), (3.0, 8.0))
    ends = rng.random((2, 2)) * tone.size
    ends[:, seed % 2] = np.where(seed % 3 == 0, ends[0, seed % 2], ends[:, seed % 2])  # some along a row or column
    dx, dy = tone.pixel
    column, row = np.meshgrid(np.arange(6), np.arange(4))
    boxes = shapely.box(column * dx, row * dy, (column + 1) * dx, (row + 1) * dy)
    parts = shapely.length(shapely.intersection(boxes, shapely.linestrings(ends)))
    assert along(tone, ends[None])[0] == pytest.approx((parts * tone.coverage).sum(), rel=1e-8)  # steps of 1e-9 at the least


def test_lines_on_borders_and_off_the_picture_take_a_pixel_beside_them() -> None:
    tone = Tone([[0.2, 0.6]], (2.0, 1.0))
    lines = np.array([[(1, 0), (1, 1)], [(-1, 0.5), (0, 0.5)], [(0, 0), (2, 0)], [(0.3, 0.3), (0.3, 0.3)]], float)
    found = along(tone, lines)
    assert found[0] in (pytest.approx(0.2), pytest.approx(0.6)) and found[1:] == pytest.approx([0.2, 0.8, 0.0])


@pytest.mark.parametrize("n", [1, 2, 30, 400])
@pytest.mark.parametrize("name", TONES)
def test_every_cell_holds_the_same_ink_to_a_millionth(name: str, n: int) -> None:
    tone = TONES[name]
    sites = relax.scatter(tone, n, np.random.default_rng(n))
    shares = capacity.equal(sites, tone)
    again = of_tone(power(sites, shares.weights, tone.canvas, joined=False), tone)
    check_areas(shares.cells)
    assert shares.error <= 1e-6
    np.testing.assert_allclose(again.mass, tone.ink / n, rtol=1e-6)


def test_the_error_sees_shares_that_differ() -> None:
    sites = relax.scatter(RIPPLE, 50, np.random.default_rng(0))
    plain = capacity.Shares.of(sites, np.zeros(50), RIPPLE)
    mass = of_tone(voronoi(sites, RIPPLE.canvas), RIPPLE).mass
    assert plain.error == pytest.approx(np.abs(mass / mass.mean() - 1).max(), rel=1e-9) and plain.error > 0.1


def test_the_weights_of_two_sites_by_hand() -> None:
    tone = Tone([[0.5]], (10.0, 4.0))
    shares = capacity.equal([(1.0, 2.0), (3.0, 2.0)], tone)
    # the border is to be at x = 5: (5 - 1)^2 - w0 = (5 - 3)^2 - w1
    assert np.diff(shares.weights) == pytest.approx(-12) and shares.moments.mass == pytest.approx([10, 10])


def test_value_is_greatest_where_shares_are_equal_and_is_then_the_cost_of_transport() -> None:
    sites = relax.scatter(RIPPLE, 40, np.random.default_rng(2))
    best, rng = capacity.equal(sites, RIPPLE, until=1e-9), np.random.default_rng(3)
    way = best.cells.sites - best.moments.centroid
    cost = (best.moments.mass * (np.trace(best.moments.covariance, axis1=1, axis2=2) + (way**2).sum(axis=1))).sum()
    assert best.value == pytest.approx(cost, rel=1e-9)
    for size in (1e-3, 0.1, 1.0):
        assert capacity.Shares.of(sites, best.weights + size * rng.standard_normal(40), RIPPLE).value < best.value


def test_newtons_step_foretells_what_cells_gain() -> None:
    sites = relax.scatter(RIPPLE, 60, np.random.default_rng(4))
    now = capacity.Shares.of(sites, np.zeros(60), RIPPLE)
    way = capacity._solved(now, RIPPLE)
    after = capacity.Shares.of(sites, 1e-4 * way, RIPPLE)
    gained = (after.moments.mass - now.moments.mass) / 1e-4
    np.testing.assert_allclose(gained, now.short, atol=1e-2 * np.abs(now.short).max())  # borders change a little on so short a way


@pytest.mark.parametrize(
    ("sites", "tone", "error"),
    [
        ([], RIPPLE, 0.0),
        ([(3, 3), (4, 4)], Tone([[0.0]], (30.0, 20.0)), 0.0),
        ([(3, 3), (3, 3), (9, 9)], RIPPLE, 1.0),  # the second has nothing, and the mean is over all three
    ],
    ids=["no sites", "no ink", "coincident sites"],
)
def test_what_cannot_be_shared_is_left(sites: list, tone: Tone, error: float) -> None:
    shares = capacity.equal(np.reshape(np.array(sites, float), (-1, 2)), tone)
    assert np.isfinite(shares.weights).all() and shares.error >= error and (error or shares.error == 0)


def test_weights_that_have_become_wrong_are_given_up() -> None:
    sites = relax.scatter(RIPPLE, 100, np.random.default_rng(5))
    wild = 100 * np.random.default_rng(6).random(100)
    assert (np.diff(power(sites, wild, RIPPLE.canvas).first) == 0).sum() > 50
    assert capacity.equal(sites, RIPPLE, wild).error <= 1e-6


@pytest.mark.parametrize("name", ["ripples", "twenty discs on white", "a horseshoe"])
def test_sites_that_move_stay_on_ink_in_the_canvas_and_come_nearer_to_the_middle_of_their_shares(name: str) -> None:
    tone = TONES[name]
    white = tone.coverage == 0
    first, *_, last = islice(capacity.relaxed(relax.scatter(tone, 300, np.random.default_rng(7)), tone, banned=white), 7)
    assert (first.done, last.done) == (0, 6)
    check_in_canvas(last.sites, tone)
    assert not white[tone.under(last.sites)].any()
    assert last.movement < 0.5 * first.movement and last.energy < 0.9 * first.energy
    assert last.shares.error < 0.1  # so many rounds come within 3 % where ink hangs together


def test_a_site_goes_so_many_times_the_way_to_the_middle_of_its_share() -> None:
    first, second = islice(capacity.relaxed(relax.scatter(RIPPLE, 60, np.random.default_rng(8)), RIPPLE, step=0.7), 2)
    np.testing.assert_allclose(second.sites, first.sites + 0.7 * (first.moments.centroid - first.sites))
