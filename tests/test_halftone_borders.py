"""Outlines of black pixels are sound rings of exactly these pixels, and means of pixels over other grids lose nothing."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from crowquill import raster
from crowquill.halftone import halftoned
from crowquill.halftone.averages import averaged
from crowquill.halftone.borders import corners, rings
from crowquill.paths import Paths

Bits = npt.NDArray[np.bool_]
SEEDS = st.integers(0, 10**6)


def drawn(text: str) -> Bits:
    return np.array([[mark == "#" for mark in line] for line in text.split()])


def outlined(black: Bits, band: int = 3) -> Paths:
    """Rings of pixels that come some rows at a time."""
    parts = [black[top : top + band] for top in range(0, len(black), band)]
    paths = rings(parts)
    assert corners(parts, 10**9) == len(paths.xy)
    return paths


def check(black: Bits, paths: Paths) -> None:
    """Rings are sound, have a corner at every point, come to no place twice, and cover these pixels and no others."""
    assert shapely.is_valid(paths.polygons()).all(), "a ring crosses itself"
    for ring in paths:
        sides = np.diff(ring, axis=0, append=ring[:1])
        level = sides[:, 0] != 0
        assert ((sides != 0).sum(axis=1) == 1).all() and (level != np.roll(level, 1)).all(), "a point is no corner"
        assert len(np.unique(ring, axis=0)) == len(ring), "a ring comes to a place twice"
    assert paths.areas.sum() == black.sum(), "the area is another"
    # crossings are kept to 2^-24 of a pixel
    np.testing.assert_allclose(raster.covered(paths, black.shape, pixel=(1.0, 1.0)), black, atol=1e-6)


@settings(max_examples=200)
@given(SEEDS, st.integers(1, 12), st.integers(1, 12), st.sampled_from([0.2, 0.5, 0.6, 0.8]), st.integers(1, 5))
def test_rings_are_sound_and_cover_the_pixels(seed: int, h: int, w: int, share: float, band: int) -> None:
    black = np.random.default_rng(seed).random((h, w)) < share
    check(black, outlined(black, band))


def test_rings_of_a_halftone_cover_it_and_its_shapes_are_those_that_share_sides() -> None:
    black = halftoned(np.tile(np.linspace(0, 1, 120), (80, 1)))
    paths = outlined(black, 64)
    check(black, paths)
    assert (paths.areas > 0).sum() == ndimage.label(black)[1]


def test_neighbours_are_one_ring_with_no_seam_between() -> None:
    (ring,) = outlined(drawn("### #.. #.."))
    assert len(ring) == 6


@pytest.mark.parametrize(
    ("text", "areas"),
    [
        ("#. .#", [1, 1]),  # two that touch in a corner
        ("### #.# ###", [-1, 9]),  # a hole
        ("### #.# ##.", [-1, 8]),  # a bay that opens by a corner alone is a hole
        ("##. #.# .##", [3, 3]),
        ("#### #.## ##.# ####", [-1, -1, 16]),  # holes that touch are two
        ("##### #...# #.#.# #...# #####", [-9, 1, 25]),  # an island in a hole
    ],
)
def test_rings_of_small_pictures(text: str, areas: list[int]) -> None:
    paths = outlined(drawn(text))
    check(drawn(text), paths)
    assert sorted(paths.areas.tolist()) == areas


def test_the_check_sees_a_seam_a_lost_pixel_and_a_ring_that_touches_itself() -> None:
    black = drawn("##")
    split = [[(0, 0), (1, 0), (2, 0), (2, 1), (0, 1)]]
    with pytest.raises(AssertionError, match="no corner"):
        check(black, Paths.of(split))
    with pytest.raises(AssertionError, match="area"):
        check(black, Paths.of([[(0, 0), (1, 0), (1, 1), (0, 1)]]))
    eight = [[(0, 0), (1, 0), (1, 1), (2, 1), (2, 2), (1, 2), (1, 1), (0, 1)]]
    with pytest.raises(AssertionError):
        check(drawn("#. .#"), Paths.of(eight))


def test_no_pixels_have_no_rings_and_counting_stops_when_there_are_enough() -> None:
    assert len(outlined(np.zeros((4, 5), bool))) == 0 and len(rings([])) == 0 and corners([], 5) == 0
    checks = np.indices((100, 100)).sum(axis=0) % 2 == 1
    assert corners([checks[:50], checks[50:]], 10**9) == 4 * 5000
    assert 500 < corners((checks[top : top + 1] for top in range(100)), 500) < 900  # those of one row more at most


@given(SEEDS, st.integers(1, 9), st.integers(1, 9), st.integers(1, 12), st.integers(1, 12), st.floats(-3, 3), st.floats(-3, 3))
def test_means_over_another_grid_are_areas_of_overlap(seed: int, h: int, w: int, m: int, n: int, left: float, top: float) -> None:
    rng = np.random.default_rng(seed)
    values = rng.random((h, w))
    x, y = left + np.cumsum(rng.uniform(0.1, 3, n + 1)), top + np.cumsum(rng.uniform(0.1, 3, m + 1))

    def overlap(edges: npt.NDArray[np.float64], count: int) -> npt.NDArray[np.float64]:
        k = np.arange(count)
        shared = np.minimum(edges[1:, None], k + 1) - np.maximum(edges[:-1, None], k)
        return np.maximum(shared, 0) / np.diff(edges)[:, None]

    assert averaged(values, x, y) == pytest.approx(overlap(y, h) @ values @ overlap(x, w).T, abs=1e-12)


def test_a_grid_over_all_keeps_the_sum_and_the_same_grid_the_values() -> None:
    values = np.random.default_rng(1).random((37, 53))
    x, y = np.linspace(0, 53, 18), np.linspace(0, 37, 102)
    assert averaged(values, x, y).sum() * 53 / 17 * 37 / 101 == pytest.approx(values.sum(), rel=1e-12)
    bits = values < 0.5
    assert (averaged(bits.astype(float), np.arange(54.0), np.arange(38.0)) == bits).all()  # to the last bit
