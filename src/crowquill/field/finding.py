"""Edges and isophotes of a picture, as lines between its pixels, in millimetres.

Source: J. Canny, A Computational Approach to Edge Detection, IEEE PAMI 8(6), 1986; T. Lindeberg, Edge Detection and Ridge
Detection with Automatic Scale Selection, IJCV 30(2), 1998, for edges between pixels.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from crowquill.field.grids import between, coarser, derived
from crowquill.paths import Array, Paths
from crowquill.tone import Tone

BLURRED = 10  # pixels to a blur's sigma at most: of finer ones the mean is taken first, and lines move by less than a micrometre
FINE = 0.05  # of a pixel: how far an edge is simplified, as canvases are
STRONGEST, FAINTEST = 0.6, 0.02  # the step that a line needs without detail, and how much of that with all of it


def contrast(detail: float) -> tuple[float, float]:
    """How great a step of coverage must be all along a line, and somewhere on it, for a detail of 0, the strongest alone, to 1, all.

    >>> contrast(1.0)
    (0.004, 0.012)
    """
    high = STRONGEST * FAINTEST**detail
    return high / 3, high


def edges(tone: Tone, sigma: float, *, low: float = 0.05, high: float = 0.15, least: float = 0.0) -> Paths:
    """Edges of a tone seen through a blur of sigma mm, as open lines between the pixels, those that close ending where they begin.

    low, high  an edge is where the tone changes as a step of coverage `low` would, if somewhere it does as one of `high`
    least      mm; shorter ones are left out

    On an edge the gradient is greatest along its own direction: its second derivative there is 0 and its third
    negative. Blur draws an edge of radius r in by about sigma^2 / 2r.
    """
    from contourpy import contour_generator

    tone = _seen(tone, sigma)
    one = {(i, j): derived(tone, sigma, i, j) for i in range(4) for j in range(4 - i) if i + j}
    x, y = one[1, 0], one[0, 1]
    step = np.hypot(x, y) * sigma * np.sqrt(2 * np.pi)  # the step that would have such a gradient at its middle
    second = x * x * one[2, 0] + 2 * x * y * one[1, 1] + y * y * one[0, 2]
    third = x**3 * one[3, 0] + 3 * x * x * y * one[2, 1] + 3 * x * y * y * one[1, 2] + y**3 * one[0, 3]
    if min(step.shape) < 2:
        return Paths.of([], closed=False)
    lines: Any = contour_generator(*_centres(tone), z=np.ma.array(second, mask=(step < low) | (third >= 0))).lines(0.0)
    return _kept([line for line in lines if len(line) > 1 and between(step, tone.size, line).max() >= high], tone, least)


def isophotes(tone: Tone, levels: int, sigma: float, *, least: float = 0.0) -> list[Paths]:
    """The borders between so many even levels of a tone seen through a blur of sigma mm: levels - 1 of them, the lightest first.

    least  mm; shorter lines are left out

    Each is lines that run straight between the pixels' centres; those that close end where they begin. A tone that does not reach
    a level has no line there, nor has one of one row or column.
    """
    from contourpy import contour_generator

    tone = _seen(tone, sigma)
    if min(tone.coverage.shape) < 2:
        return [Paths.of([], closed=False)] * (levels - 1)
    contours: Any = contour_generator(*_centres(tone), z=derived(tone, sigma, 0, 0))
    return [_kept(contours.lines(k / levels), tone, least) for k in range(1, levels)]


def _seen(tone: Tone, sigma: float) -> Tone:
    """The coverage of a tone with no more pixels than a blur of sigma mm leaves to be seen."""
    grid = tuple(
        max(1, count // max(1, int(sigma / (BLURRED * side)))) for count, side in zip(tone.coverage.shape, tone.pixel[::-1], strict=True)
    )
    return Tone(coarser((grid[0], grid[1]), tone.coverage)[0], tone.size) if grid != tone.coverage.shape else tone


def _centres(tone: Tone) -> tuple[Array, Array]:
    """x of the columns' and y of the rows' middles, mm."""
    (h, w), (dx, dy) = tone.coverage.shape, tone.pixel
    return np.asarray((np.arange(w) + 0.5) * dx, np.float64), np.asarray((np.arange(h) + 0.5) * dy, np.float64)


def _kept(lines: list[Array], tone: Tone, least: float) -> Paths:
    """Lines with no more points than they need, those of some length and as long as is asked."""
    whole = shapely.simplify([shapely.LineString(line) for line in lines if len(line) > 1], FINE * min(tone.pixel))
    return Paths.of([shapely.get_coordinates(line) for line in whole if line.length > 0 and line.length >= least], closed=False)
