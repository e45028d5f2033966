"""How a picture's light becomes ink: coverage by a rule between two points, importance, colours on white paper."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import cast

import numpy as np
import numpy.typing as npt

from crowquill.levels import Levels
from crowquill.paths import Array
from crowquill.picture import Bytes, File, colours, encoded, lightness, linear, read

TONES = ("auto", "linear", "grey")
REACH = 0.95  # the darkest coverage tone="auto" asks for: what dots still reach without closing up
Source = File | npt.ArrayLike


def coverage(code: Levels, tone: str, black: float | None, white: float | None) -> Levels:
    """Coverage of code values by the named rule between the two points, or the rule's own."""
    if not 0 <= (0.0 if black is None else black) < (1.0 if white is None else white) <= 1:
        raise ValueError(f"black point {black} and white point {white} are no range; give two that rise within 0 to 1")
    rules: dict[str, Callable[[Array], Array]]
    rules = {"grey": lambda v: v, "linear": linear, "auto": lambda v: lightness(linear(v)) / 100}
    rule = rules[tone]
    value = code.mapped(rule)
    low, high = 0.0, 1.0
    if tone == "auto":  # the extremes of a photograph are noise; a picture of one tone keeps its tone
        low, high = value.percentiles((0.5, 99.5)).tolist()
        low, high = (low, high) if high - low > 0.02 else (0.0, 1.0)
    low = low if black is None else float(rule(np.array(black)))
    high = high if white is None else float(rule(np.array(white)))
    if not low < high:
        raise ValueError(f"black point {black} and white point {white} leave no tones between; move one")
    return value.mapped(lambda v: np.clip((high - v) / (high - low), 0, 1) * (REACH if tone == "auto" else 1.0))


def toned(codes: Bytes, tone: str, black: float | None, white: float | None, change: Callable[[Levels], Levels]) -> Bytes:
    """sRGB code values (h, w, 3) of the light that is asked for of each channel, by the named rule between two points, and a change.

    "auto" is "linear": colours are asked for as they are, and have no points of their own. `change` takes and gives coverage.
    """
    rule = "linear" if tone == "auto" else tone
    every = (Levels(channel, np.arange(256) / 255) for channel in np.moveaxis(codes, 2, 0))
    asked = [change(coverage(channel, rule, black, white)).whole() for channel in every]
    return np.round(255 * encoded(1 - np.stack(asked, axis=2))).astype(np.uint8)


def is_file(source: object) -> bool:
    """Whether a source is a path or an open file, not an array."""
    return isinstance(source, (str, os.PathLike)) or hasattr(source, "read")


def wished(source: Source, shape: tuple[int, ...], part: tuple[slice, slice], max_pixels: int) -> tuple[Array, tuple[str, ...]]:
    """Importance on the part of a picture of this shape that is kept: means of a finer map, straight lines between a coarser one's."""
    from PIL import Image

    values, notes = read(cast(File, source), max_pixels, under=0.5) if is_file(source) else (np.asarray(source, np.float64), ())
    if values.ndim != 2 or values.size == 0 or not 0 <= values.min() <= values.max() <= 1:
        raise ValueError(f"an array of shape {values.shape} is no importance; give (rows, columns) of 0 to 1, at least one of each")
    if values.shape == shape:
        return values[part], notes
    (down, across), (rows, columns) = np.divide(values.shape, shape), part
    box = (columns.start * across, rows.start * down, min(columns.stop * across, values.shape[1]), min(rows.stop * down, len(values)))
    size = (columns.stop - columns.start, rows.stop - rows.start)
    resized = Image.fromarray(values.astype(np.float32)).resize(size, Image.Resampling.BILINEAR, box)
    return np.clip(np.asarray(resized, np.float64), 0, 1), notes


def sharpened(levels: Levels, amount: float) -> Levels:
    """Coverage with so much of the difference to its surroundings added, 0 to 1."""
    from scipy.ndimage import gaussian_filter

    coverage = levels.whole()
    around = gaussian_filter(coverage, 0.02 * coverage.shape[1], mode="nearest")

    def more(top: int, bottom: int) -> Array:
        own, near = coverage[top:bottom], around[top:bottom]
        # white paper stays white: the difference is weighed by the ink that is there
        return np.clip(own + 2 * amount * (own - near) * np.minimum(1, own / 0.1), 0, 1)

    return Levels.filled(levels.shape, more)


def on_white(source: File, part: tuple[slice, slice], max_pixels: int) -> Bytes:
    """The sRGB code values, (h, w, 3), of part of a picture on white paper, transparent pixels in linear light."""
    codes, clear = colours(source, max_pixels)
    rgb = codes[part][..., :3]
    if not clear:
        return rgb
    alpha = codes[part][..., 3:] / 255
    return np.round(255 * encoded(linear(rgb / 255) * alpha + 1 - alpha)).astype(np.uint8)
