"""Blurs and similarities are scipy's and scikit-image's; faults planted in a drawing are found, and their sizes are right."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import settings as setting
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter
from skimage.metrics import peak_signal_noise_ratio, structural_similarity

from crowquill import glyphs, likeness, raster, relax
from crowquill.marks import Marks
from crowquill.tone import Tone

Array = npt.NDArray[np.float64]
DISC = glyphs.load("disc").glyphs
SEEDS = st.integers(0, 2**32 - 1)
SIDE, AREA = 40.0, 0.07  # mm of the test drawing, and mm^2 of its dots, which are 0.3 mm across
GRID, PIXEL = (600, 600), (SIDE / 600, SIDE / 600)  # four and a half pixels to a dot


def hills(y: Array, x: Array) -> Array:
    """A picture that is smooth and has hills of every slope, at places in mm."""
    wanted = 0.4 + 0.13 * np.sin(0.7 * x + 0.2 * y) + 0.12 * np.cos(0.5 * y - 0.3 * x + 1) + 0.1 * np.sin(0.9 * y)
    return np.asarray(wanted)


def asked(dx: float = 0.0, dy: float = 0.0) -> Array:
    """The picture moved by so many mm."""
    row, column = np.indices(GRID)
    return hills((row + 0.5) * PIXEL[1] - dy, (column + 0.5) * PIXEL[0] - dx)


WANTED = asked()
TONE = Tone(WANTED, (SIDE, SIDE))
N = round(TONE.ink / AREA)
SPACING = float(np.sqrt(SIDE * SIDE / N))
SITES = next(state.sites for state in relax.lloyd(relax.scatter(TONE, N, np.random.default_rng(0)), TONE) if state.done == 12)


def dotted(*, dx: float = 0.0, dy: float = 0.0, ink: float = 1.0) -> Array:
    marks = Marks.of(SITES + np.array([dx, dy]), DISC, scale=np.sqrt(AREA * ink))
    return raster.covered(marks, GRID, pixel=PIXEL)


DOTTED = dotted()


@given(SEEDS)
@setting(max_examples=30)
def test_a_blur_is_scipys_at_every_so_many_pixels(seed: int) -> None:
    rng = np.random.default_rng(seed)
    values = rng.random(rng.integers(1, 60, 2))
    pixel, width = tuple(rng.uniform(0.05, 0.3, 2)), rng.uniform(0.05, 2)
    step = tuple(int(k) for k in rng.integers(1, 7, 2))
    wanted = gaussian_filter(values, (width / pixel[1], width / pixel[0]), mode="reflect")
    rows, columns = (np.arange(min((k - 1) // 2, n - 1), n, k) for k, n in zip(step, values.shape, strict=True))
    np.testing.assert_allclose(likeness.blurred(values, width, pixel, step), wanted[np.ix_(rows, columns)], atol=1e-12)
    assert likeness.blurred(values, 0, pixel).tolist() == values.tolist()


@pytest.mark.parametrize("width", [SPACING, 2 * SPACING, 0.1, 0.19])
def test_looking_at_every_few_pixels_changes_no_figure(width: float) -> None:
    got = likeness.tone_error(DOTTED, WANTED, PIXEL, width)
    error = gaussian_filter(DOTTED - WANTED, width / PIXEL[0], mode="reflect")
    assert got.bias == pytest.approx((DOTTED - WANTED).mean(), abs=1e-12)
    # samples do not quite end at the border: a part in a hundred of the rows there
    assert got.rmse == pytest.approx(np.sqrt((error**2).mean()), rel=0.01)
    assert sum(band.share for band in got.bands) == pytest.approx(1)
    assert sum(band.share * band.rmse**2 for band in got.bands) == pytest.approx(got.rmse**2)
    assert sum(band.share * band.bias for band in got.bands) == pytest.approx(got.bias, abs=2e-4)


def test_a_perfect_copy_has_no_fault_and_a_bias_everywhere_is_the_bias() -> None:
    same, more = (likeness.tone_error(WANTED + extra, WANTED, PIXEL, SPACING) for extra in (0.0, 0.02))
    assert (same.bias, same.rmse) == (0, 0) and not same.error.any()
    assert more.bias == pytest.approx(0.02) and more.rmse == pytest.approx(0.02)
    assert more.worst is not None and more.worst.bias == pytest.approx(0.02) == more.worst.rmse
    assert likeness.scored(WANTED + 0.02, WANTED) == pytest.approx(0.02)


def test_a_fault_in_one_band_of_tone_is_found_in_that_band_and_on_the_map() -> None:
    steps = np.repeat(np.arange(10) / 10 + 0.05, 60)[None, :].repeat(300, axis=0)
    off = steps + 0.03 * (steps == 0.65)
    got = likeness.tone_error(off, steps, (0.1, 0.1), 0.3)
    assert got.worst is not None and (got.worst.low, got.worst.high) == (0.6, 0.7)
    assert got.worst.bias == pytest.approx(0.03, rel=0.1)  # a tenth of the band lies within a blur of its ends
    assert 0.6 < np.argmax(got.error.max(axis=0)) / got.error.shape[1] < 0.7
    half = likeness.tone_error(off, steps, (0.1, 0.1), 0.3, within=(steps < 0.5) * 1.0)
    assert half.rmse == 0 and half.bias == 0


@pytest.mark.parametrize("share", [0.98, 1.02])
def test_two_hundredths_more_or_less_ink_are_found_in_a_drawing_of_dots(share: float) -> None:
    still, heavy = (likeness.tone_error(dotted(ink=ink), WANTED, PIXEL, SPACING) for ink in (1.0, share))
    # where dots meet, ink is lost to overlap: a tenth of the fault
    assert heavy.bias - still.bias == pytest.approx((share - 1) * WANTED.mean(), rel=0.1)


@given(SEEDS)
@setting(max_examples=15)
def test_similarities_are_those_of_scikit_image(seed: int) -> None:
    rng = np.random.default_rng(seed)
    one = gaussian_filter(rng.uniform(0, 255, rng.integers(11, 60, 2)), rng.uniform(0, 3))
    other = np.clip(one + rng.normal(0, rng.uniform(0, 60), one.shape), 0, 255)
    wanted = structural_similarity(one, other, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=255)
    assert likeness.ssim(one, other) == pytest.approx(wanted, abs=1e-12)
    assert likeness.psnr(one, other) == pytest.approx(peak_signal_noise_ratio(one, other, data_range=255), abs=1e-9)


def test_the_same_picture_is_wholly_similar_and_a_negative_is_not() -> None:
    assert likeness.similarity(WANTED, WANTED, PIXEL, SPACING) == (1.0, np.inf)
    similar, noise = likeness.similarity(DOTTED, WANTED, PIXEL, SPACING)
    assert 0.8 < similar < 1 and 25 < noise < 60
    assert likeness.similarity(1 - WANTED, WANTED, PIXEL, SPACING)[0] < 0.5 * similar
    with pytest.raises(ValueError, match="after a blur only"):
        likeness.similarity(WANTED, WANTED, PIXEL, 0)


def test_a_copy_keeps_all_edges_a_flat_drawing_none_and_a_blurred_one_some() -> None:
    stripes = (np.indices(GRID)[1] // 30 % 2) * 0.6 + 0.2  # 2 mm
    kept = [likeness.edges_kept(gaussian_filter(stripes, sigma), stripes, PIXEL, SPACING) for sigma in (0, 3, 6, 12)]
    assert kept[0] == pytest.approx(1, abs=1e-12) and all(a > b + 0.02 for a, b in pairwise(kept)) and kept[-1] > 0
    assert likeness.edges_kept(np.full(GRID, 0.5), stripes, PIXEL, SPACING) == pytest.approx(0, abs=1e-12)
    assert likeness.edges_kept(0.5 * stripes + 0.1, stripes, PIXEL, SPACING) == pytest.approx(0.5)
    assert likeness.edges_kept(1 - stripes, stripes, PIXEL, SPACING) == pytest.approx(-1)


def test_edges_that_dots_make_of_themselves_are_not_counted() -> None:
    assert likeness.edges_kept(DOTTED, WANTED, PIXEL, SPACING) == pytest.approx(1, abs=0.03)
    strangers = dotted(dx=7.0, dy=3.0)  # the same dots of another place
    assert likeness.edges_kept(strangers, WANTED, PIXEL, SPACING) < 0.5


@pytest.mark.parametrize(("dx", "dy"), [(0.03, 0.0), (0.0, -0.03), (0.4, 0.25), (-1.5, 2.0)])
def test_a_shift_of_a_picture_is_found_within_a_micrometre(dx: float, dy: float) -> None:
    got = likeness.shift(asked(dx, dy), WANTED, PIXEL, SPACING)
    assert (got.x, got.y) == pytest.approx((dx, dy), abs=1e-3)


@pytest.mark.parametrize(("dx", "dy"), [(0.03, 0.0), (0.0, -0.03), (0.02, 0.1)])
@pytest.mark.parametrize("ink", [1.0, 1.02])
def test_a_shift_of_thirty_micrometres_is_found_in_a_drawing_of_dots_within_five(dx: float, dy: float, ink: float) -> None:
    still = likeness.shift(DOTTED, WANTED, PIXEL, SPACING)
    moved = likeness.shift(dotted(dx=dx, dy=dy, ink=ink), WANTED, PIXEL, SPACING)
    assert (moved.x - still.x, moved.y - still.y) == pytest.approx((dx, dy), abs=5e-3)
    # the drawing's own place is known as well as its dots tell it
    assert abs(still.x) < 2 * still.x_error and abs(still.y) < 2 * still.y_error


def test_a_shift_is_told_from_a_fault_of_tone() -> None:
    got = likeness.shift(0.8 * asked(0.03, 0.0) + 0.05, WANTED, PIXEL, SPACING)
    assert (got.x, got.y) == pytest.approx((0.03, 0), abs=1e-3)


def test_along_its_stripes_a_picture_does_not_tell_a_shift() -> None:
    stripes = 0.5 + 0.3 * np.sin(np.indices(GRID)[1] / 20)
    moved = 0.5 + 0.3 * np.sin((np.indices(GRID)[1] - 0.6) / 20)
    got = likeness.shift(moved, stripes, PIXEL, SPACING)
    assert got.x == pytest.approx(0.6 * PIXEL[0], abs=1e-3) and got.y == 0 and got.y_error == np.inf


@given(SEEDS)
@setting(max_examples=20)
def test_tone_on_another_grid_has_the_same_ink(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tone = Tone(rng.random(rng.integers(1, 12, 2)), (3.0, 2.0))
    grid = tuple(int(n) for n in rng.integers(1, 30, 2))
    assert likeness.asked(tone, grid).mean() == pytest.approx(tone.coverage.mean(), abs=1e-12)
    h, w = tone.coverage.shape
    fine = likeness.asked(tone, (3 * h, 2 * w))
    np.testing.assert_allclose(fine, np.kron(tone.coverage, np.ones((3, 2))), atol=1e-12)
    np.testing.assert_allclose(likeness.asked(Tone(fine, tone.size), (h, w)), tone.coverage, atol=1e-12)


@pytest.mark.parametrize("shape", [(0, 0), (0, 5), (1, 1), (1, 9), (3, 2), (30, 30)])
@pytest.mark.parametrize("value", [0.0, 0.3, 1.0])
def test_constant_and_tiny_pictures_have_figures(shape: tuple[int, int], value: float) -> None:
    flat = np.full(shape, value)
    for width in (0.0, 0.05, 0.4, 9.0):
        got = likeness.tone_error(flat, flat, (0.1, 0.2), width)
        assert (got.bias, got.rmse) == (0, 0)
        assert all(np.isfinite([band.share, band.bias, band.rmse]).all() for band in got.bands)
        assert (got.worst is None) == (flat.size == 0)
        assert likeness.edges_kept(flat, flat, (0.1, 0.2), width) == 1
    assert likeness.scored(flat, flat) == 0
    assert likeness.similarity(flat, flat, (0.1, 0.2), 0.3) == (1, np.inf)
    found = likeness.shift(flat, flat, (0.1, 0.1), 0.3)
    assert (found.x, found.y, found.x_error, found.y_error) == (0, 0, np.inf, np.inf)


def test_what_cannot_be_compared_is_refused() -> None:
    one, two = np.zeros((3, 4)), np.zeros((4, 3))
    for call in (
        lambda: likeness.tone_error(one, two, (1, 1), 1),
        lambda: likeness.ssim(one, two),
        lambda: likeness.ssim(one, np.full((3, 4), np.nan)),
        lambda: likeness.blurred(one, -1, (1, 1)),
        lambda: likeness.shift(one, one, (1, 1), 0),
    ):
        with pytest.raises(ValueError, match="take"):
            call()
