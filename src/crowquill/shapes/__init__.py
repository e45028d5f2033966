"""Libraries of objects: SVG files of shapes that are placed as wholes. One file is one library."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from functools import cached_property, reduce
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import shapely

from crowquill.hatching import covered
from crowquill.inertia import drawn, fold_of, long_axis, of_sides, pooled
from crowquill.marks import THIN, Glyph
from crowquill.moments import of_rings
from crowquill.objects import Shape
from crowquill.paths import Array, Paths
from crowquill.shapes import foreign
from crowquill.vector import contents, elements, local, shapes

FOLDER = Path(__file__).parent
Part = tuple[Paths, Any, bool]  # of an object: paths, their shape, and whether they are filled

FLAT = 3e-4  # of an object's extent: what straight pieces of its curves may stray
COARSE = 3e-3  # and its hull, outwards only: fewer corners make room sooner
STANDING = "data-standing-"  # and a number: an attribute that says of which elements of the file a shape comes
MOST = 2_000  # elements, copies counted: each takes some 3 ms
ROUNDING = 1e-12  # of its extent squared: areas below are rounding
NAMED = 3  # of what is left out


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
    everything are looked through. A closed shape is filled, by its own fill rule; an open one, or one that its file does not
    fill, is drawn as a line. All is black, and lines are as wide as the pen; text, pictures, clips, gradients and filters are not
    read, and of style sheets plain rules are. `notes` name what is not read or heeded, and what is left out because it draws
    nothing: without area and length, without fill and stroke, or hidden.
    Raises ValueError for an unknown name, a file that draws nothing or over MOST elements, an object too thin for an
    area, a script or a link to another file; OSError where it cannot be read.
    """
    path = FOLDER / f"{source}.svg" if str(source) in names() else Path(source)
    if path.suffix.lower() != ".svg":
        raise ValueError(f"no objects {str(source)!r}; there are {', '.join(names())}, or the path of an SVG file")
    return parsed(contents(path), str(source))


def parsed(data: bytes, name: str) -> Library:
    """The library in the bytes of an SVG file; errors call it `name`."""
    every = list(elements(data, name))
    foreign.refuse(data, every, name)
    choice = foreign.chosen(every)
    for k, element in enumerate(foreign.objects(every[0])):
        element.set("data-object", str(k))  # what is inside inherits it
    standing = list(foreign.standing(every[0]))
    for k, element in enumerate(standing):
        element.set(f"{STANDING}{k}", "")
    parts: dict[str, list[Part]] = {}
    words: set[str] = set()
    for paths, shape in shapes(ElementTree.tostring(every[0]), name, most=MOST)[1]:
        filled, stroked = foreign.paint(shape)
        if (filled or stroked) and np.ptp(paths.xy, axis=0).max() > 0:
            parts.setdefault(str(shape.values.get("data-object", "")), []).append((paths, shape, filled))
            words |= foreign.unheeded(shape, paths.closed)
    motifs, seen = [], set()
    for k, part in enumerate(parts.values(), 1):
        called = next((str(shape.id) for _, shape, _ in part if shape.id), str(k))[:40]
        try:
            motif = _motif(part)
        except ValueError as error:
            raise ValueError(f"{name}: object {called!r} {error}") from None
        if motif is not None:
            motifs.append(motif)
            seen |= {key for _, shape, _ in part for key in shape.values if key.startswith(STANDING)}
    unseen = _unseen(standing, seen)
    if not motifs:
        raise ValueError(f"{name}: {unseen or 'has no shapes'}; draw the objects in it as paths")
    about = _about(every, name)
    said = dict.fromkeys(note for motif in motifs for note in motif.notes)
    unread = [*foreign.unread(every), *(["choices of a switch"] if choice else [])]
    notes = [
        *([f"{name}: its {', '.join(unread)} are not read; objects are drawn without"] if unread else []),
        *([f"{name}: its {', '.join(sorted(words))} are not heeded; all is drawn in black with one pen"] if words else []),
        *([f"{name}: {unseen}; left out"] if unseen else []),
        *said,
    ]
    return Library(str(about.get("name", name)), tuple(motifs), about, tuple(notes))


def _unseen(standing: list[Any], seen: set[str]) -> str:
    """Of which elements of a file nothing is seen, by their ids or as which of the shapes they are; empty where all are."""
    rest = [(k, element) for k, element in enumerate(standing) if f"{STANDING}{k}" not in seen]
    called = [repr(element.get("id")[:40]) if element.get("id") else f"shape {k + 1} (<{local(element)}>)" for k, element in rest]
    more = f" and {len(rest) - NAMED} more" if len(rest) > NAMED else ""
    return f"nothing is seen of {', '.join(called[:NAMED])}{more}: no area or length, no fill or stroke, or hidden" if rest else ""


def _about(every: list[Any], name: str) -> dict[str, Any]:
    """What the file says of its library in its <library> element; nothing where it has none."""
    try:
        about = json.loads(next((element.text or "{}" for element in every if local(element) == "library"), "{}"))
    except (ValueError, RecursionError):
        about = None
    if not isinstance(about, dict):
        raise ValueError(f"{name}: its metadata is not a JSON object; mend or remove its <library> element")
    return about


def _motif(parts: list[Part]) -> Motif | None:
    """The object of all paths of its shapes, None where they have neither area nor length. Raises ValueError where it is too thin."""
    extent = float(np.ptp(np.concatenate([paths.xy for paths, _, _ in parts]), axis=0).max())
    flat = [(paths.flat(FLAT * extent), fill) for paths, _, fill in parts]
    winding = [str(shape.values.get("fill-rule", "")).strip().lower() != "evenodd" for _, shape, _ in parts]
    whole, crossed = _filled([(paths, rule) for (paths, fill), rule in zip(flat, winding, strict=True) if paths.closed and fill])
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
        if not of_sides(lines).mass.sum() > 0 and shapely.area(whole) > ROUNDING * extent**2:
            raise ValueError(f"is too thin for an area ({shapely.area(whole):.3g} mm2 at {extent:.3g} mm); draw it as a line")
        whole = shapely.Polygon()
        if not of_sides(lines).mass.sum() > 0:
            return None
    rings, _ = Paths.of_polygons(np.array([whole], dtype=object))
    masses = of_rings(rings) if len(rings) else of_sides(lines)
    start = rings.xy[:1] if len(rings) else lines.xy[:1]
    mass = pooled(masses, np.zeros(len(masses.mass), np.int64), 1, start)
    notes = ("an outline crosses itself; what its fill rule fills was outlined anew",) if crossed else ()
    art = [paths.moved(np.eye(2), -mass.centroid[0]) for paths in (rings, lines)]
    outlines = drawn(art[0] if len(rings) else art[1])
    axis = turn = long_axis(outlines, mass.covariance)
    sole = [paths for paths, _, _ in parts if paths.closed]
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


def _filled(filled: list[tuple[Paths, bool]]) -> tuple[shapely.Geometry, bool]:
    """The area that closed shapes cover together, by winding or else even-odd, and whether an outline crosses itself."""
    found, crossed = [], False
    for paths, winding in filled:
        rings = paths.polygons()
        sound = bool(shapely.is_valid(rings).all())
        crossed |= not sound
        wound = winding and not (sound and len(rings) == 1)  # of one sound ring both rules give the same
        found.append(shapely.union_all(covered(paths)) if wound else reduce(shapely.symmetric_difference, shapely.make_valid(rings)))
    parts = shapely.get_parts(shapely.union_all(found)) if found else np.array([], dtype=object)
    return shapely.union_all(parts[shapely.get_type_id(parts) == shapely.GeometryType.POLYGON]), crossed


def _turn(outline: Paths) -> float:
    """By what angle Glyph.of turned an outline back."""
    unit = Glyph.of(outline).paths.xy
    own = outline.xy - of_rings(outline).centroid[0]
    own = own if outline.areas[0] >= 0 else np.roll(own[::-1], 1, axis=0)
    ahead, here = unit @ (1, 1j), own @ (1, 1j)
    return float(np.angle((here * ahead.conj()).sum()))
