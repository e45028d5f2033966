"""Stippling that heeds structure keeps thin lines that relaxed dots lose, at the same number of dots."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from crowquill import Tone, draw, likeness, measure

SIDE, DOTS, GRID = 100.0, 5000, 1000  # mm, and pixels of what is looked at
PIXEL = SIDE / GRID
SPACING = SIDE / DOTS**0.5


def lined() -> Tone:
    """Grey that rises from left to right, with waves and rings half a millimetre wide, dark and white: a third of the room of a dot."""
    y, x = np.mgrid[0:600, 0:600] / 600
    grey = 0.12 + 0.35 * x
    for k in range(7):
        near = np.abs(y - 0.12 - 0.12 * k - 0.05 * np.sin(9 * x + k)) * 600 < 1.6
        grey = np.where(near, 0.0 if k % 2 else 0.85, grey)
    for radius in (0.2, 0.3):
        grey = np.where(np.abs(np.hypot(x - 0.5, y - 0.5) - radius) * 600 < 1.6, 0.9, grey)
    return Tone(grey, (SIDE, SIDE))


@cache
def kept(style: str, **knobs: Any) -> float:
    """How much of the picture's edges a drawing keeps, seen through a blur as wide as dots are apart."""
    tone = lined()
    marks = draw(style, tone, dots=DOTS, **knobs).marks
    assert len(marks) == pytest.approx(DOTS, rel=0.02)
    dark, wanted = measure.rendered(marks, tone.size, (GRID, GRID)), likeness.asked(tone, (GRID, GRID))
    return likeness.edges_kept(dark, wanted, (PIXEL, PIXEL), SPACING)


@pytest.mark.parametrize(
    ("style", "knobs"), [("contrast", {}), ("contrast", {"g_plus": 2.0}), ("frontier", {})], ids=["contrast", "G 2", "frontier"]
)
def test_thin_lines_keep_more_of_their_edges_than_in_relaxed_dots(style: str, knobs: dict[str, Any]) -> None:
    assert kept(style, **knobs) > 1.15 * kept("stipple", iterations=15)


def test_without_weight_on_edges_dots_keep_little_more_than_relaxed_ones() -> None:
    assert kept("frontier", edges=0.0) < 1.1 * kept("stipple", iterations=15)  # so it is not for its numbers that the check passes
