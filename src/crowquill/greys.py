"""Grey code values of decoded images, a band of rows at a time, and what code values mean as light."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.levels import Levels, bands
from crowquill.paths import Array

Bytes = npt.NDArray[np.uint8]


def deep(image: Any) -> bool:
    """Whether a Pillow image has more than 8 bits a colour."""
    return image.mode in ("F", "I") or image.mode.startswith("I;16")


def grey(image: Any, under: float) -> Levels:
    """Code values 0 to 1 of a Pillow image, its transparent pixels over a code value. Greys of 8 and 16 bits stay the codes they are."""
    shape = image.height, image.width
    if not deep(image):
        if image.mode not in ("1", "L") or "transparency" in image.info:
            return Levels.filled(shape, lambda top, bottom: luminance(np.asarray(_part(image, top, bottom).convert("RGBA")), under))
        codes = np.empty(shape, np.uint8)
        for top, bottom in bands(shape):
            codes[top:bottom] = np.asarray(_part(image, top, bottom).convert("L"))
        return Levels(codes, np.arange(256) / 255.0)
    low, high = _range(image)
    if image.mode != "F" and high <= 65535:
        codes = np.empty(shape, np.uint16)
        for top, bottom in bands(shape):
            codes[top:bottom] = _deep_values(image, top, bottom)
        table, clear = np.arange(65536) / 65535, image.info.get("transparency", -1)
        if clear in range(65536):
            table[clear] = under
        return Levels(codes, table)
    if high == low:
        low, high = 0.0, max(high, 1.0)

    def scaled(top: int, bottom: int) -> Array:
        values = _deep_values(image, top, bottom)
        with np.errstate(invalid="ignore"):
            return np.where(np.isnan(values), under, np.clip((values - low) / (high - low), 0, 1))

    return Levels.filled(shape, scaled)


def _part(image: Any, top: int, bottom: int) -> Any:
    return image.crop((0, top, image.width, bottom))


def _deep_values(image: Any, top: int, bottom: int) -> Array:
    """The numbers of some rows of an image of more than 8 bits."""
    with np.errstate(invalid="ignore"):  # a signalling NaN is one like any other
        values = np.asarray(_part(image, top, bottom)).astype(np.float64)
    if image.mode == "I":
        values[values < 0] += 2.0**32  # Pillow reads unsigned numbers as signed ones
    return values


def _range(image: Any) -> tuple[float, float]:
    """The least and the greatest finite number of an image of more than 8 bits, 0 and 0 where there is none."""
    found: list[float] = []
    for top, bottom in bands((image.height, image.width)):
        values = _deep_values(image, top, bottom)
        finite = values[np.isfinite(values)]
        found += [float(finite.min()), float(finite.max())] if finite.size else []
    return min(found, default=0.0), max(found, default=0.0)


def luminance(rgba: Bytes, under: float = 1.0) -> Array:
    """Code values of the luminance (Rec. 709) of pixels (h, w, 4) over a code value."""
    light_of = linear(np.arange(256) / 255)
    ground = float(linear(np.array(under)))
    light = sum(weight * light_of[rgba[..., k]] for k, weight in enumerate((0.2126, 0.7152, 0.0722)))
    alpha = rgba[..., 3] / 255
    # to nine digits: the three weights sum to 1 but for the last, and white is to be white
    return np.round(encoded(np.clip(light * alpha + (1 - alpha) * ground, 0, 1)), 9)


def linear(code: Array) -> Array:
    """Light of sRGB code values, both 0 to 1 (IEC 61966-2-1)."""
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


def encoded(light: Array) -> Array:
    """sRGB code values of light, both 0 to 1 (IEC 61966-2-1)."""
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)


def lightness(light: Array) -> Array:
    """CIE L* of light 0 to 1, itself 0 to 100."""
    return np.where(light <= 216 / 24389, light * 24389 / 27, 116 * np.cbrt(light) - 16)
