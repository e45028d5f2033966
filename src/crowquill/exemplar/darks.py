"""Where marks turn white: areas of black, their edge made clean, and the white marks cut out of them.

What is a pixel's matter in the published method is one of outlines here: parts of black and of white that no mark fits in go.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
import shapely
from contourpy import FillType, contour_generator
from scipy import ndimage, sparse
from scipy.special import ndtr

from crowquill.marks import Marks
from crowquill.paths import Array, Paths
from crowquill.tone import Tone

FLAT = 0.01  # of a mark's diameter that straight pieces may stray
COARSE = 0.02  # of it that the areas' edge may stray
FINE = 0.5  # of a mark's diameter: the grid on which the edge is sought, where pixels are larger
HAIR = 0.05  # of a mark's diameter: black no wider than twice that is a hairline
APART = 2e-3  # mm, of rings
SNAP = 1e-3  # mm: a sheet's lengths are whole micrometres
BLOT = 2.5  # of a mark's diameter: the blur of the chance that decides
ROUND = 1.0  # of a mark's diameter: what is narrower than twice that is no area, and no gap in one
FEWEST = 8.0  # marks: the least area, and the least gap in one
INSET, BEADS, STRAY = 0.35, 0.5, 0.25  # of a mark's diameter: how far areas keep back from their edge, and marks lie along it and about it
NEAR = 0.5  # of it: black marks so near to an area become one with it
LEAST = 0.25  # of a mark: smaller pieces of black, and smaller holes, go
ARC = 4  # pieces to a quarter of a turn


@dataclass(frozen=True, eq=False)
class Ground:
    """Where marks are white on black: `whole` is where the black ones end and white ones may lie, `core` what is inked all over."""

    whole: shapely.Geometry
    core: shapely.Geometry


def ground(tone: Tone, turnover: tuple[float, float], diameter: float, rng: np.random.Generator) -> Ground:
    """The part of the canvas where marks are white on black, and no part nor gap of it is small beside marks of this diameter.

    Between the two coverages of the turnover it is black where chance has it so, in blots a few marks wide, more of them the
    darker it is: as the published method chooses between two tones, but not pixel by pixel. The core keeps back from the edge,
    for marks to lie there, but not from that of the canvas, which cuts all.
    """
    if not (tone.coverage > turnover[0]).any():
        return Ground(*(shapely.MultiPolygon(),) * 2)
    found: Any = contour_generator(*_asked(tone, turnover, diameter, rng), fill_type=FillType.OuterOffset).filled(0, 2.0)
    rings = [[part[a:b] for a, b in pairwise(start)] for part, start in zip(*found, strict=True)]
    whole = shapely.union_all([shapely.make_valid(shapely.Polygon(first, rest)) for first, *rest in rings])
    r = ROUND * diameter
    for by in (-r, 2 * r, -r):
        whole = shapely.buffer(whole, by, quad_segs=ARC)
    least = FEWEST * np.pi / 4 * diameter**2
    whole = _large(shapely.simplify(whole, COARSE * diameter), least, least)
    parts = whole, shapely.buffer(whole, -INSET * diameter, quad_segs=ARC)
    return Ground(*(_large(shapely.intersection(part, tone.canvas)) for part in parts))


def _asked(tone: Tone, turnover: tuple[float, float], diameter: float, rng: np.random.Generator) -> tuple[Array, Array, Array]:
    """What is asked for over a coverage by chance, (h, w), on a grid (w,) and (h,) mm that reaches over the tone's sides."""
    over = 3 * ROUND * diameter  # nothing done to areas inside is felt further
    step = min(*tone.pixel, FINE * diameter)
    x, y = (np.arange(-over, side + over + step, step) for side in tone.size)
    at = np.meshgrid(y / tone.pixel[1] - 0.5, x / tone.pixel[0] - 0.5, indexing="ij")
    asked = ndimage.map_coordinates(tone.coverage, at, order=1, mode="nearest")
    chance = ndimage.gaussian_filter(rng.standard_normal(asked.shape), BLOT * diameter / step)
    share = ndtr(chance / max(float(chance.std()), 1e-12))
    return x, y, asked - turnover[0] - (turnover[1] - turnover[0]) * share


def beads(core: shapely.Geometry, canvas: shapely.Geometry, diameter: float, rng: np.random.Generator) -> Array:
    """Places (n, 2) mm for marks about the edge of areas, so that it is one of marks; none where it is the canvas's own."""
    lines = shapely.get_parts(shapely.boundary(core))
    which = np.repeat(np.arange(len(lines)), np.ceil(shapely.length(lines) / (BEADS * diameter)).astype(int))
    points = shapely.line_interpolate_point(lines[which], rng.random(len(which)), normalized=True)
    xy = shapely.get_coordinates(points[shapely.distance(points, canvas.boundary) > diameter])
    return np.asarray(xy + rng.normal(0, STRAY * diameter, xy.shape))


def cut(core: shapely.Geometry, edge: Marks, white: Marks, mark: float) -> shapely.Geometry:
    """Areas of black, and black marks at their edge, without white marks, in whole micrometres: rings may touch but never cross.

    No piece has less than a quarter of a black mark's area, no hole less than one of a white's. Hairlines between white marks, and
    between them and the edge, go: no pen draws and no press prints them.
    """
    black = shapely.union_all([core, *_outlines(edge)], grid_size=SNAP)
    hair = HAIR * 2 * float(np.sqrt(mark / np.pi))
    grown = shapely.buffer(_outlines(white), hair, quad_segs=ARC)
    groups = _groups(grown)
    outer = shapely.intersects(groups, shapely.buffer(shapely.boundary(black), hair, quad_segs=ARC))
    # a gap between marks that closes when they grow was a hairline of black: the same as to shrink the black around them
    inner = shapely.buffer(groups[~outer], APART / 2 - hair, quad_segs=ARC)
    whole = shapely.difference(shapely.buffer(black, -hair, join_style="mitre"), shapely.union_all(groups[outer]), grid_size=SNAP)
    whole = shapely.buffer(shapely.buffer(whole, hair, quad_segs=ARC), -APART / 2, join_style="mitre")
    # those are apart: grown by a hair they do not meet
    whole = shapely.difference(whole, shapely.multipolygons(shapely.get_parts(inner)), grid_size=SNAP)
    return _large(whole, LEAST * mark, LEAST * float((white.scale**2).mean()) if len(white) else 0.0)


def _outlines(marks: Marks) -> npt.NDArray[np.object_]:
    """Marks as polygons (n,)."""
    return np.asarray(marks.outlines().flat(FLAT * float(marks.scale.mean())).polygons() if len(marks) else [], object)


def _groups(shapes: npt.NDArray[np.object_]) -> npt.NDArray[np.object_]:
    """Unions of those shapes that touch one another, (k,)."""
    one, other = shapely.STRtree(shapes).query(shapes, predicate="intersects")
    graph = sparse.coo_array((np.ones(len(one), bool), (one, other)), (len(shapes), len(shapes)))
    count, group = sparse.csgraph.connected_components(graph, directed=False)
    order = np.argsort(group, kind="stable")
    parts = np.split(shapes[order], np.searchsorted(group[order], np.arange(1, count)))
    return np.array([part[0] if len(part) == 1 else shapely.union_all(part) for part in parts[:count]], object)


def overlap(black: shapely.Geometry, marks: Marks) -> float:
    """The area of black that marks lie on, mm^2."""
    if not len(marks) or black.is_empty:
        return 0.0
    tree = shapely.STRtree(_outlines(marks))
    parts = shapely.get_parts(black)
    part, mark = tree.query(parts, predicate="intersects")
    return sum(
        float(shapely.area(shapely.intersection(parts[k], shapely.union_all(tree.geometries[mark[part == k]])))) for k in np.unique(part)
    )


def rings(black: shapely.Geometry) -> Paths:
    """Areas as rings, their holes turning the other way."""
    return Paths.of([]) if black.is_empty else Paths.of_polygons(black)[0]


def _large(shape: shapely.Geometry, least: float = 0.0, hole: float = 0.0) -> shapely.Geometry:
    """The parts of a geometry that have an area of over `least`, without their holes of less than `hole`."""
    found = shapely.get_parts(shape)
    return shapely.MultiPolygon([filled(part, hole) for part in found if part.geom_type == "Polygon" and part.area > least])


def filled(polygon: shapely.Polygon, least: float) -> shapely.Polygon:
    """A polygon without its holes of less than an area."""
    inner = shapely.get_rings(polygon)[1:]
    large = shapely.area(shapely.polygons(inner)) >= least if len(inner) else np.zeros(0, bool)
    return shapely.Polygon(polygon.exterior, list(inner[large])) if not large.all() else polygon
