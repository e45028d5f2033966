"""Numbers by pixel: as numbers or as codes they are the same, and so are their sums by row, whole or in bands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from crowquill import hilbert
from crowquill import levels as module
from crowquill.halftone.averages import averaged
from crowquill.levels import BLOCK, Levels, bands
from crowquill.tone import Tone

SHAPES = [(1, 1), (1, 63), (3, 64), (5, 65), (37, 191), (64, 128), (50, 300)]


def coded(shape: tuple[int, int], kind: str = "u1", seed: int = 0) -> Levels:
    rng = np.random.default_rng(seed)
    table = rng.random(256 if kind == "u1" else 65536)
    return Levels(rng.integers(0, len(table), shape).astype(kind), table)


def by_numpy(values: np.ndarray) -> np.ndarray:
    """The sums of whole rows, by NumPy's own running sums."""
    h, w = values.shape
    table, i = np.zeros((h, w, 4)), np.arange(w) % BLOCK
    table[:, :, 3] = values
    for p in range(3):
        part = values * (((i + 1.0) ** (p + 1) - i ** float(p + 1)) / (p + 1))
        for left in range(0, w, BLOCK):
            right = min(left + BLOCK, w)
            table[:, left + 1 : right, p] = np.cumsum(part[:, left : right - 1], axis=1)
    return table


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("kind", ["u1", "u2", "f8"])
def test_sums_by_row_are_numpys_bit_for_bit_whole_and_in_bands(shape: tuple[int, int], kind: str) -> None:
    levels = Levels(np.random.default_rng(1).random(shape)) if kind == "f8" else coded(shape, kind)
    tone, want = Tone(levels, (10, 10)), by_numpy(levels.whole())
    assert tone.prefix.tobytes() == want.tobytes()
    for step in (1, 7, 16, 17, 64):
        bands = [tone.prefix_of(top, top + step) for top in range(0, shape[0], step)]
        assert np.concatenate(bands).tobytes() == want.tobytes()
    assert tone.prefix_of(shape[0], shape[0] + 5).shape == (0, shape[1], 4)


@pytest.mark.parametrize("kind", ["u1", "u2"])
def test_codes_are_the_numbers_that_they_stand_for(kind: str) -> None:
    levels = coded((37, 91), kind)
    plain = Levels(levels.whole())
    assert levels.rows(3, 9).tobytes() == plain.codes[3:9].tobytes()
    row, column = np.array([0, 36, 5]), np.array([90, 0, 44])
    assert levels.at(row, column).tolist() == plain.at(row, column).tolist() == plain.codes[row, column].tolist()
    assert levels.mapped(np.square).whole().tobytes() == plain.mapped(np.square).codes.tobytes()
    cut = levels.cut(slice(2, 30), slice(5, 60))
    assert cut.whole().tobytes() == plain.cut(slice(2, 30), slice(5, 60)).codes.tobytes()
    assert cut.sum() == pytest.approx(cut.whole().sum(), rel=1e-12)


def test_a_tone_of_codes_is_the_tone_of_their_numbers() -> None:
    levels = coded((40, 60))
    coarse, plain = Tone(levels, (30, 20)), Tone(levels.whole(), (30, 20))
    assert coarse.ink == pytest.approx(plain.ink, rel=1e-12)
    assert coarse.shape == plain.shape and coarse.coverage.tobytes() == plain.coverage.tobytes()
    for changed in (lambda t: t.fitted(20.0, 20.0, "cover"), lambda t: t.mapped(lambda c: 1 - c), lambda t: t.fitted(width=9)):
        assert changed(coarse).coverage.tobytes() == changed(plain).coverage.tobytes()


def test_a_number_outside_its_range_is_refused_only_where_a_pixel_has_it() -> None:
    table = np.array([0.0, 0.5, 2.0])
    Tone(Levels(np.array([[0, 1]], np.uint8), table), (2, 1))
    with pytest.raises(ValueError, match="coverage runs from 0 to 2; it takes 0 to 1"):
        Tone(Levels(np.array([[0, 2]], np.uint8), table), (2, 1))


def test_codes_given_to_levels_cannot_be_changed() -> None:
    levels = coded((3, 3))
    with pytest.raises(ValueError, match="read-only"):
        levels.codes[0, 0] = 1


@pytest.mark.parametrize("shape", SHAPES)
def test_percentiles_of_codes_are_numpys_bit_for_bit(shape: tuple[int, int]) -> None:
    for seed in range(20):
        levels, shares = coded(shape, seed=seed), (0.0, 0.5, 3.7, 50.0, 99.5, 100.0)
        assert levels.percentiles(shares).tolist() == np.percentile(levels.whole(), shares).tolist()


def test_bands_are_all_rows_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "BAND", 100)
    assert list(bands((7, 30))) == [(0, 3), (3, 6), (6, 7)]
    assert list(bands((2, 1000))) == [(0, 1), (1, 2)] and list(bands((3, 10))) == [(0, 3)]


def test_many_numbers_are_kept_to_half_a_code_and_few_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    values = np.random.default_rng(0).random((40, 30))
    assert Levels.filled((40, 30), lambda lo, hi: values[lo:hi]).whole().tobytes() == values.tobytes()
    monkeypatch.setattr(module, "LARGE", 1200)
    levels = Levels.filled((40, 30), lambda lo, hi: values[lo:hi])
    assert levels.codes.dtype == np.uint16 and abs(levels.whole() - values).max() <= 0.5 / module.DEPTH


def test_a_picture_keeps_the_depth_of_its_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    greys = np.random.default_rng(0).integers(0, 65536, (40, 30)).astype(np.uint16)
    Image.fromarray(greys).save(tmp_path / "deep.tif")
    Image.fromarray((greys >> 8).astype(np.uint8)).save(tmp_path / "grey.png")
    Image.fromarray(np.stack([greys >> 8] * 3, axis=2).astype(np.uint8)).save(tmp_path / "rgb.png")
    for name, kind, near in (("grey.png", np.uint8, 0.0), ("deep.tif", np.uint16, 0.0), ("rgb.png", np.uint16, 2 / module.DEPTH)):
        plain = Tone.load(tmp_path / name)
        with monkeypatch.context() as patched:
            patched.setattr(module, "LARGE", 1000)
            coded_tone = Tone.load(tmp_path / name)
        assert plain.levels.table is None and coded_tone.levels.codes.dtype == kind
        assert abs(coded_tone.coverage - plain.coverage).max() <= near


def by_sorting(values: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """The same pixels by the curve's keys of all of them at once."""
    row, column = np.divmod(np.arange(values.size), values.shape[1])
    order = np.argsort(hilbert._keys(row, column, 1 << max(1, max(values.shape) - 1).bit_length()), kind="stable")
    total = np.cumsum(values.ravel()[order])
    found = order[np.searchsorted(total, np.minimum(shares * total[-1], np.nextafter(total[-1], 0)), side="right")]
    return np.stack(np.divmod(found, values.shape[1])[::-1], axis=1)


@pytest.mark.parametrize("shape", [*SHAPES, (2, 2), (200, 3), (129, 257), (64, 64), (65, 1)])
@pytest.mark.parametrize("kind", ["u1", "u2", "f8"])
@pytest.mark.parametrize("split", [1, 2, 3])
def test_along_the_curve_block_by_block_are_the_pixels_of_all_keys_sorted(shape: tuple[int, int], kind: str, split: int) -> None:
    levels = Levels(np.random.default_rng(1).random(shape)) if kind == "f8" else coded(shape, kind)
    if shape != (1, 1):  # places without ink are passed over
        levels = levels.mapped(lambda v: np.where(v < 0.3, 0.0, v))
    shares = (np.arange(500) + np.random.default_rng(2).random(500)) / 500
    values = np.kron(levels.whole(), np.ones((split, split)))
    assert hilbert.passed(levels, shares, split).tolist() == by_sorting(values, shares).tolist()


@pytest.mark.parametrize("shape", [(1, 1), (37, 191), (64, 128), (300, 50)])
def test_means_of_codes_are_those_of_their_numbers(shape: tuple[int, int]) -> None:
    levels = coded(shape)
    x, y = np.linspace(-0.7, shape[1], 9), np.linspace(0.3, shape[0] + 1.2, 41)
    np.testing.assert_allclose(averaged(levels, x, y), averaged(levels.whole(), x, y), atol=1e-12)
