"""Picture files, read with care: the grey code values of any that Pillow reads, and what they mean as light.

An embedded ICC profile is followed to sRGB by relative colorimetry with black point compensation, in 8 bits: the paper's white
is no ink, the darkest there is is black, and profiles that have no table of perception come out like those that have one.
"""

from __future__ import annotations

import contextlib
import io
import os
import stat
import struct
import threading
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from crowquill import expense
from crowquill.greys import Bytes as Bytes
from crowquill.greys import deep, grey
from crowquill.greys import encoded as encoded  # what pictures mean as light is had from here
from crowquill.greys import lightness as lightness
from crowquill.greys import linear as linear
from crowquill.levels import Levels
from crowquill.paths import Array

MAX_PIXELS = 200_000_000  # refused from the header above this, before a pixel is decoded
FORMATS = ("PNG", "JPEG", "TIFF", "BMP", "GIF", "WEBP", "PPM", "JPEG2000")  # no format that runs programs
SAME = 2  # of 255: by so much profiles that all call themselves sRGB differ; their pictures keep their exact code values
DEEP = "the picture's colour profile is not followed in 16 bits and more; save it as sRGB, or in 8 bits"
BROKEN = "the picture's colour profile cannot be read; it is taken for sRGB"
FOREIGN = "the picture's colour profile is for another kind of picture; it is left out"
INKS = "the picture is in CMYK without a colour profile, and its tones are a guess; save it as sRGB, or with its profile"
TAGS = "the picture's tags are damaged; see whether it stands upright"
_LOCK = threading.Lock()
File = str | os.PathLike[str] | BinaryIO
Notes = tuple[str, ...]


def decoded(source: File, max_pixels: int = MAX_PIXELS) -> Array:
    """The grey code values of `read`, over white, without its notes."""
    return read(source, max_pixels)[0]


def read(source: File, max_pixels: int = MAX_PIXELS, *, under: float = 1.0) -> tuple[Array, Notes]:
    """A picture's grey code values, (h, w) of 0 (black) to 1 (white), upright; and what is to be said of how they were read; see `kept`."""
    levels, notes = kept(source, max_pixels, under=under)
    return levels.whole(), notes


def kept(source: File, max_pixels: int = MAX_PIXELS, *, under: float = 1.0) -> tuple[Levels, Notes]:
    """The same in the depth of the file: greys of 8 and 16 bits stay codes, of a byte or two a pixel.

    Colours are weighed by their luminance in linear light and encoded again. `under` is the code value on which
    transparent pixels lie, in linear light. Floats, and whole numbers of 32 bits, have no white of their own: they are scaled
    by their finite range; NaN is `under`.
    """
    with _opened(source, max_pixels) as (image, notes):
        inverse = _counts_ink(image)
        image, more = _in_srgb(image)
        levels = grey(image, 1 - under if inverse else under)
        return levels.mapped(lambda code: 1 - code) if inverse else levels, notes + more


def colours(source: File, max_pixels: int = MAX_PIXELS) -> tuple[Bytes, bool]:
    """A picture's sRGB code values and opacity, (h, w, 4) of 0 to 255, upright; and whether it has transparent pixels to speak of.

    Pictures of more than 8 bits are greys here, as by `read`.
    """
    with _opened(source, max_pixels) as (image, _):
        clear = bool(image.has_transparency_data)
        if not deep(image):
            return np.asarray(_in_srgb(image)[0].convert("RGBA")), clear
        inverse = _counts_ink(image)
        codes = (255 * grey(image, 1.0).whole()).round().astype(np.uint8)
        solid = grey(image, 0.0).whole() == grey(image, 1.0).whole() if clear else np.ones(codes.shape, bool)
        return np.stack([*[255 - codes if inverse else codes] * 3, solid * np.uint8(255)], axis=2), clear


def shape(source: File, max_pixels: int = MAX_PIXELS) -> tuple[int, int]:
    """Rows and columns of a picture once it stands upright."""
    with _opened(source, max_pixels) as (image, _):
        return image.height, image.width


def pixels(source: File) -> int:
    """How many pixels a picture says that it has, before one is decoded; 0 where it cannot be read."""
    from PIL import Image

    try:
        with _LOCK, _begun(Image, source) as image:
            return int(image.width * image.height)
    except (SyntaxError, EOFError, OSError, MemoryError, TypeError, ArithmeticError, LookupError, struct.error, ValueError):
        return 0


def window(shape: tuple[int, ...], crop: tuple[float, float, float, float] | None) -> tuple[slice, slice]:
    """Rows and columns of a picture of this shape that a crop leaves: left, top, width, height as shares; at least one of each."""
    h, w = shape[:2]
    if crop is None:
        return slice(0, h), slice(0, w)
    if len(crop) != 4:
        raise ValueError(f"crop {crop} has {len(crop)} numbers; give left, top, width, height as shares of 1")
    left, top, width, height = crop
    if not (0 <= left < left + width <= 1 + 1e-9 and 0 <= top < top + height <= 1 + 1e-9):
        raise ValueError(f"crop {crop} is not inside the picture; give left, top, width, height as shares of 1")
    x, y = min(round(left * w), w - 1), min(round(top * h), h - 1)
    return slice(y, min(h, max(y + 1, round((top + height) * h)))), slice(x, min(w, max(x + 1, round((left + width) * w))))


@contextlib.contextmanager
def _opened(source: File, max_pixels: int) -> Iterator[tuple[Any, Notes]]:
    """A Pillow image, decoded and upright, and notes; whatever is wrong with it is one ValueError in one line."""
    from PIL import UnidentifiedImageError

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
        image, notes = _loaded(source, str(name), max_pixels)
        with image:
            yield image, notes
    except UnidentifiedImageError:
        raise ValueError(f"{name}: not a picture that can be read; give one of {', '.join(FORMATS)}") from None
    except (SyntaxError, EOFError, OSError, MemoryError, TypeError, ArithmeticError, LookupError, struct.error, ValueError) as error:
        if (isinstance(error, OSError) and error.filename) or str(error).startswith((f"{name}: ", expense.SETTING)):
            raise
        raise ValueError(f"{name}: the picture is broken ({' '.join(str(error).split())}); save it again") from None


def _loaded(source: File, name: str, max_pixels: int) -> tuple[Any, Notes]:
    """The image decoded and turned upright by its EXIF tag, and a note where its tags are damaged."""
    from PIL import Image, ImageOps

    with _LOCK, warnings.catch_warnings(record=True) as said:  # Pillow's limit and the warnings are one for all of a program
        warnings.simplefilter("always")
        image = _begun(Image, source)
        try:
            w, h = image.size
            if w * h == 0:
                raise ValueError(f"{name}: the picture has no pixels; give one with at least one")
            if w * h > max_pixels:
                raise ValueError(
                    f"{name}: {w} x {h} pixels are over the limit of {_told(max_pixels)}; "
                    f"make it smaller, or raise the limit with --max-pixels {w * h}"
                )
            depth = 1 if image.mode in ("1", "L", "P") else 2 if image.mode.startswith("I;16") else 4
            expense.afford(w * h * (depth + min(depth, 2)), f"{name}: {w} x {h} pixels take", "make it smaller")
            image.load()
            damaged = False
            try:
                ImageOps.exif_transpose(image, in_place=True)
            except Exception:  # whatever stands in the tags, the pixels are there
                damaged = True
        except BaseException:
            image.close()
            raise
    damaged = damaged or any("corrupt" in str(w.message).lower() or "truncated" in str(w.message).lower() for w in said)
    return image, (TAGS,) if damaged else ()


def _begun(pillow: Any, source: File) -> Any:
    """The image of which only the header is read; Pillow's own limit is below ours, and set aside."""
    limit, pillow.MAX_IMAGE_PIXELS = pillow.MAX_IMAGE_PIXELS, None
    try:
        return pillow.open(source, formats=FORMATS)
    finally:
        pillow.MAX_IMAGE_PIXELS = limit


def _told(pixels: int) -> str:
    """A number of pixels, in millions where it is one."""
    return f"{pixels / 1e6:g} million" if pixels >= 1e6 else str(pixels)


def _counts_ink(image: Any) -> bool:
    """Whether a TIFF's numbers rise with ink (photometric 0), which Pillow turns round for 8 bits alone."""
    return image.format == "TIFF" and image.tag_v2.get(262) == 0 and image.mode not in ("1", "L", "P")


def _in_srgb(image: Any) -> tuple[Any, Notes]:
    """The image with its colours in sRGB by its profile, its opacity as it is; and what is to be said of it."""
    from PIL import ImageCms

    data = image.info.get("icc_profile")
    if image.mode == "LAB":
        return _followed(image, ImageCms.createProfile("LAB"), "LAB"), ()
    if not data or image.mode == "1":  # black and white are so in any profile
        return (image.convert("RGB"), (INKS,)) if image.mode == "CMYK" else (image, ())
    grey = deep(image) or image.mode in ("L", "LA", "La")
    space = ""
    try:
        profile = ImageCms.ImageCmsProfile(io.BytesIO(data))
        space = profile.profile.xcolor_space.strip() if profile.profile.device_class in ("scnr", "mntr", "prtr", "spac") else "none"
        if space not in (("GRAY", "RGB") if grey else ("CMYK",) if image.mode == "CMYK" else ("RGB",)):
            raise ValueError(f"a profile for {space}")
        if grey:
            return _greys_followed(image, _ramp(profile, space))
        if image.mode == "CMYK":
            return _followed(image, profile, "CMYK"), ()
        image = image.convert("RGBA" if image.has_transparency_data else "RGB")
        steps = np.arange(0, 256, 17, dtype=np.uint8)
        lattice = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(1, -1, 3)
        if _differs(np.asarray(_followed(_image(lattice), profile, "RGB")), lattice):
            image = _followed(image, profile, image.mode)
        return image, ()
    except (ImageCms.PyCMSError, OSError, TypeError, ValueError):
        said = FOREIGN if space else BROKEN
        return (image.convert("RGB"), (said, INKS)) if image.mode == "CMYK" else (image, (said,))


def _image(values: Bytes) -> Any:
    from PIL import Image

    return Image.fromarray(values)


def _differs(values: Bytes, others: Bytes) -> bool:
    """Whether any two code values are further apart than those of one sRGB from another."""
    return bool((np.abs(values.astype(int) - others) > SAME).any())


def _followed(image: Any, profile: Any, mode: str) -> Any:
    """The image, of this mode in the profile, as sRGB: RGBA for RGBA, else RGB."""
    from PIL import ImageCms

    out = mode if mode in ("RGB", "RGBA") else "RGB"
    flags = ImageCms.Flags.BLACKPOINTCOMPENSATION
    if mode == "L":  # a ramp, for which littleCMS's shortcut is too coarse in the dark: 3.8 % off at most, from linear light
        flags |= ImageCms.Flags.NOOPTIMIZE
    how = (ImageCms.Intent.RELATIVE_COLORIMETRIC, flags)
    step = ImageCms.buildTransform(profile, ImageCms.createProfile("sRGB"), mode, out, *how)
    done = ImageCms.applyTransform(image, step, inPlace=out == mode)
    return image if done is None else done


def _ramp(profile: Any, space: str) -> Bytes:
    """The sRGB code value of each of the 256 greys of a profile, whose own grey axis it is for one of colours."""
    greys = np.arange(256, dtype=np.uint8)[None]
    image = _image(greys) if space == "GRAY" else _image(np.repeat(greys[..., None], 3, axis=2))
    codes: Bytes = np.asarray(_followed(image, profile, "L" if space == "GRAY" else "RGB"))[0].mean(axis=1).round().astype(np.uint8)
    return codes


def _greys_followed(image: Any, ramp: Bytes) -> tuple[Any, Notes]:
    """A grey image by the ramp of its profile; one of more than 8 bits as it is, with a note where that matters."""
    from PIL import Image

    if not _differs(ramp, np.arange(256, dtype=np.uint8)):
        return image, ()
    if deep(image):
        return image, (DEEP,)
    if not image.has_transparency_data:
        return image.point(ramp.tolist()), ()
    light, alpha = image.convert("LA").split()
    return Image.merge("LA", (light.point(ramp.tolist()), alpha)), ()
