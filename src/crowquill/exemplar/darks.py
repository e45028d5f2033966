"""Where marks turn white: areas of black, their edge made clean, and the white marks cut out of them.

What is a pixel's matter in the published method is one of outlines here: parts of black and of white that no mark fits in go.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from contourpy import FillType, contour_generator
from scipy import ndimage
from scipy.special import ndtr

from crowquill.marks import Marks
from crowquill.paths import Paths
from crowquill.tone import Tone

FLAT = 4e-3  # of a mark's diameter that straight pieces may stray
COARSE = 0.02  # of it that the areas' edge may stray
FINE = 0.5  # of a mark's diameter: the grid on which the edge is sought, where pixels are larger
HAIR = 0.05  # of a mark's diameter: black no wider than twice that is a hairline
APART = 2e-3  # mm, of rings
BLOT = 1.2  # of a mark's diameter: the blur of the chance that decides
ROUND = 0.5  # of a mark's diameter: what is narrower is no area, and no gap in one
LEAST = 0.25  # of a mark: smaller pieces of black, and smaller holes, go
ARC = 4  # pieces to a quarter of a turn


def area(tone: Tone, turnover: tuple[float, float], diameter: float, rng: np.random.Generator) -> shapely.Geometry:
    """The part of the canvas where marks are white on black, without parts and gaps narrower than a mark of this diameter.

    Between the two coverages of the turnover it is black where chance has it so, in blots a few marks wide, more of them the
    darker it is: as the published method chooses between two tones, but not pixel by pixel.
    """
    if not (tone.coverage > turnover[0]).any():
        return shapely.MultiPolygon()
    pixel = [min(side, FINE * diameter) for side in tone.pixel]
    w, h = (int(np.ceil(side / own)) + 2 for side, own in zip(tone.size, pixel, strict=True))
    x, y = (np.arange(w) - 0.5) * tone.size[0] / (w - 2), (np.arange(h) - 0.5) * tone.size[1] / (h - 2)
    at = np.meshgrid(y / tone.pixel[1] - 0.5, x / tone.pixel[0] - 0.5, indexing="ij")
    asked = ndimage.map_coordinates(tone.coverage, at, order=1, mode="nearest")
    chance = ndimage.gaussian_filter(rng.standard_normal((h, w)), [BLOT * diameter / side for side in reversed(pixel)])
    share = ndtr(chance / max(float(chance.std()), 1e-12))
    asked -= turnover[0] + (turnover[1] - turnover[0]) * share
    found: Any = contour_generator(x, y, asked, fill_type=FillType.OuterOffset).filled(0, 2.0)
    rings = [[part[a:b] for a, b in pairwise(start)] for part, start in zip(*found, strict=True)]
    whole = shapely.union_all([shapely.make_valid(shapely.Polygon(first, rest)) for first, *rest in rings])
    r = ROUND * diameter
    for by in (-r, 2 * r, -r):
        whole = shapely.buffer(whole, by, quad_segs=ARC)
    return _polygons(shapely.intersection(shapely.simplify(whole, COARSE * diameter), tone.canvas))


def cut(black: shapely.Geometry, white: Marks, mark: float) -> shapely.Geometry:
    """Areas of black without white marks; no piece of less than a quarter of a black mark's area, no hole of less than one of a white's.

    Hairlines between white marks, and between them and the edge, go: no pen draws and no press prints them. Rings keep two
    micrometres apart, so that none cross once they are snapped to whole ones.
    """
    if black.is_empty:
        return black
    whole = shapely.difference(black, _prints(white))
    hair = HAIR * 2 * float(np.sqrt(mark / np.pi))
    whole = shapely.buffer(shapely.buffer(whole, -hair, join_style="mitre"), hair, quad_segs=ARC)
    whole = shapely.buffer(shapely.buffer(whole, -1.5 * APART, join_style="mitre"), APART, join_style="mitre")
    kept = [part for part in shapely.get_parts(whole) if part.geom_type == "Polygon" and part.area >= LEAST * mark]
    return shapely.MultiPolygon([filled(part, LEAST * float((white.scale**2).mean()) if len(white) else 0.0) for part in kept])


def _prints(marks: Marks) -> shapely.Geometry:
    """What marks cover together."""
    return shapely.union_all(marks.outlines().flat(FLAT * float(marks.scale.mean())).polygons()) if len(marks) else shapely.Polygon()


def overlap(black: shapely.Geometry, marks: Marks) -> float:
    """The area of black that marks lie on, mm^2."""
    if not len(marks) or black.is_empty:
        return 0.0
    tree = shapely.STRtree(marks.outlines().flat(FLAT * float(marks.scale.mean())).polygons())
    parts = shapely.get_parts(black)
    part, mark = tree.query(parts, predicate="intersects")
    return sum(
        float(shapely.area(shapely.intersection(parts[k], shapely.union_all(tree.geometries[mark[part == k]])))) for k in np.unique(part)
    )


def rings(black: shapely.Geometry) -> Paths:
    """Areas as rings, their holes turning the other way."""
    return Paths.of([]) if black.is_empty else Paths.of_polygons(black)[0]


def filled(polygon: shapely.Polygon, least: float) -> shapely.Polygon:
    """A polygon without its holes of less than an area."""
    inner = shapely.get_rings(polygon)[1:]
    large = shapely.area(shapely.polygons(inner)) >= least if len(inner) else np.zeros(0, bool)
    return shapely.Polygon(polygon.exterior, list(inner[large])) if not large.all() else polygon


def _polygons(shape: shapely.Geometry) -> shapely.Geometry:
    """The parts of a geometry that have an area."""
    return shapely.MultiPolygon([part for part in shapely.get_parts(shape) if part.geom_type == "Polygon" and part.area > 0])
