"""Plots put values where their axes say, number them roundly, and colour maps by sign."""

from __future__ import annotations

import numpy as np
import pytest

from crowquill.paths import Paths
from crowquill.plots import BLUE, Panel, rounds

PANEL = Panel((20, 30, 80, 40), (0, 2), (-1, 1))


def paths(layer: object) -> Paths:
    art = getattr(layer, "art", None)
    assert isinstance(art, Paths)
    return art


@pytest.mark.parametrize(
    ("low", "high", "gives"),
    [(0, 1, [0, 0.2, 0.4, 0.6, 0.8, 1]), (-0.5, 1, [-0.4, -0.2, 0, 0.2, 0.4, 0.6, 0.8, 1]), (0, 4.4, [0, 1, 2, 3, 4]), (0.28, 0.33, None)],
)
def test_numbers_of_an_axis_are_round_and_four_to_nine(low: float, high: float, gives: list[float] | None):
    found = rounds(low, high)
    assert 4 <= len(found) <= 9 and low - 1e-9 <= found[0] and found[-1] <= high + 1e-9
    assert gives is None or found == pytest.approx(gives)


@pytest.mark.parametrize("power", range(-6, 7))
def test_any_scale_has_four_to_nine_numbers(power: int):
    for high in (1, 1.3, 1.9, 2.4, 3.3, 4.7, 5.9, 7.1, 9.9):
        assert 4 <= len(rounds(0, high * 10.0**power)) <= 9


def test_a_value_lies_where_the_axes_say_and_on_the_border_when_outside():
    assert PANEL.place([0, 1, 2, 3], [-1, 0, 1, 5]).tolist() == [[20, 70], [60, 50], [100, 30], [100, 30]]


def test_a_curve_leaves_out_what_is_not_finite_and_one_point_draws_nothing():
    assert paths(PANEL.curve([0, 1, 2], [0, np.nan, 1])[0]).xy.tolist() == [[20, 50], [100, 30]]
    assert len(paths(PANEL.curve([0, 1], [np.nan, 1])[0])) == 0


def test_bars_stand_on_the_bottom_and_are_as_high_as_their_values():
    bars = paths(PANEL.bars([0, 1, 2], [0, 1]))
    assert bars.areas.tolist() == [40 * 20, 40 * 40]


def test_a_map_is_red_above_and_blue_below_and_white_at_nothing():
    values = np.array([[1.0, -1.0], [0.0, 0.5]])
    layers = PANEL.heat(values, 1.0)
    assert sum(len(paths(layer)) for layer in layers) == 3
    shades = {tuple(paths(layer)[0][0].tolist()): layer.ink for layer in layers}
    assert shades[(60, 30)].cmyk == BLUE.cmyk and shades[(20, 30)].name == "red"
    assert 0 < shades[(60, 50)].cmyk[1] < shades[(20, 30)].cmyk[1]


def test_axes_have_a_tick_for_each_number_outside_the_frame():
    frame, ticks, words = PANEL.axes("title", "x", "y")
    assert paths(frame).areas.tolist() == [80 * 40]
    assert len(paths(ticks)) == len(rounds(0, 2)) + len(rounds(-1, 1)) and len(paths(words)) > 20
