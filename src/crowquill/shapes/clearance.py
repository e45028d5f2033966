"""Objects that keep clear of one another: how large they may be where they lie, and where they go to make room.

Their convex hulls stand for them. Two hulls are apart along a side of one of them, or along the line between their centres; scaled
down about its own centre, a hull stays on its side.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.kernel import compiled
from crowquill.objects import Objects
from crowquill.paths import Array, Index, Paths
from crowquill.shapes import Motif

# What convex objects cover side by side that are this much as broad as an ellipse of their length is long; measured on ramps.
BREADTH = (0.15, 0.45)
PACKED = (0.55, 0.72)
GROWN = 8  # rounds in which what has room left takes it; more brought nothing
HALVED = 12  # times: to a four-thousandth of the size


def packed(motifs: tuple[Motif, ...], scale: float, pen: float) -> float:
    """The coverage that objects reach side by side: that of their convex hulls, less what these hold of white."""
    hulls = [shapely.multipoints(motif.hull * scale).convex_hull.buffer(pen / 2 if len(motif.lines) else 0) for motif in motifs]
    rooms = sum(hull.area for hull in hulls)
    broad = rooms / (np.pi / 4 * sum((motif.across * scale) ** 2 for motif in motifs))
    return float(np.interp(broad, BREADTH, PACKED) * min(1.0, sum(motif.ink(scale, pen) for motif in motifs) / rooms))


def pairs(objects: Objects, skirt: float) -> Index:
    """Two by two the objects whose circles of reach come as near as skirt mm, (m, 2), sorted."""
    from scipy.spatial import cKDTree

    far = np.array([np.hypot(*shape.paths.xy.T).max() for shape in objects.shapes])[objects.shape] * objects.scale
    if len(objects) < 2:
        return np.zeros((0, 2), np.int64)
    found = cKDTree(objects.xy).query_pairs(2 * far.max() + skirt, output_type="ndarray").astype(np.int64)
    found = found[np.hypot(*(objects.xy[found[:, 0]] - objects.xy[found[:, 1]]).T) < far[found].sum(axis=1) + skirt]
    return np.asarray(found[np.lexsort((found[:, 1], found[:, 0]))])


def pushed(objects: Objects, skirt: float) -> Array:
    """Where objects go that are nearer than skirt mm: half of what they lack each, along the way that parts them soonest; (n, 2) mm."""
    near = pairs(objects, skirt)
    rest, _, _, way = _contacts(near, objects, skirt)
    push = way * np.minimum(rest, 0.0)[:, None] / 2
    sums = [np.bincount(near[:, 0], part, len(objects)) - np.bincount(near[:, 1], part, len(objects)) for part in push.T]
    return np.stack(sums, axis=1)


def clear(objects: Objects, skirt: float) -> Array:
    """Scales (n,), at most the objects' own, at which all are skirt mm apart; 0 for what lies on another's centre.

    Two in each other's way are first scaled down alike; then those that got less than they asked for grow as long as others leave room.
    """
    near, n = pairs(objects, skirt), len(objects)
    rest, a, b, _ = _contacts(near, objects, skirt)
    share = np.clip(1 + rest / np.maximum(a + b, 1e-12), 0, 1)
    fits = np.ones(n)
    for side in near.T:
        np.minimum.at(fits, side, share)
    scale = objects.scale * fits
    for _ in range(GROWN):
        hungry = scale < objects.scale * (1 - 1e-3)
        if not hungry.any():
            break
        rest, a, b, _ = _contacts(near, replace(objects, scale=np.maximum(scale, 1e-9)), skirt)
        rest = np.maximum(rest, 0) / np.maximum(hungry[near].sum(axis=1), 1)
        room = np.full(n, np.inf)
        for side, reach in zip(near.T, (a, b), strict=True):
            np.minimum.at(room, side, rest / np.maximum(reach, 1e-12))
        scale = np.where(hungry, np.minimum(objects.scale, scale * (1 + 0.999 * room)), scale)
    return scale


def held(objects: Objects, canvas: shapely.Geometry, skirt: float) -> Array:
    """Scales (n,), at most the objects' own, at which their hulls lie in the canvas, skirt mm from its outline."""
    inner = shapely.buffer(canvas, -skirt) if skirt else canvas
    shapely.prepare(inner)
    scale = objects.scale.copy()
    out = np.flatnonzero(~shapely.covers(inner, hulls(objects)))
    low, high = np.zeros(len(out)), np.ones(len(out))
    for _ in range(HALVED if len(out) else 0):
        middle = (low + high) / 2
        part = objects.take(out)
        good = shapely.covers(inner, hulls(replace(part, scale=part.scale * middle)))
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    scale[out] *= low
    return scale


def brought_in(objects: Objects, canvas: shapely.Geometry) -> Array:
    """The way (n, 2) mm by which the corner of its hull that is furthest outside the canvas comes onto its outline."""
    way = np.zeros((len(objects), 2))
    shapes, owner = objects.rings()
    for paths, of in ((shapes, owner), objects.lines()):
        points, who = paths.xy, of[paths.path]
        out = np.flatnonzero(~shapely.intersects_xy(canvas, *points.T))
        ends = shapely.get_coordinates(shapely.shortest_line(shapely.points(points[out]), canvas)).reshape(-1, 2, 2)
        step = ends[:, 1] - ends[:, 0]
        order = np.argsort(np.hypot(*step.T), kind="stable")
        way[who[out[order]]] = step[order]  # the longest last
    return way


def hulls(objects: Objects) -> npt.NDArray[np.object_]:
    """Each object's hull as a shapely geometry, (n,)."""
    rings, of = objects.rings()
    lines, whose = objects.lines()
    found = np.full(len(objects), shapely.Point(), dtype=object)
    found[of] = rings.polygons()
    if len(lines):
        found[whose] = shapely.linestrings(lines.xy, indices=lines.path)
    return found


def _contacts(near: Index, objects: Objects, skirt: float) -> tuple[Array, Array, Array, Array]:
    """For each pair how far apart hulls are beyond the skirt, mm, less than 0 where they are nearer; how far each hull reaches towards
    the other, and the direction (m, 2) from the first to the second along which that is so."""
    hull = Paths.of([shape.paths.xy for shape in objects.shapes])
    m = len(near)
    rest, a, b, way = np.empty(m), np.empty(m), np.empty(m), np.empty((m, 2))
    _parted(near, objects.xy, objects.angle, objects.scale, objects.shape, hull.xy, hull.start, skirt, rest, a, b, way)
    return rest, a, b, way


@compiled
def _parted(
    near: Index, xy: Array, angle: Array, scale: Array, shape: Index, hull: Array, start: Index, skirt: float,
    rest: Array, a: Array, b: Array, way: Array,
) -> None:  # fmt: skip
    """Fills what _contacts() gives, of all directions that at which hulls could grow most before they meet."""
    for k in range(len(near)):
        i, j = near[k]
        dx, dy = xy[j, 0] - xy[i, 0], xy[j, 1] - xy[i, 1]
        best = -np.inf
        ni, nj = start[shape[i] + 1] - start[shape[i]], start[shape[j] + 1] - start[shape[j]]
        for side in range(ni + nj + 1):
            if side == ni + nj:
                ux, uy = dx, dy
            else:
                owner, first, n, at = (i, start[shape[i]], ni, side) if side < ni else (j, start[shape[j]], nj, side - ni)
                p, q = hull[first + at], hull[first + (at + 1) % n]
                cos, sin = np.cos(angle[owner]), np.sin(angle[owner])
                ex, ey = cos * (q[0] - p[0]) - sin * (q[1] - p[1]), sin * (q[0] - p[0]) + cos * (q[1] - p[1])
                ux, uy = -ey, ex
            long = np.sqrt(ux * ux + uy * uy)
            ux, uy = (ux / long, uy / long) if long > 0 else (1.0, 0.0)
            far = ux * dx + uy * dy
            if far < 0:
                ux, uy, far = -ux, -uy, -far
            hi = _reach(hull, start[shape[i]], ni, angle[i], ux, uy) * scale[i]
            hj = _reach(hull, start[shape[j]], nj, angle[j], -ux, -uy) * scale[j]
            share = (far - skirt) / max(hi + hj, 1e-12)
            if share > best:
                best = share
                rest[k], a[k], b[k], way[k, 0], way[k, 1] = far - skirt - hi - hj, hi, hj, ux, uy


@compiled
def _reach(hull: Array, first: int, n: int, angle: float, ux: float, uy: float) -> float:
    """How far a hull at scale 1, turned by an angle, reaches from its centre in a direction."""
    cos, sin = np.cos(angle), np.sin(angle)
    vx, vy = cos * ux + sin * uy, cos * uy - sin * ux
    far = 0.0
    for k in range(first, first + n):
        far = max(far, hull[k, 0] * vx + hull[k, 1] * vy)
    return far
