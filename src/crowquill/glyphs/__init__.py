"""Glyph libraries: SVG files of dots, loaded as unit glyphs. One file is one library."""

from __future__ import annotations

import base64
import binascii
import json
import os
import zlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from crowquill.marks import Glyph
from crowquill.marks import Patch as Patch  # what a library keeps of each
from crowquill.vector import contents, elements, local, shapes

FOLDER = Path(__file__).parent
WIDEST = 4096  # pixels a side of a grey patch: 3 mm at 2400 dpi are 300
MOST = 100_000_000  # pixels of all patches of a library: 40 000 dots of 50 pixels


@dataclass(frozen=True)
class Library:
    """Unit glyphs and what is known of them: pen_mm, how they were made, licence, whether they are simulated."""

    name: str
    glyphs: tuple[Glyph, ...]
    about: dict[str, Any]

    @property
    def pen(self) -> float | None:
        """The width of the pen in mm, where the library says it."""
        own = self.about.get("pen_mm")
        return float(own) if isinstance(own, (int, float)) and 0.01 <= own <= 50 else None


def names() -> list[str]:
    """The libraries that come with the package, sorted."""
    return sorted(path.stem for path in FOLDER.glob("*.svg"))


def nearest(pen: float) -> str:
    """The name of the library whose pen is nearest in width to this many mm, of those named nib-*; of two as near the wider."""
    widths = {name: float(_metadata(contents(FOLDER / f"{name}.svg"), name)["pen_mm"]) for name in names() if name.startswith("nib-")}
    return min(widths, key=lambda name: (max(widths[name] / pen, pen / widths[name]), -widths[name]))


def load(source: str | os.PathLike[str], *, grey: bool = False) -> Library:
    """The library of a name from names(), or of an SVG file by its path.

    grey  each glyph has its scan too, where the library keeps them; see `patches`

    Every shape of the file is a glyph, one closed outline at true size; it is made a
    unit glyph (area 1, centroid 0, long axis on x), and its true diameter kept. Raises ValueError
    for an unknown name or a file that holds no such glyphs, OSError where it cannot be read.
    """
    path = FOLDER / f"{source}.svg" if str(source) in names() else Path(source)
    if path.suffix.lower() != ".svg":
        raise ValueError(f"no glyph library {str(source)!r}; there are {', '.join(names())}, or the path of an SVG file")
    return parsed(contents(path), str(source), grey=grey)


def parsed(data: bytes, name: str, *, grey: bool = False) -> Library:
    """The library in the bytes of an SVG file; errors call it `name`."""
    about = _metadata(data, name)
    glyphs, outlines = [], []
    for paths, shape in shapes(data, name)[1]:
        try:
            outlines.append(paths.curved())
            glyphs.append(Glyph.of(outlines[-1]))
        except ValueError as error:
            raise ValueError(f"{name}: path {str(shape.id or len(glyphs))[:40]!r} is no glyph: {error}") from None
    if not glyphs:
        raise ValueError(f"{name}: the file has no paths; a glyph library has one closed path a dot")
    library = Library(str(about.get("name", name)), tuple(glyphs), about)
    scans = patches(library) if grey else ()
    return replace(library, glyphs=tuple(map(Glyph.of, outlines, scans))) if scans else library


def _metadata(data: bytes, name: str) -> dict[str, Any]:
    """What an SVG file says of its library; nothing where it has no <library> element."""
    said = [element.text or "{}" for element in elements(data, name) if local(element) == "library"]
    return _about(said[-1], name) if said else {}


def _about(text: str, name: str) -> dict[str, Any]:
    """The metadata of a library: a JSON object."""
    try:
        about = json.loads(text)
    except (ValueError, RecursionError):
        raise ValueError(f"{name}: its metadata is not JSON; mend or remove its <library> element") from None
    if not isinstance(about, dict):
        raise ValueError(f"{name}: its metadata is not a JSON object; mend or remove its <library> element")
    return about


def patches(library: Library) -> tuple[Patch, ...]:
    """The grey patch of each glyph of a library, in their order; none where the library keeps none.

    ValueError where the metadata under "patches" (see `scanning.library`) is broken, too large or not of these glyphs.
    """
    kept = library.about.get("patches")
    if kept is None:
        return ()
    wrong = f"{library.name}: its grey patches"
    try:
        shapes, pixel = [(_whole(h), _whole(w)) for h, w in kept["shape"]], float(kept["pixel_mm"])
        centres, text = np.array(kept["centre_mm"], np.float64).reshape(-1, 2), str(kept["grey"]).encode("ascii")
    except (KeyError, TypeError, ValueError, OverflowError):
        raise ValueError(f"{wrong} lack a sound pixel_mm, shape, centre_mm or grey; make the library anew") from None
    if not len(shapes) == len(centres) == len(library.glyphs):
        raise ValueError(f"{wrong} are {len(shapes)} with {len(centres)} centres for {len(library.glyphs)} dots; make the library anew")
    if not 0 < pixel < 1 or not np.isfinite(centres).all():
        raise ValueError(f"{wrong} have pixels of {pixel:g} mm or centres that are no numbers; make the library anew")
    counts = [h * w for h, w in shapes]
    if max(map(max, shapes), default=0) > WIDEST or sum(counts) > MOST:
        raise ValueError(f"{wrong} have {sum(counts)} pixels; it takes {WIDEST} a side and {MOST / 1e6:g} million at most")
    try:
        unpacked = zlib.decompressobj()
        grey = unpacked.decompress(base64.b64decode(text, validate=True), sum(counts) + 1)  # never more than is stated
        whole = unpacked.eof
    except (binascii.Error, zlib.error):
        grey, whole = b"", False
    if not whole or len(grey) != sum(counts):
        raise ValueError(f"{wrong} are broken or not of their stated shapes; make the library anew")
    parts = np.split(np.frombuffer(grey, np.uint8), np.cumsum(counts)[:-1])
    return tuple(Patch(part.reshape(shape) / 255, pixel, centre) for part, shape, centre in zip(parts, shapes, centres, strict=True))


def _whole(value: Any) -> int:
    """A whole number of pixels over 0."""
    if not isinstance(value, int) or isinstance(value, bool) or value < 1:
        raise ValueError(f"{value} is no number of pixels")
    return value
