"""SVG at true size, and the project file: what is drawn, and beside it the table it was drawn from."""

from __future__ import annotations

import base64
import hashlib
import io
import json
import re
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, groupby, pairwise
from typing import Annotated, Any, BinaryIO
from xml.etree import ElementTree

import numpy as np
import svgwrite
import svgwrite.container
import svgwrite.extensions
import svgwrite.image
import svgwrite.path

from crowquill.formats import png
from crowquill.formats._table import SCHEMA, packed, unpacked
from crowquill.formats._text import apart, chunks, number, svg_path
from crowquill.knobs import Flag
from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.sheet import Bitmap, Ink, Layer, Sheet, on_screen, outlined
from crowquill.vector import PX, elements, local, shapes

Shape = tuple[Paths, dict[str, str]]  # an element's outlines, and its colour where it has one of its own
KEEPS_FILES = True  # attached to a sheet
SPACE = "urn:crowquill:drawing"
SVG = "http://www.w3.org/2000/svg"
LARGEST = 2**31  # bytes of table unpacked; fifty million dots
SEPARATE = 20_000  # elements; Inkscape takes about 9 kB for each
PIECE = 1_000_000  # characters of table to an element: some readers stop at 10 MB of text
LATER = "@"  # in place of outlines that are written one by one
UNKNOWN = 64 * "0"  # in place of a checksum
UNSEEN = {"metadata", "title", "desc", "defs"}


def write(
    sheet: Sheet,
    file: BinaryIO,
    *,
    separate: Annotated[bool, Flag("an SVG element a dot, to retouch by hand; up to 20 000")] = False,
) -> None:
    """The sheet as SVG 1.1 in millimetres: a group a layer, few long paths in whole micrometres, a table of marks.

    Raises ValueError for more than 20 000 dots when each is to be an element of its own: editors stall over more.
    """
    foresee(sheet.size, sum(len(layer.art) for layer in sheet.layers if isinstance(layer.art, Marks)), separate=separate)
    width, height = sheet.size
    drawing = svgwrite.Drawing(
        size=(f"{number(width)}mm", f"{number(height)}mm"), viewBox=f"0 0 {number(width)} {number(height)}", debug=False
    )
    inkscape = svgwrite.extensions.Inkscape(drawing)
    drawn: list[Iterator[Shape]] = []
    for rank, layer in enumerate(sheet.layers, 1):
        group = inkscape.layer(label=_sayable(layer.label), id=f"layer{rank}", **_paint(layer.ink))
        drawing.add(group)
        if isinstance(layer.art, Bitmap):
            group.add(_image(layer.art, layer.ink))
            continue
        scaled = svgwrite.container.Group(transform="scale(.001)", debug=False)
        every = _coloured(layer, separate)
        if first := next(every, None):
            drawn.append(chain([first], every))
            scaled.add(svgwrite.path.Path(d=LATER, debug=False))
        group.add(scaled)
    root = drawing.get_xml()
    about, table = packed(sheet)
    about["drawn"] = UNKNOWN
    root.insert(0, _metadata(about, table, sheet.attached))
    _written(root, iter(drawn), file)


def _written(root: ElementTree.Element, drawn: Iterator[Iterator[Shape]], file: BinaryIO) -> None:
    """Writes a drawing, with the shapes of each layer in place of its path; the checksum, which stands before them, is put in last."""
    if not file.seekable():
        whole = io.BytesIO()
        _written(root, drawn, whole)
        file.write(whole.getbuffer())
        return
    skeleton = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    begin, parts = file.tell(), iter(skeleton.split(f'<path d="{LATER}" />'.encode()))
    head = next(parts)
    file.write(head)

    def put() -> Iterator[dict[str, str]]:
        for paths, colour in next(drawn):
            kept = {"d": svg_path(paths), **colour}
            file.write(b"<path")
            file.writelines(f' {key}="{value}"'.encode("ascii") for key, value in kept.items())
            file.write(b" />")
            yield kept
        file.write(next(parts))

    digest = _digest(root, put)
    file.write(b"\n")
    file.seek(begin + head.index(UNKNOWN.encode()))
    file.write(digest.encode())
    file.seek(0, io.SEEK_END)


def _image(art: Bitmap, ink: Ink) -> svgwrite.image.Image:
    """The bitmap as an image of its own pixels in mm, whose edges renderers are asked to keep."""
    data = "data:image/png;base64," + base64.b64encode(png.stencil(art, ink.rgb)).decode("ascii")
    image = svgwrite.image.Image(data, [number(at) for at in art.corner], [number(side, 6) for side in art.size], debug=False)
    image.stretch()
    image["image-rendering"], image["style"] = "optimizeSpeed", "image-rendering:pixelated"  # SVG 1.1's word, and browsers'
    return image


def foresee(_size: tuple[float, float], marks: int, *, separate: bool) -> None:
    """Raises ValueError for more marks than are written as elements of their own."""
    if separate and marks > SEPARATE:
        raise ValueError(f"{marks} dots are too many to be separate elements: editors bear {SEPARATE}; draw fewer, or leave out separate")


def read(data: bytes, name: str) -> Sheet:
    """The sheet of an SVG of ours from its table, or, where it was edited since, from its geometry."""
    root, about = _opened(data, name)
    try:
        kept = _kept(root)
        if about["drawn"] != _digest(root):
            warning = f"{name} was edited since it was made: its geometry was read, and its dots are outlines, not marks"
            if any("pixels" in layer for layer in about["layers"]):
                warning += "; bitmaps in it are left out"
            return replace(drawn(data, name), recipe=about["recipe"], report={"warnings": [warning]}, attached=kept)
        text = "".join(piece.text or "" for piece in root.iter(f"{{{SPACE}}}marks"))
        return replace(unpacked(about, zlib.decompressobj().decompress(base64.b64decode(text), LARGEST)), attached=kept)
    except (LookupError, TypeError, ValueError, AttributeError, zlib.error, RecursionError, OverflowError) as error:
        if str(error).startswith(f"{name}: "):
            raise
        raise _broken(name, error) from None


def recipe(data: bytes, name: str) -> tuple[dict[str, Any], dict[str, bytes]]:
    """What made the drawing in an SVG of ours, edited since or not, and the files kept inside it."""
    root, about = _opened(data, name)
    try:
        return dict(about["recipe"]), _kept(root)
    except (LookupError, TypeError, ValueError) as error:
        raise _broken(name, error) from None


def _opened(data: bytes, name: str) -> tuple[Any, Any]:
    """The root of an SVG of ours, and what it says of itself."""
    root = next(iter(elements(data, name)))
    found = root.find(f".//{{{SPACE}}}drawing")
    if found is None:
        raise ValueError(f"{name}: not a drawing of ours: it has no table of marks; give an SVG that crowquill wrote")
    about: Any = None
    try:
        about = json.loads(found.text or "")
        newer = about["schema"] > SCHEMA
    except (LookupError, TypeError, ValueError, RecursionError) as error:
        raise _broken(name, error) from None
    if newer:
        raise ValueError(f"{name}: made by a newer crowquill (schema {about['schema']}); update this one")
    return root, about


def _kept(root: Any) -> dict[str, bytes]:
    """The files kept in the metadata, by name."""
    texts: dict[str, str] = {}
    for piece in root.iter(f"{{{SPACE}}}file"):
        name = json.loads(piece.attrib["name"])
        texts[name] = texts.get(name, "") + (piece.text or "")
    return {name: base64.b64decode(text) for name, text in texts.items()}


def _broken(name: str, error: Exception) -> ValueError:
    return ValueError(f"{name}: its table of marks is broken ({error}); save the drawing again")


def _sayable(text: str) -> str:
    """The text with a question mark for what XML 1.0 has no way to say."""
    return re.sub("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "?", text)


def _paint(ink: Ink) -> dict[str, str]:
    """Fill or stroke attributes of a layer; what overprints is a filter over what is below, where a viewer knows of such."""
    colour = _hexadecimal(ink.rgb)
    over = {"style": "mix-blend-mode:multiply"} if ink.overprint else {}
    if ink.pen is None:
        return {"fill": colour, "stroke": "none", **over}
    return {
        **over,
        "fill": "none",
        "stroke": colour,
        "stroke-width": number(ink.pen * 1000),
        "stroke-linecap": "round",
        "stroke-linejoin": "round",
    }


def _coloured(layer: Layer, separate: bool) -> Iterator[Shape]:
    """The outlines of a layer's elements, and the colour of those that have one of their own: runs of rings of the same."""
    if layer.fill is None:
        every = apart(layer.art) if separate and isinstance(layer.art, Marks) else chunks(layer.art)
        yield from ((paths, {}) for paths in every)
        return
    art, codes = outlined(layer.art), on_screen(layer.fill)
    bounds = [0, *(np.flatnonzero((codes[1:] != codes[:-1]).any(axis=1)) + 1).tolist(), len(art)]
    for lo, hi in pairwise(bounds):
        for paths in chunks(art.take(np.arange(lo, hi))):
            yield paths, {"fill": _hexadecimal(codes[lo].tolist())}


def _hexadecimal(codes: Sequence[int]) -> str:
    return "#" + "".join(f"{code:02x}" for code in codes)


def _metadata(about: dict[str, Any], table: Iterator[bytes], attached: Mapping[str, bytes]) -> ElementTree.Element:
    packer = zlib.compressobj(6)
    packed = b"".join([*map(packer.compress, table), packer.flush()])
    metadata = ElementTree.Element("metadata")
    drawing = ElementTree.SubElement(metadata, "drawing", {"xmlns": SPACE})
    drawing.text = json.dumps(about, sort_keys=True)  # in ASCII: names may hold what XML cannot say
    kept = {json.dumps(name): contents for name, contents in attached.items()}
    for kind, more, contents in (("marks", {}, packed), *(("file", {"name": name}, kept[name]) for name in kept)):
        text = base64.b64encode(contents).decode("ascii")
        for at in range(0, max(len(text), 1), PIECE):
            ElementTree.SubElement(metadata, kind, {"xmlns": SPACE, **more}).text = text[at : at + PIECE]
    return metadata


def _digest(root: ElementTree.Element, put: Callable[[], Iterable[dict[str, str]]] | None = None) -> str:
    """A checksum of everything drawn: elements of SVG and their own attributes, in order; ids and comments do not count.

    put  gives, for each path that stands for others, the attributes of these
    """
    total = hashlib.sha256()

    def walk(element: ElementTree.Element, depth: int) -> None:
        tag = str(element.tag)
        if (tag.startswith("{") and not tag.startswith(f"{{{SVG}}}")) or local(element) in UNSEEN:
            return
        for attributes in put() if put and element.get("d") == LATER else [element.attrib]:
            kept = [
                (key, value)
                for key, value in sorted(attributes.items())
                if not any(mark in key for mark in ":}") and key not in ("id", "xmlns", "version", "baseProfile")
            ]
            if local(element) == "image":  # however its lines are broken
                kept += [("href", "".join(value.split())) for key, value in element.attrib.items() if key.endswith("href")]
            total.update(repr((depth, local(element), kept)).encode())
        for child in element:
            walk(child, depth + 1)

    walk(root, 0)
    return total.hexdigest()


def drawn(data: bytes, name: str) -> Sheet:
    """The sheet that any SVG draws: filled outlines and strokes as paths in their colours. Dots are outlines, not marks."""
    size, inked = painted(data, name)
    return Sheet(size, _joined(inked))


def painted(data: bytes, name: str) -> tuple[tuple[float, float], list[tuple[Ink, Paths]]]:
    """The page's size in mm and what any SVG draws on it: the closed and the open outlines of each shape, with their ink."""
    size, found = shapes(data, name)
    if min(size) <= 0:
        raise ValueError(f"{name}: its page has no size; give it a width and a height in mm")
    inked: list[tuple[Ink, Paths]] = []
    for paths, shape in found:
        pen = None if shape.fill is not None and shape.fill.value is not None else float(shape.stroke_width or 0) * PX
        colour = shape.fill if pen is None else shape.stroke
        if colour is None or colour.value is None or pen == 0:
            continue
        red, green, blue = (channel / 255 for channel in (colour.red, colour.green, colour.blue))
        black = 1 - max(red, green, blue)
        cmy = [0.0 if black == 1 else (1 - black - share) / (1 - black) for share in (red, green, blue)]
        ink = Ink("black" if cmy == [0, 0, 0] and black == 1 else str(colour.hex), (*cmy, black), pen)
        inked.append((ink, paths))
    return size, inked


def _joined(found: list[tuple[Ink, Paths]]) -> tuple[Layer, ...]:
    """Layers of neighbouring paths of one ink and one kind."""
    runs = groupby(found, key=lambda pair: (pair[0], pair[1].closed, pair[1].cubic))
    return tuple(
        Layer(ink, Paths.of([path for _, paths in run for path in paths], closed=closed, cubic=cubic)) for (ink, closed, cubic), run in runs
    )
