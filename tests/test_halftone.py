"""Black pixels whose local share is the coverage."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter

from crowquill.halftone import floyd_steinberg

found = settings(max_examples=60)


def plain_twin(coverage: np.ndarray) -> np.ndarray:
    """Floyd and Steinberg's diffusion as printed, in Python: every product and sum in the same order."""
    h, w = coverage.shape
    rest, black = np.pad(coverage, ((0, 1), (1, 1))), np.zeros((h, w), bool)
    for r in range(h):
        for c in range(w):
            black[r, c] = rest[r, c + 1] >= 0.5
            error = rest[r, c + 1] - black[r, c]
            for down, right, share in ((0, 1, 7), (1, -1, 3), (1, 0, 5), (1, 1, 1)):
                rest[r + down, c + 1 + right] += error * share / 16
    return black


@pytest.mark.parametrize("coverage", [0.05, 0.25, 0.4, 0.5, 0.75, 0.95])
def test_flat_tones_keep_their_mean(coverage: float) -> None:
    assert floyd_steinberg(np.full((256, 256), coverage)).mean() == pytest.approx(coverage, abs=0.002)  # published for 256 x 256


@pytest.mark.parametrize(
    ("coverage", "rms"),
    [
        (0.25, 0.0005),  # published as .000
        (0.4, 0.0036),  # published as .003; this patch has .0035, a random threshold .070
        (0.5, 0.0005),  # a chequerboard
    ],
)
def test_flat_tones_look_flat_from_afar(coverage: float, rms: float) -> None:
    black = floyd_steinberg(np.full((256, 256), coverage))
    seen = gaussian_filter(black.astype(float), 2)[32:-32, 32:-32]  # the error starts from nothing at the border
    assert seen.std() <= rms


def test_a_ramp_looks_like_a_ramp_from_afar() -> None:
    ramp = np.tile(np.linspace(0, 1, 256), (256, 1))
    wrong = gaussian_filter(floyd_steinberg(ramp) - ramp, 4)[32:-32, 32:-32]
    assert wrong.std() <= 0.0016  # published as .0014; diffusion into finished rows gives .13


def test_rows_answer_each_other() -> None:
    black = floyd_steinberg(np.full((256, 256), 0.3))
    # published; 1.00 when rows are independent or errors go to finished rows
    assert np.corrcoef(black[:-1].ravel(), black[1:].ravel())[0, 1] == pytest.approx(-0.42, abs=0.01)


@found
@given(st.integers(0, 10**6), st.integers(1, 40), st.integers(1, 40))
def test_pixels_are_those_of_the_plain_twin(seed: int, h: int, w: int) -> None:
    coverage = np.random.default_rng(seed).random((h, w))
    assert (floyd_steinberg(coverage) == plain_twin(coverage)).all()


@found
@given(st.integers(0, 10**6), st.integers(1, 60), st.integers(1, 60), st.floats(0.1, 10))
def test_ink_is_lost_at_the_border_only(seed: int, h: int, w: int, gamma: float) -> None:
    coverage = np.random.default_rng(seed).random((h, w)) ** gamma
    off = np.cumsum((floyd_steinberg(coverage) - coverage).sum(axis=1))
    # an error is at most 1/2; off a row's ends fall 3/16 and 8/16 of it, and rows yet to come owe 9/16 a column
    assert (np.abs(off) <= (11 * np.arange(1, h + 1) + 9 * w) / 32 + 1e-9).all()  # rounding of some thousand sums


@pytest.mark.parametrize("shape", [(1, 1), (1, 50), (50, 1), (30, 40)])
def test_white_has_no_black_pixel_and_black_has_all(shape: tuple[int, int]) -> None:
    assert not floyd_steinberg(np.zeros(shape)).any()
    assert floyd_steinberg(np.ones(shape)).all()


@pytest.mark.parametrize(("coverage", "black"), [(0, False), (0.49, False), (0.5, True), (1, True)])
def test_one_pixel_is_black_from_one_half(coverage: float, black: bool) -> None:
    assert floyd_steinberg([[coverage]]).tolist() == [[black]]


def test_four_pixels_by_hand() -> None:
    # .6 is black, owes -.4: .6 - .175 = .425 is white, 7/16 .425 is lost; below .6 - .125 + 3/16 .425 = .5547 is black
    # and owes -.4453; last .6 - .025 + 5/16 .425 - 7/16 .4453 = .5130 is black
    assert floyd_steinberg(np.full((2, 2), 0.6)).tolist() == [[True, False], [True, True]]


def test_no_pixels_give_none_and_the_input_is_left_alone() -> None:
    coverage = np.full((3, 3), 0.4)
    assert floyd_steinberg(coverage).dtype == np.bool_ and (coverage == 0.4).all()
    assert floyd_steinberg(np.zeros((0, 5))).shape == (0, 5)


@pytest.mark.parametrize("shape", [(), (4,), (2, 2, 3)])
def test_what_is_no_picture_is_refused(shape: tuple) -> None:
    with pytest.raises(ValueError, match="coverage has shape"):
        floyd_steinberg(np.zeros(shape))
