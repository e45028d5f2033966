"""Learning from a scan: synthesised tiles against the example's texture, style files, examples nobody prepared, and bad ones."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from crowquill import Tone, draw, exemplar, measure, relax, texture, to_bytes
from crowquill.exemplar import kept, learning, stylefile
from crowquill.exemplar.correlation import lens, radial
from crowquill.exemplar.style import Hand, Level, Tile
from crowquill.exemplar.synthesis import _Marks
from crowquill.marks import Marks
from crowquill.paths import Array
from crowquill.raster import covered
from crowquill.stippling import dotted

HAND = exemplar.load("hand")
DPI = 600.0
PIXEL = 25.4 / DPI


def codes(ink: Array, paper: float = 0.9, blur: float = 0.7) -> Array:
    """A scan of ink (h, w) of 0 to 1, as sRGB code values."""
    light = ndimage.gaussian_filter(paper + (0.04 - paper) * ink, blur)
    return np.asarray(1.055 * light ** (1 / 2.4) - 0.055)


def page(*parts: Marks, size: tuple[float, float]) -> Array:
    shape = (round(size[1] / PIXEL), round(size[0] / PIXEL))
    ink = np.zeros(shape)
    for marks in parts:
        ink = np.maximum(ink, covered(marks, shape, pixel=(PIXEL, PIXEL)))
    return ink


@pytest.fixture(scope="module")
def plate(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A drawing that nobody prepared: a stippled wedge, scanned askew in uneven light, noisy, yellow, smudged, the lid's shadow on it."""
    y, x = np.indices((60, 80)) / 60
    wedge = np.clip(0.05 + 0.5 * np.round(4 * x / 1.34) / 4 - 0.1 * (np.hypot(x - 0.3, y - 0.8) < 0.15), 0, 1)
    marks = draw("stipple", Tone(wedge, (48, 20)), pen=0.35).marks
    code = ndimage.rotate(codes(page(marks.moved((2, 2)), size=(52, 24))), 1.7, reshape=False, order=1, mode="nearest")
    code *= 1 - 0.1 * np.linspace(0, 1, code.shape[1])
    code[:, :18] *= np.linspace(0.3, 1, 18)
    y, x = np.indices(code.shape)
    code -= 0.08 * np.exp(-(((x - 900) / 120) ** 2) - ((y - 60) / 40) ** 2)
    noisy = code + np.random.default_rng(0).normal(0, 0.01, code.shape)
    path = tmp_path_factory.mktemp("scan") / "plate.png"
    rgb = np.clip(noisy[:, :, None] * (1, 0.97, 0.82), 0, 1)
    Image.fromarray((255 * rgb).astype(np.uint8)).save(path, dpi=(DPI, DPI))
    return str(path)


@pytest.fixture(scope="module")
def taught(plate: str) -> exemplar.Style:
    return learning.learn(plate)


HANDS = {f"{name} {ink}": getattr(exemplar.load(name), ink) for name in exemplar.names() for ink in ("black", "white")}


def apart(one: Array, level: Level, spacing: float) -> float:
    """The rms difference of a correlation from an example's, from the first step up to three mean spacings."""
    near = (level.lags > 0) & (level.lags <= 3 * spacing)
    return float(np.sqrt(np.mean((one - level.correlation)[near] ** 2)))


@pytest.mark.parametrize("hand", HANDS.values(), ids=HANDS)
def test_a_tile_has_in_each_tone_the_texture_of_the_example(hand: Hand) -> None:
    for level in hand.levels:
        sites = hand.tile.of(level.coverage)
        ink = _Marks(sites, hand.tile.side, hand).drawn(len(sites))
        curve = radial(ink, level.lags, hand.tile.side / len(ink))
        assert apart(curve, level, hand.tile.side / np.sqrt(len(sites))) < 0.03


@pytest.mark.parametrize("k", range(len(HAND.black.levels)))
def test_relaxed_dots_have_not_the_texture_of_the_clustered_example(k: int) -> None:
    level, hand, side = HAND.black.levels[k], HAND.black, 20.0
    spacing = hand.tile.side / np.sqrt(len(hand.tile.of(level.coverage)))
    tone = Tone(np.full((4, 4), 0.5), (side, side))
    first = relax.scatter(tone, round((side / spacing) ** 2), np.random.default_rng(0))
    relaxed = next(state.sites for state in relax.lloyd(first, tone, step=1) if state.done == 50)
    dots = dotted(relaxed, hand.glyphs, 2 * np.sqrt(hand.area / np.pi), np.random.default_rng(1))
    ink = measure.rendered(dots, (side, side), (400, 400)) >= 0.5
    # correlation is in proportion to coverage where dots are few: of light tones even the most regular is small
    assert apart(radial(ink, level.lags, side / 400, np.ones(ink.shape)), level, spacing) > min(0.08, 0.6 * level.coverage)


@pytest.mark.parametrize("hand", HANDS.values(), ids=HANDS)
def test_marks_of_a_tone_are_there_in_the_next_and_overlap_where_they_were(hand: Hand) -> None:
    steps = [hand.tile.of(level.coverage) for level in sorted(hand.levels, key=lambda level: level.coverage)]
    for one, other in pairwise(steps):
        assert len(other) > len(one)
        assert np.hypot(*(other[: len(one)] - one).T).max() <= 0.51 * 2 * np.sqrt(hand.area / np.pi)  # places are kept in whole steps


def test_marks_in_groups_keep_their_places_up_to_the_darkest_tone_but_one() -> None:
    steps = [HAND.black.tile.of(level.coverage) for level in HAND.black.levels[:-1]]
    for one, other in pairwise(steps):
        # a tone is met to half a percent of it: marks that slide further on may be so far on their way
        assert (np.hypot(*(other[: len(one)] - one).T) < 5e-3).mean() >= 0.95


@pytest.mark.parametrize("name", exemplar.names())
def test_half_way_between_two_tones_half_of_what_comes_between_them_is_there(name: str) -> None:
    fresh, there = 0, 0
    for hand in (HANDS[f"{name} black"], HANDS[f"{name} white"]):
        for low, high in pairwise(sorted(level.coverage for level in hand.levels)):
            steps = [hand.tile.of(coverage) for coverage in (low, (low + high) / 2, high)]
            ink = [_Marks(sites, hand.tile.side, hand).drawn(len(sites)).mean() for sites in steps]
            assert (ink[1] - ink[0]) / (ink[2] - ink[0]) == pytest.approx(0.5, abs=0.015)
            fresh, there = fresh + len(steps[2]) - len(steps[0]), there + len(steps[1]) - len(steps[0])
    assert fresh > 9500 and there / fresh == pytest.approx(0.5, abs=0.015)  # chance alone would move it by .005


def test_a_tile_laid_otherwise_has_its_marks_in_it_and_they_slide_as_they_did() -> None:
    tile = HANDS["even black"].tile
    other = tile.laid(True, True, np.array([0.3, 0.9]))
    assert ((other.xy[-1] >= 0) & (other.xy[-1] < tile.side)).all() and other.stray == pytest.approx(tile.stray)
    assert np.diff(other.xy, axis=0) == pytest.approx(np.diff(tile.xy, axis=0)[..., ::-1] * (-1, 1))


def test_between_two_tones_marks_are_on_the_way() -> None:
    tile = Tile(9.0, [0.1, 0.2], [0.2, 0.4], [[(1, 1), (5, 5)], [(2, 1), (5, 6)]])
    assert tile.at(np.array([0, 0, 0, 1]), np.array([0.1, 0.2, 0.25, 0.9])) == pytest.approx(np.array([(1, 1), (1, 1), (1.25, 1), (5, 6)]))
    assert tile.of(0.15) == pytest.approx(np.array([(1, 1)])) and tile.of(0.05).shape == (0, 2)
    assert tile.stray == pytest.approx(1)


def test_the_correlation_all_round_is_the_mean_of_that_at_four_angles():
    ink = np.random.default_rng(0).random((300, 300)) > 0.8
    ink = ndimage.binary_dilation(ink, iterations=2)
    lags = np.arange(0, 12.1, 1.0)
    four = texture.curves(ink.astype(float), (1, 1), 3.0).mean(lags[2:] / 3)
    assert radial(ink, lags, 1.0, np.ones(ink.shape))[4:] == pytest.approx(
        four[2:], abs=0.03
    )  # steps of a pixel against whole displacements


def test_without_paper_or_without_ink_nothing_correlates():
    for ink in (np.zeros((20, 20)), np.ones((20, 20))):
        assert (radial(ink, np.arange(0, 5, 1.0), 1.0) == 0).all()


def test_discs_share_all_at_no_distance_and_nothing_a_diameter_apart():
    assert lens([0.0, 2.0, 3.0], 2.0) == pytest.approx([np.pi, 0, 0])


def test_a_style_file_gives_the_same_style_and_the_same_bytes(tmp_path):
    path = tmp_path / "a.style"
    stylefile.save(HAND, path)
    again = stylefile.load(path)
    assert stylefile.to_bytes(HAND) == path.read_bytes()
    assert again.black.area == pytest.approx(HAND.black.area, rel=1e-3)  # shapes are kept to a ten-thousandth of a millimetre
    assert again.black.tile.xy == pytest.approx(HAND.black.tile.xy, abs=1e-9)
    tone = Tone(np.full((4, 4), 0.5), (10, 10))
    assert (draw("byexample", tone, style_file=str(path)).marks.xy == draw("byexample", tone).marks.xy).all()


def test_the_styles_that_come_along_are_learned_from_the_sheets_that_come_along():
    for name in exemplar.names():
        assert exemplar.load(name).sha256 == learning.digest(exemplar.FOLDER / f"{name}.png")


@pytest.mark.parametrize(
    "change",
    [
        {"crowquill style": 99},
        {"black": None},
        {"turnover": [0.9, 0.5]},
        {"turnover": "x"},
        {"dpi": None},
        {"black": {**json.loads(stylefile.to_bytes(HAND))["black"], "places": "AAAA"}},
        {"black": {**json.loads(stylefile.to_bytes(HAND))["black"], "counts": [10**9]}},
        {"black": {**json.loads(stylefile.to_bytes(HAND))["black"], "side_mm": 1e-9}},
    ],
    ids=lambda change: "-".join(change)[:20],
)
def test_a_broken_style_file_is_named_in_one_line(tmp_path, change):
    path = tmp_path / "b.style"
    path.write_text(json.dumps(json.loads(stylefile.to_bytes(HAND)) | change))
    with pytest.raises(ValueError, match=r"b\.style: .*learn the example again") as error:
        stylefile.load(path)
    assert "\n" not in str(error.value)


def test_a_file_that_is_no_style_is_refused(tmp_path):
    path = tmp_path / "c.style"
    path.write_bytes(b"\x89PNG")
    with pytest.raises(ValueError, match="holds no learned style"):
        stylefile.load(path)


def test_a_hand_without_a_tile_is_not_saved():
    with pytest.raises(ValueError, match="no tile"):
        stylefile.to_bytes(replace(HAND, black=Hand(HAND.black.glyphs, HAND.black.levels)))


def test_marks_and_tones_are_learned_from_a_drawing_that_nobody_prepared(taught):
    assert 2 * np.sqrt(taught.black.area / np.pi) == pytest.approx(0.35, rel=0.05)
    found = np.array([level.coverage for level in taught.black.levels])
    assert len(found) >= 3 and found[0] < 0.2 and found[-1] > 0.4
    assert taught.dpi == DPI
    level = min(taught.black.levels, key=lambda level: abs(level.coverage - 0.3))
    spacing = np.sqrt(taught.black.area / level.coverage)
    assert np.interp(0.5 * spacing, level.lags, level.correlation) < -0.1  # relaxed dots keep apart


def test_what_was_learned_from_it_draws_and_is_learned_once(plate, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(exemplar, "BLACK", 3000)  # marks of a tile: a sixth of the time
    ramp = Tone(np.tile(np.linspace(0, 0.9, 60), (40, 1)), (30, 20))
    stages, drawings = [], []
    for _ in range(2):
        stages.append([])
        drawings.append(draw("byexample", ramp, example=plate, watch=lambda step: stages[-1].append(step.stage)))
    assert drawings[0].report["ink_placed_mm2"] == pytest.approx(ramp.ink, rel=0.03)  # marks of chance alone in the darks
    assert stages[0][:2] == ["learn", "black"] and stages[1] == ["plan", "place", "measure"] and stages[0][-3:] == stages[1]
    assert to_bytes(drawings[0], "svg") == to_bytes(drawings[1], "svg")
    (file,) = (tmp_path / "crowquill").iterdir()
    file.write_text("torn")
    assert kept.recalled(file) is None


def test_styles_are_kept_by_what_the_scan_holds_and_the_oldest_go(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(kept, "MOST", 2)
    files = []
    for k in range(3):
        (tmp_path / "scan.png").write_bytes(bytes([k]))
        files.append(kept.place(tmp_path / "scan.png", None))
        assert kept.kept(HAND, files[-1]).name == "hand" and files[-1].read_bytes() == stylefile.to_bytes(HAND)
        os.utime(files[-1], (k, k))
    assert kept.place(tmp_path / "scan.png", 600.0) != files[-1] != files[0]
    assert sorted((tmp_path / "crowquill").iterdir()) == sorted(files[1:])


def test_where_nothing_can_be_kept_a_style_is_learned_all_the_same(tmp_path):
    (tmp_path / "file").write_text("")
    assert kept.kept(HAND, tmp_path / "file" / "a.style").name == "hand" and kept.recalled(tmp_path / "file" / "a.style") is None
    assert kept.kept(HAND, None).name == "hand" and kept.recalled(None) is None
