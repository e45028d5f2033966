"""Sites as a rule of quadrature: integrals by other roads, and the order of sets that is known."""

from itertools import islice

import numpy as np
import pytest
import shapely

from crowquill import quadrature
from crowquill.quadrature import Quadrature
from crowquill.relax import lloyd, scatter
from crowquill.tone import Tone

UNIT = Tone(np.ones((1, 1)), (1, 1))
PICTURE = Tone(np.random.default_rng(1).random((40, 60)) ** 2, (30, 20))
DISC = Tone(np.random.default_rng(2).random((64, 64)), (10, 10), shapely.Point(5, 5).buffer(4.5))


def grid(side: int, *, rng: np.random.Generator | None = None) -> np.ndarray:
    """A square grid on the unit square, each site at the middle of its square or anywhere in it."""
    squares = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2)
    return (squares + (0.5 if rng is None else rng.random(squares.shape))) / side


def figures(found: Quadrature | None) -> np.ndarray:
    assert found is not None
    return np.array([found.smooth, found.edge, found.polynomial])


def pooled(sets: list[np.ndarray], tone: Tone = UNIT) -> np.ndarray:
    return np.sqrt(np.mean([figures(quadrature.of(sites, tone)) ** 2 for sites in sets], axis=0))


@pytest.mark.parametrize("n", [256, 1024, 4096])
@pytest.mark.parametrize("tone", [UNIT, PICTURE, DISC], ids=["even", "picture", "disc"])
def test_random_sites_err_by_one_over_the_root_of_their_number(tone: Tone, n: int) -> None:
    sets = [scatter(tone, n, np.random.default_rng(seed), "random") for seed in range(40)]
    found = quadrature.of(sets[0], tone)
    assert found is not None
    # a family has some ten independent functions, 40 sets: a root of 400 squares strays by 4 %, half planes, being alike, by 8 %
    np.testing.assert_allclose(pooled(sets, tone), found.random, rtol=0.25)
    half = quadrature.of(sets[0][: n // 4], tone)
    assert half is not None
    np.testing.assert_allclose(half.random, 2 * np.array(found.random), rtol=1e-12)


def test_integrals_are_those_of_very_many_sites() -> None:
    h, w = PICTURE.coverage.shape
    within = 16  # sites across a pixel; weights are the ink there
    sites = (
        np.stack(np.meshgrid((np.arange(w * within) + 0.5) / within, (np.arange(h * within) + 0.5) / within), axis=-1).reshape(-1, 2) / 2
    )
    weights = np.kron(PICTURE.coverage, np.ones((within, within))).ravel()
    smooth, edge, polynomial = figures(quadrature.of(sites, PICTURE, weights=weights))
    # the middle rule errs by h^2 / 24 times second derivatives, h = 1 / 640, up to 100 and 180; a half plane by a site or so in 600
    assert smooth < 1e-5 and polynomial < 2e-5 and edge < 2e-4


def test_the_order_of_sets_is_as_known() -> None:
    jittered = pooled([grid(32, rng=np.random.default_rng(seed)) for seed in range(10)])
    random = pooled([np.random.default_rng(seed).random((1024, 2)) for seed in range(10)])
    regular = figures(quadrature.of(grid(32), UNIT))
    assert (jittered < 0.3 * random).all()
    assert regular[0] < 0.15 * jittered[0] and regular[0] < 0.03 * random[0]
    assert regular[1] > 0.2 * jittered[1]  # an edge leaves a grid nearly as wrong as a jittered one


def test_errors_fall_with_the_number_as_each_kind_of_set_does() -> None:
    few, many = (figures(quadrature.of(grid(side), UNIT))[0] for side in (16, 64))
    assert few / many == pytest.approx(16, rel=0.2)  # 1 / n
    few, many = (pooled([grid(side, rng=np.random.default_rng(seed)) for seed in range(10)])[0] for side in (16, 64))
    assert few / many == pytest.approx(16, rel=0.4)  # 1 / n as well; ten sets


def test_relaxing_lessens_the_error_and_a_good_start_more() -> None:
    errors = {}
    for start in ("random", "even"):
        runs = [lloyd(scatter(UNIT, 1024, np.random.default_rng(seed), start), UNIT, step=1) for seed in range(4)]
        states = [[state.sites for state in islice(run, 21)] for run in runs]
        errors[start] = [pooled([sites[done] for sites in states]) for done in (0, 20)]
    assert errors["random"][1][0] < 0.75 * errors["random"][0][0]  # long waves of a random start last
    assert (errors["even"][0] < 0.3 * errors["random"][0]).all() and errors["even"][1][0] < 0.75 * errors["even"][0][0]


def test_weights_of_ink_make_up_for_uneven_cells() -> None:
    state = next(islice(lloyd(np.random.default_rng(1).random((1024, 2)), UNIT, step=1), 20, None))
    plain, weighed = (figures(quadrature.of(state.sites, UNIT, weights=w)) for w in (None, state.moments.mass))
    assert (weighed < 0.3 * plain).all()  # a centroid's rule is exact to the first order, as the grid's
    np.testing.assert_allclose(figures(quadrature.of(state.sites, UNIT, weights=np.full(1024, 7.0))), plain, rtol=1e-9)


def test_a_fault_in_the_tone_is_seen() -> None:
    sites = grid(32)
    assert (figures(quadrature.of(sites, Tone(np.array([[0.5, 0.6]]), (1, 1)))) > 10 * figures(quadrature.of(sites, UNIT))).all()
    assert figures(quadrature.of(sites * 0.99, UNIT))[2] > 5 * figures(quadrature.of(sites, UNIT))[2]


def test_figures_do_not_see_size_or_order() -> None:
    sites = np.random.default_rng(3).random((300, 2)) * PICTURE.size
    larger = Tone(PICTURE.coverage, (PICTURE.size[0] * 5, PICTURE.size[1] * 5))
    moved = np.random.default_rng(4).permutation(sites) * 5
    np.testing.assert_allclose(figures(quadrature.of(moved, larger)), figures(quadrature.of(sites, PICTURE)), rtol=1e-9)


def test_without_sites_weight_or_ink_there_is_no_error_to_tell() -> None:
    assert quadrature.of(np.zeros((0, 2)), UNIT) is None
    assert quadrature.of([(0.5, 0.5)], Tone(np.zeros((2, 2)), (1, 1))) is None
    assert quadrature.of([(0.5, 0.5)], UNIT, weights=[0]) is None
    assert np.isfinite(figures(quadrature.of([(0.5, 0.5)] * 3 + [(9, 9)], UNIT))).all()


def test_weights_of_another_number_than_the_sites_are_refused() -> None:
    with pytest.raises(ValueError, match="weights has shape"):
        quadrature.of([(0.5, 0.5)], UNIT, weights=[1, 2])
