"""Dots of the shipped nibs and brush are like scanned ones; the tool that made them makes them again."""

from __future__ import annotations

import importlib
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from scipy import ndimage
from skimage.measure import regionprops
from test_glyphs import NIBS, moments

from crowquill import glyphs
from crowquill.marks import Glyph
from crowquill.paths import Paths
from crowquill.picture import linear


def masks(code: np.ndarray) -> list[Any]:
    """The dots of a sheet as pixels darker than half of the ink, touching if only at corners; its paper's light is a bilinear field."""
    light = linear(code)
    down, along = np.indices(light.shape) / np.reshape(light.shape, (2, 1, 1))
    terms = np.stack([np.ones_like(light), down, along, down * along], axis=-1)
    bare = light > 0.8 * np.quantile(light, 0.9)  # ink leaves 0.4 of the light, and the lamp is a sixth dimmer in a corner
    darkness = 1 - light / (terms @ np.linalg.lstsq(terms[bare], light[bare], rcond=None)[0])
    half = np.quantile(darkness[darkness > 0.3], 0.75) / 2  # the upper half of what is dark: the rest is edge
    return regionprops(ndimage.label(darkness > half, np.ones((3, 3)))[0])


def ragged(code: np.ndarray) -> None:
    """Raises AssertionError where masks of a sheet leave the ranges measured on scanned dots, as in the metadata."""
    dots = masks(code)
    assert len(dots) == 40, f"{len(dots)} dots"
    solid = np.mean([dot.solidity for dot in dots])
    assert 0.89 <= solid <= 0.93, f"mean solidity is {solid:.3f}"
    ratio = np.mean([dot.axis_minor_length / dot.axis_major_length for dot in dots])
    assert 0.76 <= ratio <= 0.87, f"mean axis ratio is {ratio:.3f}"


def like_ink(library: glyphs.Library) -> None:
    """Raises AssertionError where outlines of a nib leave what was measured on scanned dots, or are no blots with a plain edge."""
    pen, dots = library.about["pen_mm"], library.glyphs
    sizes = np.array([glyph.size for glyph in dots])
    assert abs(sizes.mean() / pen - 1) < 0.01, f"mean diameter {sizes.mean():.4f} is not of a {pen} mm pen"
    assert 0.05 <= sizes.std() / sizes.mean() <= 0.11, f"diameters spread by {sizes.std() / sizes.mean():.3f}"
    ratios = np.array([np.sqrt(np.divide(*np.linalg.eigvalsh(moments(glyph)[2]))) for glyph in dots])
    assert 0.76 <= ratios.mean() <= 0.87, f"mean axis ratio is {ratios.mean():.3f}"
    assert (ratios > 0.6).all(), f"a dot has axis ratio {ratios.min():.3f}"
    solid = np.array([ring.area / ring.convex_hull.area for glyph in dots for ring in glyph.paths.flat(1e-4).polygons()])
    assert solid.min() > 0.96, f"a dot has a waist or a spur: its solidity is {solid.min():.3f}"
    assert (solid > 0.975).mean() >= 0.9, "dots are dented"
    assert (solid < 0.998).mean() >= 0.2, "dots are smooth ovals"  # an oval has 1; a fifth or more are drawn back, or have tails
    cubics = np.array([len(glyph.paths.xy) / 3 for glyph in dots])
    assert cubics.min() >= 5 and cubics.max() <= 8 and cubics.mean() <= 6.5, f"{cubics.mean():.2f} cubics a dot: what a small file allows"
    assert len({glyph.paths.xy.tobytes() for glyph in dots}) == len(dots), "two dots are one"


@pytest.mark.parametrize("name", NIBS)
def test_dots_of_a_nib_are_like_scanned_ones(name: str) -> None:
    like_ink(glyphs.load(name))
    assert len(glyphs.load(name).glyphs) == 40


def oval(ratio: float, size: float) -> Glyph:
    """A smooth dot of this axis ratio."""
    turn = np.arange(60) * np.pi / 30
    return Glyph(Glyph.of(Paths.of([np.stack([np.cos(turn), ratio * np.sin(turn)], axis=1)])).paths, size)


def bone(size: float) -> Glyph:
    """A dot with a waist on both sides."""
    turn = np.arange(60) * np.pi / 30
    ring = (1 + 0.5 * np.cos(2 * turn)) * np.exp(1j * turn)
    return replace(Glyph.of(Paths.of([np.stack([ring.real, 1.8 * ring.imag], axis=1)])), size=size)


NOT_INK = {
    "are all of one size": (lambda nib: [replace(dot, size=0.3) for dot in nib], "spread by 0.000"),
    "are of another pen": (lambda nib: [replace(dot, size=dot.size * 1.02) for dot in nib], "not of a 0.3 mm pen"),
    "are discs": (lambda nib: [oval(0.999, dot.size) for dot in nib], "mean axis ratio is 0.999"),
    "are smooth ovals": (lambda nib: [oval(0.82 + k / 1000, dot.size) for k, dot in enumerate(nib)], "dots are smooth ovals"),
    "have a bone among them": (lambda nib: [bone(nib[0].size), *nib[1:]], "a waist or a spur"),
    "have a splinter among them": (lambda nib: [oval(0.5, nib[0].size), *nib[1:]], "a dot has axis ratio 0.500"),
    "take many cubics": (lambda nib: [Glyph(dot.paths.flat(0.01).curved(), dot.size) for dot in nib], "cubics a dot"),
    "have one among them twice": (lambda nib: [Glyph(nib[1].paths, nib[0].size), *nib[1:]], "two dots are one"),
}


@pytest.mark.parametrize("story", NOT_INK)
def test_the_check_of_ink_fails_on_dots_that(story: str) -> None:
    change, says = NOT_INK[story]
    nib = glyphs.load("nib-03")
    with pytest.raises(AssertionError, match=says):
        like_ink(replace(nib, glyphs=tuple(change(nib.glyphs))))


SMALL = {"nib-02", "nib-03", "disc"}  # these are made again at every commit, the others by make soak


def ink_model(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    monkeypatch.syspath_prepend(Path(__file__).parent.parent / "tools")
    return importlib.import_module("ink_model")


@pytest.mark.parametrize("name", [pytest.param(name, marks=[] if name in SMALL else pytest.mark.soak) for name in NIBS])
def test_the_sheet_of_a_nib_is_as_ragged_as_scanned_ones(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    ragged(ink_model(monkeypatch).rendered(name)[0])


def test_the_check_of_a_sheet_fails_on_ovals_with_plain_rims_and_on_discs(monkeypatch: pytest.MonkeyPatch) -> None:
    model = ink_model(monkeypatch)
    monkeypatch.setattr(model, "TEETH", 0)
    turn = 0.15 * np.exp(np.arange(720) * np.pi / 360j)
    for ratio, says in ((0.82, r"mean solidity is 0\.9[345]"), (1, "mean solidity is|mean axis ratio is")):
        dot = np.stack([turn.real / ratio, turn.imag], axis=1)
        with pytest.raises(AssertionError, match=says):
            ragged(model.sheet([dot] * 40, model.PENS["nib-03"], np.random.default_rng(1)))


def test_dots_of_the_brush_differ_more_than_those_of_a_nib() -> None:
    brush = glyphs.load("brush").glyphs
    sizes = np.array([glyph.size for glyph in brush])
    assert len(brush) >= 40
    assert sizes.std() / sizes.mean() > 0.2  # nibs: 0.11 at most
    assert all(5 <= len(glyph.paths.xy) // 3 <= 8 for glyph in brush)
    assert all(0.6 < np.sqrt(np.divide(*np.linalg.eigvalsh(moments(glyph)[2]))) < 1 for glyph in brush)


@pytest.mark.parametrize("name", [pytest.param(name, marks=[] if name in SMALL else pytest.mark.soak) for name in glyphs.names()])
def test_a_library_made_again_is_the_one_that_is_shipped(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert ink_model(monkeypatch).made(name) == (glyphs.FOLDER / f"{name}.svg").read_bytes()
