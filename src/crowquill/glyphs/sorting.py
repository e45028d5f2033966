"""What on a page is a single dot and what is not: dust, blots, dots that touch or are cut, a ruler."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import ndimage

from crowquill.glyphs.outline import edge_level, iso_contours, shape
from crowquill.glyphs.page import Grey
from crowquill.glyphs.ruler import Ruler
from crowquill.paths import Array

Label = npt.NDArray[np.int32]
Areas = npt.NDArray[np.integer[Any]]
Window = tuple[slice, slice]  # rows, columns

GIANT = 3.0  # mm: no pen leaves a dot so wide
DUST = 0.3  # of the median area, and 5 pixels; diameters of one pen's dots spread by 11 % at most, three times that leaves 0.45
LARGE = (1.6, 2.6)  # of the median area, at least and at most, up to which a dot of good shape is one
SPREAD = 3.0  # standard deviations of the logarithm of the area, from the median to the largest single dot
FEW = 20  # dots smaller than the median, from which on they tell how areas spread
MARGIN = 0.1  # mm of paper around a patch, at least 4 pixels


@dataclass(frozen=True, eq=False)
class Dot:
    """A single dot: its darkness from its own paper, the patch's corner in pixels, its outline's level and contour there."""

    patch: Grey
    corner: Array
    level: float
    contour: Array


def sorted_out(darkness: Grey, threshold: float, mm: float, ruler: Ruler | None = None) -> tuple[list[Dot], list[tuple[str, Window]]]:
    """The dots of a page in the order of their first pixels, and why each other component is none, with its rows and columns.

    A component is of pixels darker than the threshold that touch, if only at corners; mm is a pixel's.
    """
    found, _ = ndimage.label(darkness > threshold, np.ones((3, 3), int))
    labels: Label = np.asarray(found, np.int32)
    areas = np.bincount(labels.ravel())[1:]
    boxes: list[Window] = [(box[0], box[1]) for box in ndimage.find_objects(labels)]
    reasons = [_too_large(box, area, labels.shape, mm) for box, area in zip(boxes, areas, strict=True)]
    if ruler:
        for k in _on(ruler, labels, boxes):
            reasons[k] = "ruler"
    usual = _usual(areas[[not reason for reason in reasons]])
    largest = _largest(areas[[not reason for reason in reasons]], usual)
    dots = []
    for k, box in enumerate(boxes):
        reasons[k] = reasons[k] or ("dust" if areas[k] < max(DUST * usual, 5) else "")
        if reasons[k]:
            continue
        dot = _dot(darkness, labels, k + 1, box, max(4, round(MARGIN / mm)))
        if _merged(dot.contour, areas[k], usual, largest):
            reasons[k] = "merged"
        else:
            dots.append(dot)
    return dots, [(why, box) for why, box in zip(reasons, boxes, strict=True) if why]


def _too_large(box: Window, area: int, page: tuple[int, ...], mm: float) -> str:
    """Why a component of so many pixels of so many mm is no whole dot, or nothing."""
    if any(side.start < 2 or side.stop > length - 2 for side, length in zip(box, page, strict=True)):
        return "cut by the border"
    return "giant" if area * mm * mm > np.pi / 4 * GIANT**2 else ""


def _on(ruler: Ruler, labels: Label, boxes: list[Window]) -> list[int]:
    """The components that lie on a ruler, if only with one pixel: whole boxes first, pixels where a box does not tell."""
    if not boxes:
        return []
    ends = np.array([(x.start, y.start, x.stop, y.stop) for y, x in boxes], np.float64)
    middle, reach = (ends[:, :2] + ends[:, 2:]) / 2, np.hypot(*(ends[:, 2:] - ends[:, :2]).T) / 2
    inside = ruler.covers(middle)
    for k in np.flatnonzero(~inside & ruler.covers(middle, reach)):
        y, x = np.nonzero(labels[boxes[k]] == k + 1)
        inside[k] = ruler.covers(np.stack([x, y], axis=1) + 0.5 + ends[k, :2]).any()
    return np.flatnonzero(inside).tolist()


def _usual(areas: Areas) -> float:
    """The median area of single dots.

    First each is counted by its diameter, which neither much dust nor a few blots move; then those near it are counted alike.
    """
    if not len(areas):
        return 0.0
    areas = np.sort(areas)
    weight = np.cumsum(np.sqrt(areas))
    usual = float(areas[np.searchsorted(weight, weight[-1] / 2)])
    for _ in range(3):
        usual = float(np.median(areas[(areas >= usual / 2) & (areas <= usual * 1.5)]))
    return usual


def _largest(areas: Areas, usual: float) -> float:
    """The area of the largest single dots, by how those below the median spread: dots that touch are all above it."""
    small = areas[(areas >= DUST * usual) & (areas <= usual)]
    spread = np.log(usual / np.quantile(small, 0.32)) if len(small) >= FEW else 0.0  # of half the dots: a standard deviation below
    return usual * float(np.clip(np.exp(SPREAD * spread), *LARGE))


def _dot(darkness: Grey, labels: Label, label: int, box: Window, margin: int) -> Dot:
    """One component as a Dot; what is nearer to another is blanked."""
    top, left = (max(0, side.start - margin) for side in box)
    window = slice(top, box[0].stop + margin), slice(left, box[1].stop + margin)
    near = labels[window]
    away, (row, column) = ndimage.distance_transform_edt(near == 0, return_indices=True)
    own = near[row, column] == label
    bare = darkness[window][own & (away >= 3)]
    paper = np.median(bare) if bare.size else 0.0
    patch = np.where(own, (darkness[window] - paper) / (1 - paper), 0).astype(np.float32)
    depth = ndimage.distance_transform_edt(near == label)
    ink = float(np.median(patch[depth > 0.75 * depth.max()]))
    patch = np.clip(patch, 0, 1)
    contour_at = iso_contours(patch)
    level = edge_level(patch, ink, contour_at(ink / 2))
    return Dot(patch, np.array([left, top], np.float64), level, contour_at(level))


def _merged(contour: Array, pixels: int, usual: float, largest: float) -> bool:
    """Whether a contour is of more than one dot.

    Touching discs have 2 areas, solidity 0.9, axis ratio 0.5. A contour much smaller than its component is of one of two.
    """
    if len(contour) < 8:
        return True
    area, solidity, ratio = shape(contour)
    parted = abs(area - pixels) > 0.25 * pixels + 4  # 4: a dot of few pixels gains or loses its corners
    odd = area > 1.3 * usual and (solidity < 0.95 or ratio < 0.72)
    return parted or area > largest or solidity < 0.86 or ratio < 0.6 or odd
