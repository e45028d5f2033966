"""Contrast-aware diffusion against the figures of a reference run, of a ramp of whole levels, 96 by 48 pixels, from black to white."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy.ndimage import gaussian_filter1d

from crowquill.halftone import halftoned
from crowquill.halftone.contrast import Diffusing

Picture = npt.NDArray[np.float64]
RAMP = 1 - np.floor(np.tile(np.arange(96) * 255 / 95, (48, 1))) / 255
QUARTER = 24
# G+ = G- with k .1: share of black by raster, by priority, and by priority in each quarter
TABLE = {
    0: (0.500, 0.499, (0.881, 0.625, 0.373, 0.118)),
    1: (0.360, 0.378, (0.716, 0.441, 0.261, 0.093)),
    2: (0.244, 0.268, (0.534, 0.296, 0.171, 0.070)),
    3: (0.161, 0.188, (0.388, 0.197, 0.115, 0.053)),
    5: (0.085, 0.105, (0.217, 0.098, 0.061, 0.044)),
    8: (0.056, 0.061, (0.130, 0.083, 0.021, 0.010)),
}
CHANCE = 0.003  # by which one seed moves the whole, and twice that a quarter


def drawn(picture: Picture, seed: int, **values: Any) -> Picture:
    return Diffusing(**values).black(picture, np.random.default_rng(seed)).astype(float)


@cache
def mean(order: str, g: float) -> Picture:
    """Of four seeds."""
    return np.mean([drawn(RAMP, seed, order=order, more=g, less=g, extra=0.1) for seed in range(4)], axis=0)


@pytest.mark.parametrize("g", TABLE)
def test_a_ramp_has_as_many_black_pixels_as_published(g: int) -> None:
    raster, priority, quarters = TABLE[g]
    assert mean("raster", g).mean() == pytest.approx(raster, abs=CHANCE)
    assert mean("priority", g).mean() == pytest.approx(priority, abs=CHANCE)
    assert mean("priority", g).reshape(48, 4, QUARTER).mean(axis=(0, 2)) == pytest.approx(quarters, abs=2 * CHANCE)


def test_the_check_of_the_table_sees_another_exponent_and_another_mask() -> None:
    other = drawn(RAMP, 0, order="raster", exponent=0.5, more=3, less=3, extra=0.1).mean()
    wide = drawn(RAMP, 0, mask=11, more=3, less=3, extra=0.1).mean()
    assert abs(other - TABLE[3][0]) > 2 * CHANCE and abs(wide - TABLE[3][1]) > 2 * CHANCE


@pytest.mark.parametrize("order", ["priority", "raster"])
def test_the_larger_g_the_fewer_are_black(order: str) -> None:
    counts = [mean(order, g).sum() for g in TABLE]
    assert all(fewer < more for more, fewer in pairwise(counts))


def test_each_of_the_two_g_makes_fewer_black() -> None:
    plain, more, less, both = (drawn(RAMP, 1, more=a, less=b).mean() for a, b in ((0, 0), (3, 0), (0, 3), (3, 3)))
    assert both < min(more, less) and max(more, less) < plain


def test_what_a_dot_has_beyond_its_pixel_hardly_counts_by_the_published_k() -> None:
    counts = [np.mean([drawn(RAMP, seed, more=5, less=5, extra=k).sum() for seed in range(4)]) for k in (0.0, 0.1, 100.0)]
    assert counts[1] == pytest.approx(counts[0], rel=0.015)  # published: below 1 %, where seeds differ by as much
    assert counts[2] < 0.8 * counts[0]


@pytest.mark.parametrize(("order", "least"), [("priority", 1.3), ("raster", 1.2)])
def test_an_edge_keeps_more_contrast_than_floyd_and_steinberg_leave_it(order: str, least: float) -> None:
    step = gaussian_filter1d(np.tile(np.where(np.arange(80) < 40, 0.4, 0.6), (200, 1)), 2, axis=1)

    def contrast(black: Picture) -> float:
        return float(black[:, 40:43].mean() - black[:, 37:40].mean())

    ours = np.mean([contrast(drawn(step, seed, order=order)) for seed in range(8)])
    theirs = np.mean([contrast(halftoned(step, "floyd-steinberg", rng=np.random.default_rng(seed)).astype(float)) for seed in range(8)])
    assert ours >= least * theirs  # published: 1.1; here 1.5 and 1.4


def test_a_grey_line_a_pixel_wide_stays_a_line_of_its_own() -> None:
    picture = np.full((60, 60), 0.5)
    picture[:, 30] = 0.8
    assert drawn(picture, 2)[:, 30].mean() > 0.9 > drawn(picture, 2)[:, 20].mean() + 0.2


@pytest.mark.parametrize("order", ["priority", "raster"])
@pytest.mark.parametrize("g", [0.0, 5.0])
def test_white_stays_white_and_black_black(order: str, g: float) -> None:
    picture = np.random.default_rng(3).random((40, 40))
    picture[:, :8], picture[:, -8:] = 0.0, 1.0
    black = drawn(picture, 3, order=order, more=g, less=g)
    assert not black[:, :8].any() and black[:, -8:].all()


def test_pixels_that_take_no_part_are_white_and_take_no_error() -> None:
    held = np.ones((30, 60), bool)
    held[:, 30:] = False
    other = np.random.default_rng(0).random((30, 60))
    pictures = [np.where(held, 0.4, part) for part in (0.0, 1.0, other)]
    found = [Diffusing().black(picture, np.random.default_rng(1), held) for picture in pictures]
    assert not found[0][:, 30:].any() and found[0].sum() == pytest.approx(0.4 * 900, rel=0.02)
    assert all(np.array_equal(found[0], part) for part in found[1:])


@pytest.mark.parametrize("shape", [(0, 5), (1, 1), (1, 300), (300, 1)])
@pytest.mark.parametrize("order", ["priority", "raster"])
def test_pictures_of_few_pixels_have_an_answer(order: str, shape: tuple[int, int]) -> None:
    black = drawn(np.full(shape, 0.3), 0, order=order)
    assert black.shape == shape and black.sum() == pytest.approx(0.3 * black.size, abs=8)  # errors at the end find nobody


def test_the_same_seed_gives_the_same_pixels_and_another_does_not() -> None:
    picture = np.full((30, 30), 0.5)
    assert np.array_equal(drawn(picture, 1), drawn(picture, 1)) and not np.array_equal(drawn(picture, 1), drawn(picture, 2))


def test_what_is_no_coverage_and_no_order_is_refused() -> None:
    with pytest.raises(ValueError, match="no order 'spiral'; there are priority, raster"):
        Diffusing("spiral")
    for wrong in ([0.5], [[1.5]], [[np.nan]]):
        with pytest.raises(ValueError, match="coverage has shape"):
            Diffusing().black(wrong, np.random.default_rng(0))
