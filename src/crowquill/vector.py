"""Other people's SVG files: read with care, and turned into Paths in millimetres."""

from __future__ import annotations

import io
import re
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import shapely

from crowquill.paths import Array, Paths
from crowquill.units import INCH

LIMIT = 512 * 2**20  # bytes; ten million dots of our own stay below
DEPTH = 200  # nested elements
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
TRANSFORM = re.compile(r"\s*(?:none|(?:(?:matrix|translate|scale|rotate|skew)[XY]?\s*\([^()]*\)[\s,]*)*)", re.IGNORECASE)
SHAPES = {"svg", "rect", "circle", "ellipse", "line", "polygon", "polyline", "path", "use"}
UNDRAWN = {"symbol", "marker", "mask", "pattern", "clipPath"}  # drawn where others name them, not where they stand
COPIES = 1_000_000
FURTHEST = 1e6  # mm
SIZES = {"r", "rx", "ry", "width", "height"}
LENGTHS = {"x", "y", "x1", "y1", "x2", "y2", "cx", "cy", "r", "rx", "ry", "width", "height"}
HIDDEN = (("display", "none"), ("visibility", "hidden"))
PX = INCH / 96  # mm to the CSS pixel
KAPPA = 2 - np.sqrt(4 - 20 / 3 * (np.pi / 4 - 0.5))  # a quarter of a circle as one cubic of just its area: 1/2 + 3k/5 - 3k^2/20 = pi/4
QUARTER = np.array([(1, 0), (1, KAPPA), (KAPPA, 1)])
CIRCLE = np.concatenate([QUARTER, QUARTER[:, ::-1] * (-1, 1), -QUARTER, QUARTER[:, ::-1] * (1, -1)])


def contents(path: Path) -> bytes:
    """The bytes of a file from outside; a folder, a pipe or a device is a ValueError, and so is one over the limit."""
    if (size := regular(path)) > LIMIT:
        raise ValueError(f"{path}: {size / 2**20:.0f} MB is over the limit of {LIMIT / 2**20:.0f} MB; make it smaller")
    return path.read_bytes()


def regular(path: Path) -> int:
    """The size of a file in bytes; a folder, a pipe or a device is a ValueError."""
    facts = path.stat()
    if not stat.S_ISREG(facts.st_mode):
        raise ValueError(f"{path}: is {'a folder' if stat.S_ISDIR(facts.st_mode) else 'not a regular file'}; give a file")
    return facts.st_size


def elements(data: bytes, name: str) -> Iterator[Any]:
    """Every element of an SVG file in the order of the file, from the root.

    Raises ValueError for what is not sound XML, declares entities, or is too large or too deep.
    """
    if len(data) > LIMIT:
        raise ValueError(f"{name}: {len(data) / 2**20:.0f} MB is over the limit of {LIMIT / 2**20:.0f} MB; make it smaller")
    if re.search(rb"<\0?!\0?E\0?N\0?T\0?I\0?T\0?Y", data, re.IGNORECASE):  # in any encoding
        raise ValueError(f"{name}: declares entities, which are not read; save it as plain SVG")
    depth = 0
    root: Any = None
    try:
        for event, element in ElementTree.iterparse(io.BytesIO(data), events=("start", "end")):
            root = element if root is None else root
            depth += 1 if event == "start" else -1
            if depth > DEPTH:
                raise ValueError(f"{name}: elements are nested over {DEPTH} deep; save it as plain SVG")
    except ElementTree.ParseError as error:
        raise ValueError(f"{name}: not sound SVG ({error}); save it again") from None
    if root is None or local(root) != "svg":
        raise ValueError(f"{name}: not an SVG file; give one")
    every: Iterator[Any] = root.iter()
    return every


def local(element: Any) -> str:
    """The element's name without its namespace."""
    return str(element.tag).rsplit("}", 1)[-1]


def shapes(data: bytes, name: str, *, most: int = COPIES) -> tuple[tuple[float, float], list[tuple[Paths, Any]]]:
    """The page's size in mm, and each shape's subpaths as Paths with the shape itself, in drawing order.

    Groups' transforms are applied, arcs and quadratic curves become cubics, lines too where
    a shape has any curve. Open and closed subpaths come apart. Text, clips and pictures are not read.
    Raises ValueError for lengths and transforms that are none, and for over `most` elements, copies by <use> counted.
    """
    import svgelements

    every = list(elements(data, name))
    for element in every:
        for key in LENGTHS & set(element.attrib) if local(element) in SHAPES else ():
            length = re.fullmatch(rf"\s*({NUMBER})\s*(mm|cm|in|pt|pc|px|%)?\s*", element.get(key))
            if not length or (key in SIZES and float(length[1]) < 0):
                raise ValueError(f"{name}: {key}={element.get(key)[:40]!r} is not a length; mend it")
        transform = element.get("transform", "") if local(element) in SHAPES | {"g", "a", "switch"} else ""
        if not TRANSFORM.fullmatch(transform):
            raise ValueError(f"{name}: transform={transform[:40]!r} is not a transform; mend it")
    if (count := _copies(every[0], {element.get("id"): element for element in every}, {})) > most:
        if np.isinf(count):
            raise ValueError(f"{name}: a <use> in it is a loop: it draws itself; mend it")
        raise ValueError(f"{name}: draws {count:.0f} elements, copies counted, over the limit of {most}; save it with fewer")
    found: list[tuple[Paths, Any]] = []
    try:
        svg = svgelements.SVG.parse(io.BytesIO(_put_away(every)), ppi=96)
        size = (float(svg.width or 0) * PX, float(svg.height or 0) * PX)
        for shape in svg.elements():
            if isinstance(shape, svgelements.Shape) and not any(shape.values.get(key) == value for key, value in HIDDEN):
                found += [(paths, shape) for paths in _round(shape) or _subpaths(shape)]
        for paths, _ in found:
            if np.abs(paths.xy).max(initial=0.0) > FURTHEST:
                raise ValueError("it lies over a kilometre off")
    except (ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RecursionError) as error:
        raise ValueError(f"{name}: a shape in it cannot be read ({_cause(error)}); save it as plain SVG") from None
    return size, found


def _put_away(every: list[Any]) -> bytes:
    """The file with all that is not drawn where it stands in <defs>, as it should be."""
    root = every[0]
    space = root.tag[: root.tag.rfind("}") + 1]
    aside = ElementTree.Element(f"{space}defs")
    for parent in every:
        for child in [child for child in parent if local(child) in UNDRAWN]:
            parent.remove(child)
            aside.append(child)
    root.append(aside)
    return ElementTree.tostring(root)


def _copies(element: Any, named: dict[str, Any], known: dict[int, float]) -> float:
    """How many elements a renderer would meet, copies by <use> counted as often as they are made; without end in a circle."""
    if id(element) not in known:
        known[id(element)] = np.inf  # until it is known: who comes back here goes round in a circle
        used = (
            named.get(next((v for k, v in element.items() if k.rsplit("}", 1)[-1] == "href"), "")[1:]) if local(element) == "use" else None
        )
        parts = [*element, *([used] if used is not None else [])]
        known[id(element)] = 1 + sum(_copies(part, named, known) for part in parts)
    return known[id(element)]


def _cause(error: Exception) -> str:
    """The first line of an error's text, or its kind."""
    return (str(error).splitlines() or [type(error).__name__])[0][:80]


def canvas(data: bytes, name: str, size: tuple[float, float]) -> shapely.Geometry:
    """The area that the closed shapes of an SVG file enclose, its page laid over a rectangle of this size in mm.

    Shapes lying inside others are holes, as by the even-odd rule. Raises ValueError where nothing is enclosed.
    """
    page, found = shapes(data, name)
    fine = 1e-4 * max(page)  # of the page: a tenth of a millimetre on the side of a square metre
    rings = [ring for paths, _ in found if paths.closed and fine for ring in paths.flat(fine) if len(ring) > 2]
    area = shapely.Polygon()
    for ring in rings:
        area = shapely.symmetric_difference(area, shapely.make_valid(shapely.Polygon(ring)))
    parts = [part for part in shapely.get_parts(area) if part.geom_type == "Polygon" and part.area > 0]
    if not parts or min(page) <= 0:
        raise ValueError(f"{name}: encloses no area; draw a closed outline on a page the shape of the picture")
    scale = np.array(size) / page
    return shapely.transform(shapely.union_all(parts), lambda xy: xy * scale)


def _round(shape: Any) -> list[Paths]:
    """A circle or an ellipse as four cubics, in mm, none for other shapes: of 100 000 each would take 1 ms by way of its arcs."""
    import svgelements

    if not isinstance(shape, (svgelements.Circle, svgelements.Ellipse)) or not (0 < shape.rx < np.inf and 0 < shape.ry < np.inf):
        return []
    matrix = shape.transform
    x, y = float(shape.cx) + float(shape.rx) * CIRCLE[:, 0], float(shape.cy) + float(shape.ry) * CIRCLE[:, 1]
    xy = np.stack([matrix.a * x + matrix.c * y + matrix.e, matrix.b * x + matrix.d * y + matrix.f], axis=1)
    return [Paths.of([xy * PX], cubic=True)]


def _subpaths(shape: Any) -> list[Paths]:
    """Closed and open subpaths of a shape of svgelements, each kind as one Paths, in mm."""
    import svgelements

    path = abs(svgelements.Path(shape))
    path.approximate_arcs_with_cubics()
    curved = any(isinstance(s, (svgelements.CubicBezier, svgelements.QuadraticBezier)) for s in path)
    rings: dict[bool, list[Array]] = {True: [], False: []}
    for sub in path.as_subpaths():
        points: list[complex] = []
        closed = False
        for segment in sub:
            a, b = segment.start, segment.end
            closed = closed or isinstance(segment, svgelements.Close)
            if isinstance(segment, svgelements.Move) or not points:
                points = [complex(b)]
            elif not isinstance(segment, svgelements.Close) or complex(b) != complex(a):
                points += _controls(segment, a, b) if curved else []
                points.append(complex(b))
        if closed and len(points) > 1 and points[0] == points[-1]:
            points.pop()
        xy = np.array([(p.real * PX, p.imag * PX) for p in points])
        if len(xy) > (1 if not closed else 2):
            rings[closed].append(xy)
    return [Paths.of(found, closed=closed, cubic=curved) for closed, found in rings.items() if found]


def _controls(segment: Any, a: Any, b: Any) -> list[complex]:
    """The two inner points of a segment as a cubic."""
    import svgelements

    start, end = complex(a), complex(b)
    if isinstance(segment, svgelements.CubicBezier):
        return [complex(segment.control1), complex(segment.control2)]
    if isinstance(segment, svgelements.QuadraticBezier):
        middle = complex(segment.control)
        return [start + (middle - start) * 2 / 3, end + (middle - end) * 2 / 3]
    return [start + (end - start) / 3, end - (end - start) / 3]
