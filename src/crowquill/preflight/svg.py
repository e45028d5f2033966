"""The SVG side: what a file draws, in millimetres, and rules for its frame."""

from __future__ import annotations

import base64
import binascii
import io
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import Image, UnidentifiedImageError

from crowquill.formats import svg as own
from crowquill.paths import Paths
from crowquill.preflight.drawing import Art, Bitmap, Colour, Drawing, same_paper
from crowquill.preflight.operators import FLAT
from crowquill.preflight.rules import ERROR, INFORMATION, WARNING, Hit, Limits, rule
from crowquill.sheet import Bitmap as Pixels
from crowquill.sheet import Ink, Sheet, outlined
from crowquill.units import INCH
from crowquill.vector import FURTHEST, PX, elements, local, shapes

LONGEST = 10_000_000  # bytes of an attribute or a text that libxml2 reads
LENGTH = re.compile(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*(mm|cm|in|pt|pc|px|%)?\s*")
TO_MM = {"mm": 1.0, "cm": 10.0, "in": INCH, "pt": INCH / 72, "pc": INCH / 6, "px": PX, None: PX}
UNREAD = ("text", "image", "clipPath", "mask", "pattern", "filter", "foreignObject", "marker", "linearGradient", "radialGradient")
ACTIVE = ("script", "foreignObject", "animate", "animateTransform", "animateMotion", "set")
OURS = ("metadata", "title", "desc")
LARGE = 50 * 2**20  # bytes
SCALE = 1e-4  # of a scale: sizes are written with few digits
BLACK = Colour("black", (("Black", 1.0),))

Shape = tuple[Paths, Colour | None, Colour | None, float, bool, bool]  # outlines, fill, stroke, pen, even-odd, round caps


@dataclass(frozen=True, eq=False)
class Plate:
    """An SVG: its name, every element in order, and what it draws."""

    name: str
    every: list[Any]
    bytes: int
    drawing: Drawing


def opened(data: bytes, name: str) -> Plate:
    """The SVG and what it draws. Drawings of ours are taken from their tables, unless they were edited since.

    Raises ValueError for what is no SVG, or has shapes that cannot be read.
    """
    every = list(elements(data, name))
    laid = _ours(data, name) if any("urn:crowquill:drawing" in str(one.tag) for one in every) else None
    if laid is not None:
        size, found = laid
    else:
        size, read = shapes(data, name)
        found = [(paths, *_painted(shape)) for paths, shape in read]
    if not all((np.abs(paths.xy) < FURTHEST).all() for paths, *_ in found):
        raise ValueError(f"{name}: a shape lies over {FURTHEST / 1e6:g} km away, or nowhere; mend its coordinates")
    counts = {kind: sum(local(one) == kind for one in every) for kind in UNREAD}
    page = (0.0, 0.0, float(size[0]), float(size[1]))
    bitmaps = tuple(_bitmaps(every, size))
    drawn = sum(local(one) not in OURS for one in every)
    drawing = Drawing(
        "page",
        page,
        page,
        of_shapes(found),
        bitmaps=bitmaps,
        extents=tuple(one.box for one in bitmaps),
        unread={kind: count for kind, count in counts.items() if count},
        elements=drawn,
        parts="elements",
        page=page,
        screen=True,
    )
    return Plate(name, every, len(data), drawing)


def _ours(data: bytes, name: str) -> tuple[tuple[float, float], list[Shape]] | None:
    """The size and the shapes of a drawing of ours.

    None where its geometry is not what its table says, or it holds more than outlines in one ink.
    """
    try:
        sheet = own.read(data, name)
        plain = not any(isinstance(layer.art, Pixels) or layer.fill is not None for layer in sheet.layers)
        return (sheet.size, list(_laid(sheet))) if plain and not sheet.report.get("warnings") else None
    except ValueError:
        return None


def _laid(sheet: Sheet) -> Iterator[Shape]:
    for layer in sheet.layers:
        colour, pen = _inked(layer.ink), layer.ink.pen
        yield outlined(layer.art), (colour if pen is None else None), (None if pen is None else colour), pen or 0.0, False, True


def _inked(ink: Ink) -> Colour:
    return _lit(*(share / 255 for share in ink.rgb))


def _lit(red: float, green: float, blue: float) -> Colour:
    """A colour of a screen: black is taken for the ink, as in drawings that we read."""
    return BLACK if max(red, green, blue) == 0 else Colour("sRGB", light=(red, green, blue))


def _painted(shape: Any) -> tuple[Colour | None, Colour | None, float, bool, bool]:
    """How a shape of svgelements is painted."""
    fill, stroke = (
        _lit(one.red / 255, one.green / 255, one.blue / 255) if one is not None and one.value is not None else None
        for one in (shape.fill, shape.stroke)
    )
    pen = float(shape.stroke_width or 0) * PX
    values = shape.values
    return fill, stroke if pen > 0 else None, pen, values.get("fill-rule") == "evenodd", values.get("stroke-linecap") == "round"


def of_shapes(found: Iterable[Shape]) -> Art:
    """Outlines and their paint as Art; each run of outlines is a thing."""
    runs = list(found)
    colours: dict[Colour, int] = {}
    paint: list[tuple[int, int, float, bool, bool]] = []
    flats, areas, closed = [], [], []
    for paths, fill, stroke, pen, evenodd, round_ in runs:
        flat = paths.flat(FLAT)
        flats.append(flat)
        areas.append(paths.areas if paths.closed else Paths(flat.xy, flat.start).areas)
        closed.append(np.full(len(paths), paths.closed))
        indices = [-1 if one is None else colours.setdefault(one, len(colours)) for one in (fill, stroke)]
        paint.append((indices[0], indices[1], pen, evenodd, round_))
    counts = np.concatenate([np.zeros(0, np.int64), *(np.diff(flat.start) for flat in flats)])
    kept = counts > 0
    fills, strokes, pens, odd, rounds = (np.array([row[k] for row in paint]) for k in range(5))
    return Art(
        Paths(np.concatenate([np.zeros((0, 2)), *(flat.xy for flat in flats)]), np.concatenate([[0], np.cumsum(counts[kept])])),
        np.concatenate([np.zeros(0), *areas])[kept],
        np.concatenate([np.zeros(0, bool), *closed])[kept],
        np.repeat(np.arange(len(runs)), [len(flat) for flat in flats])[kept],
        fills.astype(np.int64),
        strokes.astype(np.int64),
        pens.astype(np.float64),
        odd.astype(bool),
        rounds.astype(bool),
        np.zeros((len(runs), 2), bool),
        tuple(colours),
    )


def _length(text: str | None, whole: float = 0.0) -> float | None:
    """Millimetres of a length of an attribute, None where it is none; a share is one of the whole."""
    found = LENGTH.fullmatch(text or "")
    if not found:
        return None
    try:
        return float(found[1]) * (whole / 100 if found[2] == "%" else TO_MM[found[2]])
    except ValueError:
        return None


def _bitmaps(every: list[Any], size: tuple[float, float]) -> Iterator[Bitmap]:
    """The bitmaps, those beside the file with no pixels known left out."""
    import svgelements

    parents = {child: parent for parent in every for child in parent}
    for one in every:
        if local(one) != "image":
            continue
        box, node = [_length(one.get(key), whole) for key, whole in zip(("x", "y", "width", "height"), (*size, *size), strict=True)], one
        x, y, width, height = (value or 0.0 for value in box)
        matrix = svgelements.Matrix()
        while node is not None:
            matrix = matrix * svgelements.Matrix(node.get("transform", ""))
            node = parents.get(node)
        scale = _scale(every[0], size)
        corners = [matrix.point_in_matrix_space((a / PX, b / PX)) for a in (x, x + width) for b in (y, y + height)]
        xs, ys = [point.x * PX * scale for point in corners], [point.y * PX * scale for point in corners]
        pixels = _pixels(next((value for key, value in one.attrib.items() if key.rsplit("}", 1)[-1] == "href"), ""))
        wide, high = max(xs) - min(xs), max(ys) - min(ys)
        if pixels and wide > 0 and high > 0:
            bits = 1 if pixels[2] == "1" else 8
            ppi = min(pixels[0] / wide, pixels[1] / high) * INCH
            yield Bitmap(f"image {one.get('id', '')}".strip(), (min(xs), min(ys), max(xs), max(ys)), pixels[:2], bits, ppi)


def _scale(root: Any, size: tuple[float, float]) -> float:
    """How many times as large as a px a unit of the file is."""
    view = [float(part) for part in re.findall(r"[-+\d.eE]+", root.get("viewBox", ""))]
    return size[0] / PX / view[2] if len(view) == 4 and view[2] > 0 and size[0] > 0 else 1.0


def _pixels(link: str) -> tuple[int, int, str] | None:
    """Width, height and mode of a bitmap inside the file, read from its header."""
    if not link.startswith("data:") or "base64," not in link:
        return None
    try:
        with Image.open(io.BytesIO(base64.b64decode(link.split("base64,", 1)[1])), formats=["PNG", "JPEG", "GIF", "WEBP"]) as picture:
            return picture.width, picture.height, str(picture.mode)
    except (UnidentifiedImageError, OSError, ValueError, binascii.Error, Image.DecompressionBombError, SyntaxError):
        return None


@rule("svg-size", ERROR, "svg")
def size(plate: Plate, limits: Limits) -> Iterator[Hit]:
    """The page's width and height are said in mm or another length, and its viewBox has the same scale both ways."""
    root = plate.every[0]
    found = [LENGTH.fullmatch(root.get(key, "")) for key in ("width", "height")]
    if not all(one and one[2] in ("mm", "cm", "in", "pt", "pc") for one in found):
        said = " and ".join(repr(root.get(key)) for key in ("width", "height"))
        yield Hit("page", f"its width and height are {said}, which is no size on paper; state both in mm", None)
        return
    sides = [_length(root.get(key)) or 0.0 for key in ("width", "height")]
    view = re.findall(r"[-+]?[\d.]+(?:[eE][-+]?\d+)?", root.get("viewBox", ""))
    if len(view) != 4 or float(view[2]) <= 0 or float(view[3]) <= 0 or min(sides) <= 0:
        yield Hit("page", "it has no viewBox of four numbers with an area; units without one are px", None, WARNING)
        return
    scales = [side / float(extent) for side, extent in zip(sides, view[2:], strict=True)]
    if abs(scales[0] / scales[1] - 1) > SCALE:
        yield Hit(
            "page", f"its viewBox is {scales[0]:.6g} mm to the unit across and {scales[1]:.6g} down", [round(one, 6) for one in scales]
        )
    if limits.size and not same_paper(sides, limits.size):
        yield Hit("page", f"it is {sides[0]:g} x {sides[1]:g} mm, not {limits.size[0]:g} x {limits.size[1]:g} mm", sides)


@rule("svg-longest", ERROR, "svg")
def longest(plate: Plate, _: Limits) -> Iterator[Hit]:
    """No attribute or text is over 10 MB, where many readers stop."""
    most = max((len(text) for one in plate.every for text in (*one.attrib.values(), one.text or "")), default=0)
    if most > LONGEST:
        yield Hit("page", f"an attribute or text has {most / 1e6:.1f} million characters", most)


@rule("svg-outside", ERROR, "svg")
def references(plate: Plate, _: Limits) -> Iterator[Hit]:
    """Nothing is fetched from elsewhere: pictures, shapes and style sheets are in the file."""
    found = []
    for one in plate.every:
        for key, value in one.attrib.items():
            if key.rsplit("}", 1)[-1] in ("href", "src") and local(one) != "a" and not value.strip().startswith(("#", "data:")):
                found.append(value)
            found += re.findall(r"url\(\s*['\"]?(?![#'\"]|data:)([^)'\"]+)", value)
        if local(one) == "style":
            found += re.findall(r"@import[^;]+|url\(\s*['\"]?(?!#|data:)[^)]+", one.text or "")
    if found:
        yield Hit("page", f"{len(found)} things are fetched from elsewhere: {found[0][:60]}", len(found))


@rule("svg-active", ERROR, "svg")
def active(plate: Plate, _: Limits) -> Iterator[Hit]:
    """There are no scripts, no animation, and nothing of HTML."""
    found = [local(one) for one in plate.every if local(one) in ACTIVE]
    found += [key for one in plate.every for key in one.attrib if key.startswith("on")]
    if found:
        yield Hit("page", f"it has {', '.join(dict.fromkeys(found))}", len(found))


@rule("svg-text", WARNING, "svg")
def words(plate: Plate, _: Limits) -> Iterator[Hit]:
    """Text is outlines: letters need a font that the printer may not have."""
    count = sum(local(one) == "text" for one in plate.every)
    if count:
        yield Hit("page", f"{count} texts need their fonts; turn them into outlines", count)


@rule("svg-colours", INFORMATION, "svg")
def colours(plate: Plate, _: Limits) -> Iterator[Hit]:
    """Colours other than black, which a press mixes of inks."""
    found = [one for one in plate.drawing.art.colours if one.light is not None and not one.white]
    if found:
        said = ["#" + "".join(f"{round(255 * share):02x}" for share in one.light or ()) for one in found]
        yield Hit("page", f"{len(found)} colours other than black: {', '.join(said[:5])}", said)


@rule("svg-file-size", WARNING, "svg")
def file_size(plate: Plate, _: Limits) -> Iterator[Hit]:
    """The file is below 50 MB."""
    if plate.bytes > LARGE:
        yield Hit("page", f"{plate.bytes / 2**20:.0f} MB is much for a plate", plate.bytes)
