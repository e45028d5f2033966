"""What a press or a pen can draw of shapes and lines: outlines without necks and slits too fine, and dashes of one pen's width."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from crowquill.kernel import compiled, shared_out
from crowquill.paths import Array, Index, Paths

NOTHING = 1e-9  # mm^2: slivers of which rounding leaves nothing
FINE = 5e-4  # mm that a simplified outline may stray, half of what files keep: round outlines lose a little by it
ROUNDED = 0.002  # mm more than asked: sides end in whole micrometres
ARC = 4  # sides to a quarter of a rounded corner
CELL = 8  # pens, in which a line thinner than the pen has one dash
FAINTEST = 0.25  # of the pen: a line of this width has dashes of two pens, ends and all, and a thinner one none
SHORT = 0.25  # pens that a dash is drawn along at the least: a pen set down without moving may leave nothing
ROUND = np.pi / 4  # pens squared: what the two round ends of a stroke add to it
GOLDEN = 0.6180339887498949  # of a cell from line to line: dashes of no two neighbours lie alike


def polygons(paths: Paths) -> Any:
    """Outlines, each with the holes behind it, as valid shapely polygons."""
    paths = paths.take(np.flatnonzero((np.diff(paths.start) > 2) & (np.abs(paths.areas) > NOTHING)))
    if not len(paths):
        return np.zeros(0, object)
    rings = shapely.linearrings(paths.xy, indices=paths.path)
    first = np.append(np.flatnonzero(paths.areas > 0), len(paths))
    ends = np.append(0, np.cumsum(shapely.get_num_coordinates(rings)))
    found = shapely.from_ragged_array(shapely.GeometryType.POLYGON, shapely.get_coordinates(rings), (ends, first))
    crossed = ~shapely.is_valid(found)  # corners that touch
    found[crossed] = shapely.make_valid(found[crossed], method="structure", keep_collapsed=False)
    return found


def cut(shapes: Any, canvas: shapely.Geometry) -> Any:
    """The polygons that a canvas leaves of shapes, without lines and points."""
    shapely.prepare(canvas)
    shapes = np.array(shapes, object)
    out = ~shapely.contains_properly(canvas, shapes)
    shapes[out] = shapely.intersection(shapes[out], canvas)
    parts = shapely.get_parts(shapely.get_parts(shapes))
    return parts[(shapely.get_type_id(parts) == shapely.GeometryType.POLYGON) & (shapely.area(parts) > 0)]


def clipped(paths: Paths, canvas: shapely.Geometry) -> Paths:
    """Outlines, each with the holes behind it, cut at a canvas."""
    return Paths.of_polygons(cut(polygons(paths), canvas))[0]


def cut_strokes(strokes: Paths, canvas: shapely.Geometry) -> Paths:
    """Strokes cut at a canvas."""
    lines = shapely.linestrings(strokes.xy, indices=strokes.path)
    parts = shapely.get_parts(shapely.intersection(lines, canvas))
    parts = shapely.get_parts(parts[shapely.length(parts) > 0])
    xy, line = shapely.get_coordinates(parts, return_index=True)
    return Paths(xy, np.concatenate([[0], np.cumsum(np.bincount(line, minlength=len(parts)))]), closed=False)


def opened(shapes: Any, min_line: float, min_gap: float) -> tuple[Any, Any]:
    """Polygons without what is narrower than min_line mm, and those with what is white and narrower than min_gap filled too.

    Shapes that touch or overlap are one. A length of 0 changes nothing; corners sharper than right angles are cut off.
    """
    line, gap = ((length + ROUNDED) / 2 if length else 0 for length in (min_line, min_gap))
    kept = shapely.union_all(shapes)
    if line:
        kept = shapely.buffer(shapely.buffer(kept, -line, join_style="mitre"), line, quad_segs=ARC)
    filled = kept
    if gap:
        filled = shapely.buffer(shapely.buffer(kept, gap, join_style="mitre"), -gap, quad_segs=ARC)
    return shapely.get_parts(kept), shapely.get_parts(filled)


def dashes(place: Array, step: float, share: Array, pen: float, stagger: float) -> Array:
    """Where strokes of a pen begin and end along a line thinner than it, (n, 2) mm: together they have the line's ink.

    place    (m,) along the line, a step apart, in mm, and share (m,) of the pen that the line takes for half a step to either side
    stagger  where cells of dashes lie, in cells
    gives    in each cell a stroke in its middle, whose ends stay a pen apart from the next; none where less than half a dot
             is asked for, and strokes run on where less than half a dot is white
    """
    low, high = place[0] - step / 2, place[-1] + step / 2
    cell = CELL * pen
    inner = (np.arange(np.floor(low / cell - stagger), np.ceil(high / cell - stagger) + 1) + stagger) * cell
    edge = np.concatenate([[low], inner[(inner > low + cell / 2) & (inner < high - cell / 2)], [high]])
    total = np.concatenate([[0], np.cumsum(share)]) * step
    asked, side = np.diff(np.interp(edge, low + step * np.arange(len(total)), total)), np.diff(edge)
    length = np.minimum(np.maximum(asked - ROUND * pen, SHORT * pen), side - pen)
    solid = (side - asked < (1 - ROUND) / 2 * pen) | (length <= 0)
    length = np.where(solid, side, length)
    middle = (edge[:-1] + edge[1:]) / 2
    drawn = asked >= (ROUND + SHORT) / 2 * pen
    begin, end = (middle - length / 2)[drawn], (middle + length / 2)[drawn]
    apart = np.append(True, begin[1:] > end[:-1] + pen / 2)[: len(begin)]
    return np.stack([begin[apart], end[np.append(apart[1:], True)[: len(end)]]], axis=1)


def simplified(paths: Paths) -> Paths:
    """The same straight paths with fewer points: none left out is further than FINE mm from the side that takes its place."""
    kept = np.zeros(len(paths.xy), bool)
    shared_out(lambda lo, hi: _kept(paths.xy, paths.start, FINE, kept, lo, hi), len(paths), 512)
    start = np.concatenate([[0], np.cumsum(kept)])[paths.start]
    return Paths(paths.xy[kept], start, paths.closed)


@compiled
def _kept(xy: Array, start: Index, fine: float, kept: Array, lo: int, hi: int) -> None:
    """Marks the points to keep of paths lo to hi: from each on, the next is the last that a straight side reaches past all between.

    The side's direction has to stay within a cone that every point passed narrows. A cone that is open to both sides holds all.
    """
    for path in range(lo, hi):
        begin, end = start[path], start[path + 1]
        if begin == end:
            continue
        anchor = begin
        kept[begin] = kept[end - 1] = True
        low, high, middle, far, none = 0.0, 0.0, 0.0, 0.0, True
        k = begin + 1
        while k < end:
            dx, dy = xy[k, 0] - xy[anchor, 0], xy[k, 1] - xy[anchor, 1]
            length = np.hypot(dx, dy)
            turn = np.arctan2(dy, dx) - middle
            turn -= 2 * np.pi * np.round(turn / (2 * np.pi))
            if not none and (turn < low or turn > high or length < far - fine):
                anchor = k - 1 if k - 1 > anchor else k
                kept[anchor] = True
                none, far = True, 0.0
                k = anchor + 1
                continue
            far = max(far, length)
            if length > fine:
                room = np.arcsin(fine / length)
                if none:
                    middle, low, high, none = middle + turn, -room, room, False
                else:
                    low, high = max(low, turn - room), min(high, turn + room)
            k += 1
