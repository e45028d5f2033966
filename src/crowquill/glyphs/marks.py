"""Thin parallel marks of a page, such as a ruler's ticks, though a line may join them.

Each pixel of ink has a direction in which the darkness changes, and marks are the pixels of one direction that touch:
a line that crosses them is of another.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from crowquill.glyphs.page import Grey
from crowquill.paths import Array

Mask = npt.NDArray[np.bool_]
Whole = npt.NDArray[np.integer[Any]]

AROUND = 31  # pixels, of the square whose mean a mark is darker than: a body's shading reaches no tick's contrast
DARKER = 0.2  # of the paper's light: a tick two pixels wide takes half of it or more
LEAN = 20.0  # degrees by which a pixel of a tick may be turned from the ticks' common direction
LEAST = 60  # pixels of thin ink under which it is not worth a look


@dataclass(frozen=True, eq=False)
class Marks:
    """Thin parallel marks (n,) by rising u: places u along the row they may be in, and v along themselves; pixels.

    The frame is the page's turned by `turn` radians; lean is du by dv along a mark.
    """

    turn: float
    u: Array
    v: Array
    length: Array
    width: Array
    lean: Array


def found(darkness: Grey) -> Iterator[Marks]:
    """The marks across each of the commonest directions of a page's thin ink, four or fewer; none where there is too little."""
    ink = thin(darkness - ndimage.uniform_filter(darkness, AROUND) > DARKER)
    if ink.sum() < LEAST:
        return
    angle, clear = _normals(darkness)
    for turn in _peaks(angle[ink], clear[ink]):
        off = np.abs((angle - turn + np.pi / 2) % np.pi - np.pi / 2)
        yield _marks(darkness, ink & (off < np.radians(LEAN)), turn)


def thin(ink: Mask) -> Mask:
    """The ink of components that are not compact: neither dots nor most digits."""
    labels, count = ndimage.label(ink, np.ones((3, 3), int))
    if not count:
        return ink
    y, x = np.nonzero(labels)
    area, _, _, xx, xy, yy = _second_moments(labels[y, x], count, x, y, np.ones(len(x)))
    middle, half = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    box = np.array([(b[0].stop - b[0].start) * (b[1].stop - b[1].start) for b in ndimage.find_objects(labels)])
    compact = (np.sqrt(np.maximum(middle - half, 0) / (middle + half)) > 0.45) & (area > 0.45 * box)
    return np.asarray(np.concatenate([[False], ~compact & (area >= 5)])[labels])


def _second_moments(label: Whole, count: int, x: Whole | Array, y: Whole | Array, weight: Array) -> tuple[Array, ...]:
    """Weight, mean x and y, and covariance xx, xy, yy of the pixels (squares) of each label from 1."""
    total = np.maximum(np.bincount(label, weight, count + 1)[1:], 1e-9)
    mx, my = (np.bincount(label, weight * side, count + 1)[1:] / total for side in (x, y))
    dx, dy = x - mx[label - 1], y - my[label - 1]
    xx, xy, yy = (np.bincount(label, weight * term, count + 1)[1:] / total for term in (dx * dx, dx * dy, dy * dy))
    return total, mx, my, xx + 1 / 12, xy, yy + 1 / 12


def _normals(darkness: Grey) -> tuple[Array, Array]:
    """At each pixel the direction in which the darkness changes, 0 to pi, and how clear that is, 0 to 1."""
    gx, gy = (ndimage.gaussian_filter(darkness, 0.7, order=order) for order in ((0, 1), (1, 0)))
    xx, yy, xy = (ndimage.gaussian_filter(term, 1.0) for term in (gx * gx, gy * gy, gx * gy))
    strength = np.hypot(xx - yy, 2 * xy) / np.maximum(xx + yy, 1e-9)
    return np.arctan2(2 * xy, xx - yy) / 2 % np.pi, strength


def _peaks(angle: Array, clear: Array) -> list[float]:
    """The commonest directions, four or fewer, ten degrees and more apart."""
    counts = ndimage.gaussian_filter1d(np.histogram(angle, 180, (0, np.pi), weights=clear)[0], 2.0, mode="wrap")
    peaks: list[float] = []
    for bin in np.argsort(-counts, kind="stable").tolist():
        turn = (bin + 0.5) * np.pi / 180
        if all(np.cos(2 * (turn - other)) < np.cos(np.radians(20)) for other in peaks):
            peaks.append(turn)
        if len(peaks) == 4:
            break
    return peaks


def _marks(darkness: Grey, mask: Mask, turn: float) -> Marks:
    """The thin marks of a mask that stand across a direction."""
    labels, count = ndimage.label(mask, np.ones((3, 3), int))
    y, x = np.nonzero(labels)
    u = (x + 0.5) * np.cos(turn) + (y + 0.5) * np.sin(turn)
    v = (y + 0.5) * np.cos(turn) - (x + 0.5) * np.sin(turn)
    area, u, v, uu, uv, vv = _second_moments(labels[y, x], count, u, v, np.maximum(darkness[y, x], 0.05).astype(np.float64))
    length, width = np.sqrt(12 * vv), np.sqrt(12 * np.maximum(uu - uv * uv / vv, 1 / 12))
    kept = (length > 1.8 * width) & (length > 4) & (np.abs(uv / vv) < 0.3) & (area > 3)
    order = np.flatnonzero(kept)[np.argsort(u[kept], kind="stable")]
    return Marks(turn, u[order], v[order], length[order], width[order], (uv / vv)[order])
