"""Libraries of objects: SVG files of shapes that are placed as wholes. One file is one library."""

from __future__ import annotations

import json
import os
import re
from dataclasses import dataclass
from functools import cached_property, reduce
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import shapely

from crowquill.inertia import drawn, fold_of, long_axis, of_sides, pooled
from crowquill.marks import THIN, Glyph
from crowquill.moments import of_rings
from crowquill.objects import Shape
from crowquill.paths import Array, Paths
from crowquill.vector import contents, elements, local, shapes

FOLDER = Path(__file__).parent
FLAT = 3e-4  # of an object's extent: what straight pieces of its curves may stray
COARSE = 3e-3  # and its hull, outwards only: fewer corners make room sooner
GROUPS = {"g", "svg", "a", "switch", "use"}
SHAPES = {"path", "rect", "circle", "ellipse", "line", "polygon", "polyline"}
# What is not read, by the word that says so in a warning; the second lot are attributes.
UNREAD = {
    **dict.fromkeys(("text", "tspan", "textPath", "foreignObject"), "text"),
    **{"image": "pictures", "clipPath": "clips", "mask": "masks", "filter": "filters", "pattern": "patterns", "marker": "markers"},
    **dict.fromkeys(("linearGradient", "radialGradient", "meshgradient"), "gradients"),
    **dict.fromkeys(("animate", "animateTransform", "animateMotion", "set"), "animation"),
    "style": "style sheets",
}
UNREAD_OF = {"clip-path": "clips", "mask": "masks", "filter": "filters"}


@dataclass(frozen=True, eq=False)
class Motif:
    """An object about its centre of mass with its long axis on x, in mm as large as it was drawn.

    glyph  its outline, where one closed line is all it is; else None, and what is drawn are
    rings  (straight, holes turning back) that are filled, and open `lines` of a pen
    hull   (k, 2) the corners of the convex hull of all of it
    turn   rad, how it lay in its file
    axis   rad, of what passes for its long axis where inertia knows none, else 0; fold, how often in a full turn it looks the same
    notes  what is to be said of how it was read
    """

    glyph: Glyph | None
    rings: Paths
    lines: Paths
    hull: Array
    turn: float
    axis: float
    fold: int
    notes: tuple[str, ...] = ()

    @cached_property
    def area(self) -> float:
        """mm^2 that the rings enclose."""
        return np.pi / 4 * self.glyph.size**2 if self.glyph else float(self.rings.areas.sum())

    @cached_property
    def length(self) -> float:
        """mm of all open lines."""
        return float(of_sides(self.lines).mass.sum())

    @cached_property
    def across(self) -> float:
        """The greatest distance between two of its points, mm."""
        return float(max(np.hypot(*(self.hull - corner).T).max() for corner in self.hull))

    @cached_property
    def shape(self) -> Shape:
        """The hull, not quite closely, as what settles: regions keep clear of bays, into which nothing would fit."""
        if len(self.hull) < 3:
            return Shape(Paths.of([self.hull], closed=False), self.axis, self.fold)
        slack = COARSE * self.across
        around = shapely.buffer(shapely.simplify(shapely.Polygon(self.hull), slack - FLAT * self.across), slack, join_style="mitre")
        return Shape(Paths.of([shapely.get_coordinates(around)[:-1]]), self.axis, self.fold)

    def ink(self, scale: Any, pen: float) -> Any:
        """mm^2 of ink at a scale, or at each of several, its lines drawn with a round pen of so many mm and crossing nothing."""
        return self.area * scale**2 + self.length * pen * scale + len(self.lines) * np.pi / 4 * pen**2

    def scale_of(self, ink: Any, pen: float) -> Any:
        """The scale at which it has so much ink, or as near as its lines' ends alone let it come: then 0."""
        rest = np.maximum(ink - len(self.lines) * np.pi / 4 * pen**2, 0.0)
        half = self.length * pen / 2
        return rest / np.maximum(half + np.sqrt(half**2 + self.area * rest), np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class Library:
    """Objects and what is known of them: how they were made, licence; `notes` are what is to be said of the file."""

    name: str
    motifs: tuple[Motif, ...]
    about: dict[str, Any]
    notes: tuple[str, ...] = ()


def names() -> list[str]:
    """The libraries that come with the package, sorted."""
    return sorted(path.stem for path in FOLDER.glob("*.svg"))


def load(source: str | os.PathLike[str]) -> Library:
    """The library of a name from names(), or of an SVG file by its path.

    Each shape is an object, and so is each outermost group, whatever it holds; layers of Inkscape and a lone group around
    everything are looked through. A closed shape is filled, by the even-odd rule; an open one, or one that its file does not
    fill, is drawn as a line. Colours and widths are not read; text, pictures, clips, gradients, filters and style sheets are
    named in `notes`. Raises ValueError for an unknown name and a file without shapes, with an object that has
    neither area nor length, with a script or a link to another file; OSError where it cannot be read.
    """
    path = FOLDER / f"{source}.svg" if str(source) in names() else Path(source)
    if path.suffix.lower() != ".svg":
        raise ValueError(f"no objects {str(source)!r}; there are {', '.join(names())}, or the path of an SVG file")
    return parsed(contents(path), str(source))


def parsed(data: bytes, name: str) -> Library:
    """The library in the bytes of an SVG file; errors call it `name`."""
    every = list(elements(data, name))
    _refuse_foreign(every, name)
    for k, element in enumerate(_objects(every[0])):
        element.set("data-object", str(k))  # what is inside inherits it
    parts: dict[str, list[tuple[Paths, Any]]] = {}
    for paths, shape in shapes(ElementTree.tostring(every[0]), name)[1]:
        parts.setdefault(str(shape.values.get("data-object", "")), []).append((paths, shape))
    if not parts:
        raise ValueError(f"{name}: has no shapes; draw the objects in it as paths")
    motifs = []
    for k, part in enumerate(parts.values(), 1):
        called = next((str(shape.id) for _, shape in part if shape.id), str(k))[:40]
        try:
            motifs.append(_motif(part))
        except ValueError as error:
            raise ValueError(f"{name}: object {called!r} {error}") from None
    about = _about(every, name)
    said = dict.fromkeys(note for motif in motifs for note in motif.notes)
    unread = _unread(every)
    notes = [*([f"{name}: its {', '.join(unread)} are not read; objects are drawn without"] if unread else []), *said]
    return Library(str(about.get("name", name)), tuple(motifs), about, tuple(notes))


def _about(every: list[Any], name: str) -> dict[str, Any]:
    """What the file says of its library in its <library> element; nothing where it has none."""
    try:
        about = json.loads(next((element.text or "{}" for element in every if local(element) == "library"), "{}"))
    except (ValueError, RecursionError):
        about = None
    if not isinstance(about, dict):
        raise ValueError(f"{name}: its metadata is not a JSON object; mend or remove its <library> element")
    return about


def _refuse_foreign(every: list[Any], name: str) -> None:
    """Raises ValueError for scripts and for links to other files: nothing is run and nothing fetched."""
    for element in every:
        if local(element) == "script" or any(key.lower().startswith("on") for key in element.attrib):
            raise ValueError(f"{name}: has a script; save it as plain SVG")
        links = [value for key, value in element.items() if key.rsplit("}", 1)[-1] == "href" and local(element) not in ("a", "script")]
        rules = [element.get("style", ""), element.text or "" if local(element) == "style" else "", element.get("fill", "")]
        links += [link for rule in rules for link in re.findall(r"(?:url\(|@import)\s*['\"]?([^'\")\s]+)", rule)]
        for link in links:
            if not link.strip().startswith(("#", "data:")):
                raise ValueError(f"{name}: refers to another file ({link[:40]!r}); put what it draws into this one")


def _objects(root: Any) -> list[Any]:
    """The elements that are one object each."""
    parts = [child for child in root if local(child) in SHAPES | GROUPS]
    if len(parts) == 1 and local(parts[0]) in GROUPS - {"use"}:
        return _objects(parts[0])
    layered = [any(key.endswith("groupmode") and value == "layer" for key, value in part.items()) for part in parts]
    return [one for part, layer in zip(parts, layered, strict=True) for one in (_objects(part) if layer else [part])]


def _unread(every: list[Any]) -> list[str]:
    """The words for what a file has and is not read, in the order of the table."""
    found = {UNREAD.get(local(element)) for element in every}
    found |= {word for element in every for key, word in UNREAD_OF.items() if element.get(key, "none") != "none"}
    found |= {"gradients" for element in every if "url(#" in element.get("fill", "") + element.get("style", "")}
    return [word for word in dict.fromkeys([*UNREAD.values(), *UNREAD_OF.values()]) if word in found]


def _motif(parts: list[tuple[Paths, Any]]) -> Motif:
    """The object of all paths of its shapes. Raises ValueError where they have neither area nor length."""
    extent = float(np.ptp(np.concatenate([paths.xy for paths, _ in parts]), axis=0).max())
    if not extent > 0:
        raise ValueError("has neither area nor length; remove it")
    flat = [(paths.flat(FLAT * extent), str(shape.values.get("fill")).strip() != "none") for paths, shape in parts]
    filled = [paths for paths, fill in flat if paths.closed and fill]
    whole, crossed = _filled(filled)
    lines = Paths.of(
        [
            np.concatenate([path, path[:1]]) if paths.closed else path
            for paths, fill in flat
            if not (paths.closed and fill)
            for path in paths
        ],
        closed=False,
    )
    if shapely.area(whole) <= THIN * extent**2:
        whole = shapely.Polygon()
        if not of_sides(lines).mass.sum() > 0:
            raise ValueError("has neither area nor length; remove it")
    rings, _ = Paths.of_polygons(np.array([whole], dtype=object))
    masses = of_rings(rings) if len(rings) else of_sides(lines)
    start = rings.xy[:1] if len(rings) else lines.xy[:1]
    mass = pooled(masses, np.zeros(len(masses.mass), np.int64), 1, start)
    notes = ("an outline crosses itself; it was split where it does",) if crossed else ()
    art = [paths.moved(np.eye(2), -mass.centroid[0]) for paths in (rings, lines)]
    outlines = drawn(art[0] if len(rings) else art[1])
    axis = turn = long_axis(outlines, mass.covariance)
    sole = [paths for paths, _ in parts if paths.closed]
    glyph = None
    if len(rings) == 1 and not len(lines):
        outline = sole[0].curved() if len(sole) == 1 and len(sole[0]) == 1 and not crossed else rings.curved()
        glyph, turn = Glyph.of(outline), _turn(outline)
    cos, sin = np.cos(turn), np.sin(turn)
    rings, lines = (paths.moved([[cos, sin], [-sin, cos]]) for paths in art)
    hull = shapely.convex_hull(shapely.multipoints(np.concatenate([rings.xy, lines.xy])))
    corners = shapely.get_coordinates(hull)
    around = corners[:-1] if len(corners) > 2 else corners
    return Motif(glyph, rings, lines, around, turn, axis - turn, fold_of(outlines, mass.covariance), notes)


def _filled(filled: list[Paths]) -> tuple[shapely.Geometry, bool]:
    """The area that closed shapes cover together, each by the even-odd rule, and whether an outline crosses itself."""
    found, crossed = [], False
    for paths in filled:
        rings = paths.polygons()
        crossed |= not bool(shapely.is_valid(rings).all())
        found.append(reduce(shapely.symmetric_difference, shapely.make_valid(rings)))
    parts = shapely.get_parts(shapely.union_all(found)) if found else np.array([], dtype=object)
    return shapely.union_all(parts[shapely.get_type_id(parts) == shapely.GeometryType.POLYGON]), crossed


def _turn(outline: Paths) -> float:
    """By what angle Glyph.of turned an outline back."""
    unit = Glyph.of(outline).paths.xy
    own = outline.xy - of_rings(outline).centroid[0]
    own = own if outline.areas[0] >= 0 else np.roll(own[::-1], 1, axis=0)
    ahead, here = unit @ (1, 1j), own @ (1, 1j)
    return float(np.angle((here * ahead.conj()).sum()))
