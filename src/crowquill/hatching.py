"""Solid areas as the strokes of a pen: a ring half a nib inside the outline, and lines there and back within it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.kernel import compiled
from crowquill.paths import Array, Index, Paths

FLAT = 0.01  # mm that a stroke may stray from its curve
SHORTEST = 0.02  # mm: plotting programs drop strokes of no length, and a coarse machine may lose shorter ones
PITCH = 0.95  # nibs between lines: at 1 white shows where they are rounded to micrometres
FINE = 1 / 200  # of a nib: how far a ring may stray from the outline
LEFT = 0.25  # square nibs: parts of an area too fine for its ring are drawn by themselves from this size on
FULL = 0.35  # of its box that a narrow area fills to be drawn as one stroke: tips, bars and triangles do, letters do not


def areas(paths: Paths, nib: float) -> list[Array]:
    """Strokes (k, 2) that draw solid areas by the nonzero rule: rings inside outlines, holes left open, lines along the long axis.

    What is narrower than the nib is one stroke along it, or, where it bends, a thin loop; it comes out as wide as the nib.
    Paths without area draw nothing.
    """
    solid = shapely.get_parts(covered(paths.flat(min(FLAT, nib / 50))))
    solid = solid[shapely.area(solid) > 0]
    inner = shapely.simplify(shapely.buffer(solid, -nib / 2), nib * FINE)
    narrow = shapely.is_empty(inner)
    left = shapely.get_parts(shapely.difference(solid[~narrow], shapely.buffer(inner[~narrow], nib / 2 * 1.02)))
    left = left[(shapely.get_type_id(left) == shapely.GeometryType.POLYGON) & (shapely.area(left) > LEFT * nib**2)]
    found: list[Array] = []
    for part in shapely.get_parts(inner[~narrow]):
        found += hatched(part, nib, _long_axis(part)[0])
    for part in [*solid[narrow], *left]:
        found += _thin(part, nib)
    return found


def hatched(inner: shapely.Polygon, nib: float, angle: float = 0.0) -> list[Array]:
    """Strokes there and back at an angle inside an area, and the rings around it, each going on from a stroke that ends there.

    Lines run to the ring itself: a place further than half a nib from it then is that near to a line.
    """
    cos, sin = np.cos(angle), np.sin(angle)
    area = shapely.transform(inner, lambda xy: np.stack([cos * xy[:, 0] + sin * xy[:, 1], cos * xy[:, 1] - sin * xy[:, 0]], axis=1))
    low, high = area.bounds[1::2]
    gaps = int(np.ceil((high - low) / (PITCH * nib)))
    y = low + (high - low) * np.arange(1, gaps) / max(gaps, 1)
    rings = [area.exterior, *area.interiors]
    found = _there_and_back(_cuts(rings, y), y, shapely.buffer(area, nib / 50))
    open_ends = list(range(len(found)))
    for ring in rings:
        meets = next((k for k in open_ends if ring.distance(shapely.Point(found[k][-1])) < 1e-6), None)
        if meets is None:
            found.append(shapely.get_coordinates(ring))
        else:
            found[meets] = np.concatenate([found[meets], _from(ring, found[meets][-1])])
            open_ends.remove(meets)
    return [np.stack([cos * s[:, 0] - sin * s[:, 1], sin * s[:, 0] + cos * s[:, 1]], axis=1) for s in found]


def _cuts(rings: list[shapely.LinearRing], y: Array) -> list[list[tuple[float, float]]]:
    """The pieces of each level line inside rings, by rising x."""
    a, b = (np.concatenate([shapely.get_coordinates(ring)[part] for ring in rings]) for part in (slice(-1), slice(1, None)))
    found = []
    for level in y.tolist():
        side = (a[:, 1] <= level) != (b[:, 1] <= level)
        (ax, ay), (bx, by) = a[side].T, b[side].T
        x = np.sort(ax + (level - ay) / (by - ay) * (bx - ax)).tolist()
        found.append([(lo, hi) for lo, hi in zip(x[::2], x[1::2], strict=True) if hi > lo])
    return found


def _there_and_back(rows: list[list[tuple[float, float]]], y: Array, room: shapely.Geometry) -> list[Array]:
    """Pieces of level lines joined from row to row; a way to the next row that leaves the room is a lift of the pen."""
    shapely.prepare(room)
    found = []
    for first, row in enumerate(rows):
        while row:
            stroke = [(x, y[first]) for x in row.pop(0)]
            for k in range(first + 1, len(rows)):
                ends = [(abs(x - stroke[-1][0]), i, end) for i, cut in enumerate(rows[k]) for end, x in enumerate(cut)]
                if not ends:
                    break
                _, i, end = min(ends)
                near, far = rows[k][i][end], rows[k][i][1 - end]
                if not room.covers(shapely.LineString([stroke[-1], (near, y[k])])):
                    break
                del rows[k][i]
                stroke += [(near, y[k]), (far, y[k])]
            found.append(np.array(stroke))
    return found


def _from(ring: shapely.LinearRing, at: Array) -> Array:
    """The points of a ring from the one nearest to a place all round to it again."""
    points = shapely.get_coordinates(ring)
    along = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    k = int(np.searchsorted(along, ring.project(shapely.Point(at)), side="right"))
    return np.concatenate([points[k:], points[1:k], [at]])


def _thin(area: shapely.Polygon, nib: float) -> list[Array]:
    """What stands for an area narrower than the nib: one stroke along it, or loops close to its middle where it bends or has holes."""
    _, long, short = _long_axis(area)
    if not area.interiors and area.area > FULL * long * short:
        return [_along(area, nib)]
    half = area.area / area.length  # of its mean width
    for depth in (0.8 * half, 0.4 * half, 0.0):
        inner = shapely.simplify(shapely.buffer(area, -depth), nib * FINE)
        if not inner.is_empty and inner.area > 0 and inner.length > 0.7 * area.length:
            return [shapely.get_coordinates(ring) for part in shapely.get_parts(inner) for ring in (part.exterior, *part.interiors)]
    return [shapely.get_coordinates(ring) for ring in (area.exterior, *area.interiors)]


def _along(area: shapely.Polygon, nib: float) -> Array:
    """The stroke through an area's centroid along its long axis, as far as a nib's ends stay inside."""
    m = Paths.of([shapely.get_coordinates(area.exterior)]).green()[0]
    x, y = m[1:3] / m[0]
    angle = 0.5 * float(np.arctan2(2 * (m[4] / m[0] - x * y), m[3] / m[0] - x * x - m[5] / m[0] + y * y))
    middle = shapely.get_coordinates(area.exterior)[0] + (x, y)
    far = area.length * np.array([np.cos(angle), np.sin(angle)])
    chord = shapely.get_coordinates(shapely.LineString([middle - far, middle + far]).intersection(area))
    if len(chord) < 2:
        return tick(middle, angle, SHORTEST)
    return tick((chord[0] + chord[-1]) / 2, angle, float(np.hypot(*(chord[-1] - chord[0]))) - nib)


def tick(at: Array | tuple[float, float], angle: float, length: float) -> Array:
    """A stroke about a place, no shorter than the least that plotting programs draw."""
    half = max(length, SHORTEST) / 2 * np.array([np.cos(angle), np.sin(angle)])
    return np.array([at - half, at + half])


def _long_axis(area: shapely.Polygon) -> tuple[float, float, float]:
    """The angle, length and breadth of the smallest box around an area."""
    box = shapely.get_coordinates(shapely.minimum_rotated_rectangle(area))
    if len(box) < 5:
        box = shapely.get_coordinates(shapely.box(*area.bounds))
    sides = np.diff(box[:3], axis=0)
    length = np.hypot(*sides.T)
    k = int(length.argmax())
    return float(np.arctan2(sides[k, 1], sides[k, 0])), float(length[k]), float(length[1 - k])


def covered(paths: Paths) -> npt.NDArray[np.object_]:
    """The areas that straight paths fill by the nonzero rule, those that touch joined into one.

    Paths whose boxes meet no others are looked at by themselves.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    paths = paths.take(np.flatnonzero(np.diff(paths.start) > 2))
    if not len(paths):
        return np.empty(0, object)
    low, high = (f.reduceat(paths.xy, paths.start[:-1]) for f in (np.minimum, np.maximum))
    boxes = shapely.box(*low.T, *high.T)
    one, other = shapely.STRtree(boxes).query(boxes)
    group = connected_components(coo_array((np.ones(len(one)), (one, other)), (len(paths), len(paths))), directed=False)[1]
    rings = paths.polygons()
    alone = (np.bincount(group)[group] == 1) & shapely.is_valid(rings)
    crowd = paths.take(np.flatnonzero(~alone))
    if not len(crowd):
        return np.asarray(rings[alone])
    borders = shapely.linearrings(crowd.xy, indices=crowd.path)
    faces = shapely.get_parts(shapely.polygonize(shapely.get_parts(shapely.node(shapely.multilinestrings(borders)))))
    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    face, ring = shapely.STRtree(shapely.box(*shapely.bounds(borders).T)).query(shapely.points(inside))
    winding = np.zeros(len(faces), np.int64)
    _wind(crowd.xy, crowd.start, inside, face, ring, winding)
    return np.concatenate([rings[alone], shapely.get_parts(shapely.union_all(faces[winding != 0]))])


@compiled
def _wind(xy: Array, start: Index, at: Array, place: Index, ring: Index, winding: Index) -> None:
    """Adds to each place how often a ring goes round it, for each pair of a place and a ring."""
    for k in range(len(place)):
        x, y = at[place[k], 0], at[place[k], 1]
        begin, end = start[ring[k]], start[ring[k] + 1]
        ax, ay = xy[end - 1, 0], xy[end - 1, 1]
        for i in range(begin, end):
            bx, by = xy[i, 0], xy[i, 1]
            if (ay <= y) != (by <= y) and ax + (y - ay) / (by - ay) * (bx - ax) > x:
                winding[place[k]] += 1 if by > ay else -1
            ax, ay = bx, by
