"""Picture files, read with care: the grey code values of any that Pillow reads, and what they mean as light."""

from __future__ import annotations

import contextlib
import os
import stat
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from crowquill.paths import Array

MAX_PIXELS = 200_000_000  # refused from the header above this, before a pixel is decoded
FORMATS = ("PNG", "JPEG", "TIFF", "BMP", "GIF", "WEBP", "PPM", "JPEG2000")  # no format that runs programs
_LIMIT = threading.Lock()


def decoded(source: str | os.PathLike[str] | BinaryIO, max_pixels: int = MAX_PIXELS) -> Array:
    """A picture's grey code values, (h, w) of 0 (black) to 1 (white), upright and over white.

    Colours are weighed by their luminance in linear light and encoded again. Floats, and whole numbers of
    32 bits, have no white of their own: they are scaled by their finite range; NaN is white.
    """
    from PIL import Image, ImageOps, UnidentifiedImageError

    name = source if isinstance(source, (str, os.PathLike)) else getattr(source, "name", "picture")
    if max_pixels < 1:
        raise ValueError(f"max pixels is {max_pixels}; it takes a number over 0")
    if isinstance(source, (str, os.PathLike)):
        facts = Path(source).stat()
        if not stat.S_ISREG(facts.st_mode):
            raise ValueError(f"{name}: is {'a folder' if stat.S_ISDIR(facts.st_mode) else 'not a regular file'}; give a picture file")
        if facts.st_size == 0:
            raise ValueError(f"{name}: the file is empty; give a picture file")
    try:
        with _own_limit():
            opened = Image.open(source, formats=FORMATS)
        with opened as image:
            w, h = image.size
            if w * h == 0:
                raise ValueError(f"{name}: the picture has no pixels; give one with at least one")
            if w * h > max_pixels:
                raise ValueError(
                    f"{name}: {w} x {h} pixels are over the limit of {max_pixels / 1e6:g} million; "
                    f"make it smaller, or raise the limit with --max-pixels {w * h}"
                )
            grey = _grey(ImageOps.exif_transpose(image))
            return 1 - grey if _counts_ink(image) else grey
    except UnidentifiedImageError:
        raise ValueError(f"{name}: not a picture that can be read; give one of {', '.join(FORMATS)}") from None
    except (SyntaxError, EOFError, OSError, MemoryError, TypeError, OverflowError, ValueError) as error:
        if (isinstance(error, OSError) and error.filename) or str(error).startswith(f"{name}: "):
            raise
        raise ValueError(f"{name}: the picture is broken ({' '.join(str(error).split())}); save it again") from None


@contextlib.contextmanager
def _own_limit() -> Iterator[None]:
    """Pillow's limit on pixels is one for all of a program, and below ours: it is out of force while a file is opened."""
    from PIL import Image

    with _LIMIT:
        limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
        try:
            yield
        finally:
            Image.MAX_IMAGE_PIXELS = limit


def _counts_ink(image: Any) -> bool:
    """Whether a TIFF's numbers rise with ink (photometric 0), which Pillow turns round for 8 bits alone."""
    return image.format == "TIFF" and image.tag_v2.get(262) == 0 and image.mode not in ("1", "L", "P")


def _grey(image: Any) -> Array:
    """Code values 0 to 1 of a Pillow image over white."""
    if image.mode in ("F", "I") or image.mode.startswith("I;16"):
        with np.errstate(invalid="ignore"):  # a signalling NaN is one like any other
            values = np.asarray(image).astype(np.float64)
        if image.mode == "I" and values.min(initial=0) < 0:
            values[values < 0] += 2.0**32  # Pillow reads unsigned numbers as signed ones
        if image.mode != "F" and values.max(initial=0) <= 65535:
            clear = values == image.info.get("transparency", -1)
            return np.where(clear, 1.0, values / 65535)
        finite = values[np.isfinite(values)]
        low, high = (finite.min(), finite.max()) if finite.size else (0.0, 0.0)
        if high == low:
            low, high = 0.0, max(high, 1.0)
        with np.errstate(invalid="ignore"):
            return np.where(np.isnan(values), 1.0, np.clip((values - low) / (high - low), 0, 1))
    if image.mode in ("1", "L") and "transparency" not in image.info:
        return np.asarray(image.convert("L")) / 255.0
    return _luminance(np.asarray(image.convert("RGBA")))


def _luminance(rgba: npt.NDArray[np.uint8]) -> Array:
    """Code values of the luminance (Rec. 709) of pixels (h, w, 4) over white, a band of rows at a time."""
    light_of = linear(np.arange(256) / 255)
    code = np.empty(rgba.shape[:2])
    for top in range(0, len(rgba), 256):
        band = rgba[top : top + 256]
        light = sum(weight * light_of[band[..., k]] for k, weight in enumerate((0.2126, 0.7152, 0.0722)))
        alpha = band[..., 3] / 255
        # to nine digits: the three weights sum to 1 but for the last, and white is to be white
        code[top : top + 256] = np.round(encoded(np.clip(light * alpha + (1 - alpha), 0, 1)), 9)
    return code


def linear(code: Array) -> Array:
    """Light of sRGB code values, both 0 to 1 (IEC 61966-2-1)."""
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


def encoded(light: Array) -> Array:
    """sRGB code values of light, both 0 to 1 (IEC 61966-2-1)."""
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)


def lightness(light: Array) -> Array:
    """CIE L* of light 0 to 1, itself 0 to 100."""
    return np.where(light <= 216 / 24389, light * 24389 / 27, 116 * np.cbrt(light) - 16)
