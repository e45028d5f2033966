"""What objects of a library put on the paper: marks, areas and lines, their ink, and where they overlap."""

from __future__ import annotations

from dataclasses import replace
from functools import reduce

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import raster
from crowquill.inertia import drawn
from crowquill.marks import Marks
from crowquill.objects import Objects, Shape
from crowquill.paths import Array, Index, Paths
from crowquill.shapes import Motif
from crowquill.sheet import Ink, Layer

TOUCH = 1e-6  # mm^2; what two share less of is rounding

Motifs = tuple[Motif, ...]


def of_each(objects: Objects, motifs: Motifs, pen: float) -> Array:
    """The ink of each object, mm^2, its lines with a round pen of so many mm and no overlap taken off, (n,)."""
    found = np.zeros(len(objects))
    for k, motif in enumerate(motifs):
        found[objects.shape == k] = motif.ink(objects.scale[objects.shape == k], pen)
    return found


def length(objects: Objects, motifs: Motifs) -> float:
    """How long objects are in the mean, mm; 0 where there are none."""
    across = np.array([motif.across for motif in motifs])[objects.shape] * objects.scale
    return float(across.mean()) if len(across) else 0.0


def given(objects: Objects, motifs: Motifs, pen: float, ink: Array, least: float) -> Objects:
    """The objects where they are, each as large as so much ink (n,) mm^2 makes it, but no smaller than the scale `least`."""
    scale = np.zeros(len(objects))
    for k, motif in enumerate(motifs):
        scale[objects.shape == k] = motif.scale_of(ink[objects.shape == k], pen)
    return replace(objects, scale=np.maximum(scale, least))


def layers(objects: Objects, motifs: Motifs, pen: float) -> tuple[Layer, ...]:
    """Marks for objects of one outline; areas, and lines of a pen in mm, for others. One layer at least, empty where there is nothing."""
    single = np.array([motif.glyph is not None for motif in motifs], bool)
    part, rest = objects.take(single[objects.shape]), objects.take(~single[objects.shape])
    scale = part.scale * np.sqrt([motif.area for motif in motifs])[part.shape]
    glyphs = tuple(motif.glyph for motif in motifs if motif.glyph is not None)
    marks = Marks.of(part.xy, glyphs, scale=scale, angle=part.angle, glyph=(np.cumsum(single) - 1)[part.shape])
    areas, _ = replace(rest, shapes=tuple(Shape(motif.rings, 0.0, 1) for motif in motifs)).rings()
    lines, _ = replace(rest, shapes=tuple(Shape(motif.lines, 0.0, 1) for motif in motifs)).lines()
    every = Layer(Ink(), marks, "objects"), Layer(Ink(), areas, "areas"), Layer(Ink(pen=pen), lines, "lines")
    return tuple(layer for layer in every if len(layer.art)) or every[:1]


def covered(objects: Objects, motifs: Motifs, pen: float, size: tuple[float, float], grid: tuple[int, int]) -> Array:
    """The share of each pixel of a grid (h, w) over a size in mm that objects cover."""
    h, w = grid
    found = np.zeros(grid)
    for layer in layers(objects, motifs, pen):
        found += raster.covered(layer.art, grid, pixel=(size[0] / w, size[1] / h), pen=layer.ink.pen)
    return np.minimum(found, 1)


def overlaps(objects: Objects, motifs: Motifs, pen: float) -> tuple[int, float]:
    """How many pairs of objects overlap, and the ink that falls on ink by it, mm^2."""
    prints = footprints(objects, motifs, pen)
    i, j = shapely.STRtree(prints).query(prints, predicate="intersects")
    i, j = i[i < j], j[i < j]
    over = shapely.area(shapely.intersection(prints[i], prints[j])) > TOUCH
    crowd = prints[np.unique([i[over], j[over]])]
    return int(over.sum()), float(shapely.area(crowd).sum() - shapely.area(shapely.union_all(crowd)))


def footprints(objects: Objects, motifs: Motifs, pen: float) -> npt.NDArray[np.object_]:
    """What each object inks as a shapely geometry, (n,)."""
    found = np.full(len(objects), shapely.Polygon(), dtype=object)
    for k, motif in enumerate(motifs):
        which = np.flatnonzero(objects.shape == k)
        for paths in (motif.rings, motif.lines):
            if len(which) and len(paths):
                found[which] = shapely.union(found[which], _copies(objects, which, paths, pen))
    return found


def _copies(objects: Objects, which: Index, paths: Paths, pen: float) -> npt.NDArray[np.object_]:
    """Paths of a motif at the places of some objects, each as one geometry."""
    own = reduce(shapely.symmetric_difference, paths.polygons()) if paths.closed else drawn(paths)  # holes lie inside rings
    xy = shapely.get_coordinates(own)
    owner = np.repeat(which, len(xy))
    placed = objects.placed(np.tile(xy, (len(which), 1)) * objects.scale[owner][:, None], owner)
    copies = shapely.set_coordinates(np.full(len(which), own, dtype=object), placed)
    return np.asarray(copies if paths.closed else shapely.buffer(copies, pen / 2))
