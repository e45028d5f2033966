"""The adaptive style's own bars: the number of dots it finds, its ink, sizes by tone, and the published schedule."""

from __future__ import annotations

import math

import numpy as np
import pytest
from test_bluenoise import camera
from test_stipple import LIGHT, ramp, scores

import crowquill
from crowquill import Tone, measure, moments, spacing
from crowquill.cells import voronoi

PEN = 0.3  # mm


@pytest.mark.parametrize("pen", [0.2, 0.4, 1.0])
def test_the_number_of_dots_follows_from_the_pen_and_the_tone(pen: float) -> None:
    sheet = crowquill.draw("adaptive", LIGHT, pen=pen, glyphs="disc")
    assert len(sheet.marks) == pytest.approx(LIGHT.ink / (math.pi * pen**2 / 4), rel=2e-3)  # the curve of overlap is good to that
    assert sheet.report["ink_placed_mm2"] == pytest.approx(LIGHT.ink, rel=0.003)


def test_a_ramp_keeps_its_tone_in_every_band() -> None:
    tone = ramp(60.0, 40.0)
    sheet = crowquill.draw("adaptive", tone, pen=PEN)
    cover = measure.rendered(sheet.marks, tone.size, (40, 60)).mean(axis=0).reshape(10, 6).mean(axis=1)
    asked = tone.coverage.mean(axis=0).reshape(10, 30).mean(axis=1)
    assert np.abs(cover - asked).max() <= 0.02, (cover, asked)  # .012 of so narrow bands
    assert sheet.report["ink_placed_mm2"] == pytest.approx(tone.ink, rel=0.005)


def test_dots_of_one_size_stand_for_nearly_the_same_ink() -> None:
    tone = ramp(40.0, 30.0, low=0.05, high=0.5)
    spread = []
    for style in ("adaptive", "stipple"):
        mass = moments.of_tone(voronoi(crowquill.draw(style, tone, pen=PEN).marks.xy, tone.canvas), tone).mass
        spread.append(mass.std() / mass.mean())
    assert spread[0] < 0.09, spread  # the published mark of a flat tone is .10
    assert spread[0] < spread[1] + 0.02, spread  # a start by levels shares the ink out again and again


def test_sizes_by_tone_are_the_ink_of_each_dots_cell() -> None:
    tone = ramp(30.0, 20.0, low=0.05, high=0.4)
    sheet = crowquill.draw("adaptive", tone, pen=PEN, size_by="tone", glyphs="disc")
    area, mass = sheet.marks.scale**2, moments.of_tone(voronoi(sheet.marks.xy, tone.canvas), tone).mass
    assert area.sum() == pytest.approx(tone.ink, rel=5e-3)
    assert np.median(np.abs(area / mass - 1)) < 0.03  # what one dot cannot hold the next ones get
    dark = sheet.marks.xy[:, 0] > 20
    assert np.median(area[dark]) > 1.6 * np.median(area[sheet.marks.xy[:, 0] < 10])  # areas of 1 to 7 from white to black


def test_several_nibs_have_a_layer_each() -> None:
    tone = ramp(20.0, 15.0)
    sheet = crowquill.draw("adaptive", tone, sizes=(0.2, 0.5))
    assert [layer.name for layer in sheet.layers] == ["0.2 mm", "0.5 mm"] and min(len(layer.art) for layer in sheet.layers) > 50
    assert sheet.report["ink_placed_mm2"] == pytest.approx(tone.ink, rel=0.01)


def test_the_published_schedule_draws_too_many_dots_and_says_so() -> None:
    # 1565 would be right: the power of two above, 2048, leaves each cell three quarters of its ink, and most stay
    sheet = crowquill.draw("adaptive", LIGHT, pen=0.4418, schedule="published")
    right = len(crowquill.draw("adaptive", LIGHT, pen=0.4418).marks)
    assert right == pytest.approx(1565, abs=10)
    assert 1.15 * right < len(sheet.marks) < 1.4 * right and sheet.report["iterations"] <= 20
    assert any(f"gave {len(sheet.marks)} dots in place of {right}" in warning for warning in sheet.report["warnings"])


def test_a_photograph_keeps_its_tone() -> None:
    tone = camera(500)
    sheet = crowquill.draw("adaptive", tone, pen=0.574)
    error, rho = scores(tone, sheet.marks.xy / tone.pixel)
    assert len(sheet.marks) == pytest.approx(5000, abs=20) and error <= 0.024 and rho >= 0.87, (error, rho)
    assert sheet.report["ink_placed_mm2"] == pytest.approx(tone.ink, rel=0.01)


@pytest.mark.soak
def test_twenty_thousand_dots_keep_the_tone_of_a_photograph() -> None:
    tone = camera(1000)
    sheet = crowquill.draw("adaptive", tone, pen=0.5742)
    error, rho = scores(tone, sheet.marks.xy / tone.pixel)
    assert len(sheet.marks) == pytest.approx(20_000, abs=20) and error <= 0.024 and rho >= 0.875, (error, rho)


def test_the_spectrum_has_little_below_half_a_cycle_a_spacing() -> None:
    figures = spacing.of(crowquill.draw("adaptive", LIGHT, pen=PEN).marks.xy, LIGHT)
    assert figures.low_power is not None and figures.low_power < 0.02  # .008
    assert figures.power is not None and 2 < figures.power < 4.4  # 3.5 on wide sheets; over that, lattices


def test_a_picture_of_islands_has_dots_on_each() -> None:
    coverage = np.zeros((60, 80))
    for row in range(4):
        for column in range(5):
            coverage[15 * row + 4 : 15 * row + 11, 16 * column + 4 : 16 * column + 11] = 0.3 + 0.03 * (5 * row + column)
    tone = Tone(coverage, (40.0, 30.0))
    xy = crowquill.draw("adaptive", tone, pen=PEN).marks.xy
    assert (tone.at(xy) > 0).all()
    counts = np.histogram2d(xy[:, 1], xy[:, 0], bins=(4, 5), range=((0, 30), (0, 40)))[0]
    ink = coverage.reshape(4, 15, 5, 16).sum(axis=(1, 3)) * 0.25
    np.testing.assert_allclose(counts / counts.sum(), ink / ink.sum(), atol=0.006)  # half a dot of some 90 an island
