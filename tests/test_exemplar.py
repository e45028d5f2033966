"""Learning from a scan: synthesised tiles against the example's texture, style files, examples nobody prepared, and bad ones."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from crowquill import Tone, draw, exemplar, measure, relax, texture
from crowquill.exemplar import learning, stylefile
from crowquill.exemplar.correlation import lens, radial
from crowquill.exemplar.style import Hand
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
    """A drawing that nobody prepared: a stippled wedge with a vignette, scanned with noise and uneven light on yellow paper."""
    y, x = np.indices((60, 80)) / 60
    wedge = np.clip(0.05 + 0.5 * np.round(4 * x / 1.34) / 4 - 0.1 * (np.hypot(x - 0.3, y - 0.8) < 0.15), 0, 1)
    marks = draw("stipple", Tone(wedge, (48, 36)), pen=0.35).marks
    code = codes(page(marks.moved((2, 2)), size=(52, 40)))
    shade = 1 - 0.1 * np.linspace(0, 1, code.shape[1])
    noisy = code * shade + np.random.default_rng(0).normal(0, 0.01, code.shape)
    path = tmp_path_factory.mktemp("scan") / "plate.png"
    rgb = np.clip(noisy[:, :, None] * (1, 0.97, 0.82), 0, 1)
    Image.fromarray((255 * rgb).astype(np.uint8)).save(path, dpi=(DPI, DPI))
    return str(path)


@pytest.fixture(scope="module")
def taught(plate: str) -> exemplar.Style:
    return learning.learn(plate)


@pytest.mark.parametrize("k", range(len(HAND.black.levels)))
def test_a_tile_has_the_texture_of_the_example_and_relaxed_dots_have_not(k):
    level, tile = HAND.black.levels[k], HAND.black.tile
    sites = tile.of(level.coverage)
    spacing = tile.side / np.sqrt(len(sites))
    ink = _Marks(sites, tile.side, HAND.black).drawn(len(sites))
    near = (level.lags >= 0.5 * spacing) & (level.lags <= 3 * spacing)
    assert np.sqrt(np.mean((radial(ink, level.lags, tile.side / len(ink)) - level.correlation)[near] ** 2)) < 0.03
    side = 20.0
    tone = Tone(np.full((4, 4), 0.5), (side, side))
    first = relax.scatter(tone, round((side / spacing) ** 2), np.random.default_rng(0))
    relaxed = next(state.sites for state in relax.lloyd(first, tone, step=1) if state.done == 50)
    dots = dotted(relaxed, HAND.black.glyphs, 2 * np.sqrt(HAND.black.area / np.pi), np.random.default_rng(1))
    other = measure.rendered(dots, (side, side), (400, 400)) >= 0.5
    curve = radial(other, level.lags, side / 400, np.ones(other.shape))
    # correlation is in proportion to coverage where dots are few: of light tones even the most regular is small
    assert np.sqrt(np.mean((curve - level.correlation)[near] ** 2)) > (0.08 if level.coverage > 0.15 else 0.25 * level.coverage)


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
    tone = Tone(np.full((4, 4), 0.7), (10, 10))
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


def test_what_was_learned_from_it_draws(taught, tmp_path):
    work = exemplar.learning_steps(taught)
    while True:
        try:
            next(work)
        except StopIteration as stop:
            stylefile.save(stop.value, tmp_path / "plate.style")
            break
    ramp = Tone(np.tile(np.linspace(0, 0.9, 60), (40, 1)), (30, 20))
    report = draw("byexample", ramp, style_file=str(tmp_path / "plate.style")).report
    assert report["ink_placed_mm2"] == pytest.approx(ramp.ink, rel=0.05)  # darks of black marks alone, and few of them


def dots(coverage: float, corner: float, seed: int = 0) -> Marks:
    marks = draw("stipple", Tone(np.full((4, 4), coverage), (14, 14)), pen=0.35, seed=seed).marks
    return marks.moved((corner, 2))


def test_one_tone_is_no_example():
    with pytest.raises(ValueError, match="one tone at most; give an example with patches"):
        learning.learn(codes(page(dots(0.2, 2), size=(18, 18))), DPI)


def test_a_page_without_dots_is_refused():
    with pytest.raises(ValueError, match="no dots; scan dark ink"):
        learning.learn(np.full((300, 300), 0.9), DPI)


def test_one_giant_dot_is_no_example():
    y, x = np.indices((600, 600)) - 300
    with pytest.raises(ValueError, match=r"1 giant.*give an example in whose lights dots stand apart"):
        learning.learn(codes((np.hypot(x, y) < 200).astype(float)), DPI)


@pytest.mark.parametrize(("tag", "said"), [((72, 72), "72 dpi"), (None, "not known"), ((150, 150), "too coarse")], ids=str)
def test_a_scan_of_unknown_size_asks_for_its_dpi(tmp_path, tag, said):
    path = tmp_path / "scan.png"
    image = Image.fromarray((255 * codes(page(dots(0.2, 2), size=(18, 18)))).astype(np.uint8))
    image.save(path, **({"dpi": tag} if tag else {}))
    with pytest.raises(ValueError, match=said) as error:
        learning.learn(str(path))
    assert "--example-dpi" in str(error.value) and " --dpi" not in str(error.value)
