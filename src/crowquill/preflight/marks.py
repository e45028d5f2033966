"""How small a drawing's marks are: dots, lines, and the white between them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.paths import Array, Index
from crowquill.preflight.drawing import Art
from crowquill.preflight.nearest import nearest

MOST = 300_000  # marks whose gaps are all measured; of more a sample is
PAIRS = 3_000_000  # of neighbours measured at most
LOT = 8192  # pieces looked at together at most
HITS = 500_000  # of neighbours looked at together, about
PIECE = 64  # sides of an outline measured together
TOUCH = 1e-4  # mm: nearer outlines touch
Flags = npt.NDArray[np.bool_]
Shapes = npt.NDArray[np.object_]


@dataclass(frozen=True, eq=False)
class Measured:
    """The sizes of a drawing's marks, in mm, and where each lies, (x, y).

    dots   diameters of circles of the areas of compact outlines, and pens of strokes no longer than wide
    lines  widths of strokes, 0 for hairlines, and mean widths of long outlines
    gaps   white below what was asked for between neighbouring marks, and widths of holes in them
    share  of the marks, 0 to 1, whose gaps were measured
    """

    dots: Array
    dots_at: Array
    lines: Array
    lines_at: Array
    gaps: Array
    gaps_at: Array
    share: float


@lru_cache(maxsize=2)
def measured(art: Art, reach: float) -> Measured:
    """All sizes of the marks of a drawing, and all gaps below `reach` mm. Paint as white as the paper makes no mark.

    White inside one outline that winds is not measured, nor what white paint leaves of a mark.
    """
    inked = np.array([not colour.white for colour in art.colours] + [False])
    area, length, pen = np.abs(art.area), art.lengths, art.pen[art.thing]
    filled = inked[art.fill[art.thing]] & (area > 0)
    drawn = inked[art.stroke[art.thing]] & ((length > 0) | art.round[art.thing])  # a point has ink with round caps alone
    hole, outer = holes(art, filled)
    round_, width = shape(area, length)
    width = np.where(round_, 2 * np.sqrt(area / np.pi), width) + np.where(drawn, pen, 0)
    solid = filled & ~hole
    spot = drawn & ~filled & (length <= pen) & (pen > 0)
    stroke = drawn & ~filled & ~spot
    width = np.where(filled, width, pen)
    middle = art.boxes[:, :2] / 2 + art.boxes[:, 2:] / 2
    dot, line = (solid & round_) | spot, (solid & ~round_) | stroke
    narrow = hole & (width < reach)
    gaps, gaps_at, share = between(art, solid | (drawn & ~filled), hole, outer, np.where(drawn, pen / 2, 0), reach)
    return Measured(
        width[dot],
        middle[dot],
        width[line],
        middle[line],
        np.concatenate([width[narrow], gaps]),
        np.concatenate([middle[narrow], gaps_at]),
        share,
    )


def shape(area: Array, length: Array) -> tuple[Flags, Array]:
    """Whether outlines are compact, and how wide they are where they are not: as a rectangle of that area and outline is.

    A square is the last compact one: of a rectangle of sides w and l the outline p is 2 (w + l) and the area a is w l, so that w
    is (p / 2 - sqrt(p^2 / 4 - 4 a)) / 2.
    """
    rest = length**2 / 4 - 4 * area
    return rest <= 1e-9 * length**2, (length / 2 - np.sqrt(np.maximum(rest, 0))) / 2


def holes(art: Art, filled: Flags) -> tuple[Flags, Index]:
    """Which outlines are holes in what their thing fills, (n,), and the outline that each is a hole in, or else itself.

    By the rule of the thing: inside, the windings of all its outlines add to nothing, or an even number of them do.
    """
    found, outer = np.zeros(len(art), bool), np.arange(len(art))
    sign = np.sign(art.area).astype(np.int64)
    turns = [np.bincount(art.thing[filled & (sign == turn)], minlength=len(art.fill)) for turn in (-1, 1)]
    holed = ((turns[0] > 0) & (turns[1] > 0)) | (art.evenodd & (turns[0] + turns[1] > 1))
    which = np.flatnonzero(filled & holed[art.thing])
    if not len(which):
        return found, outer
    rings = art.outlines.take(which).polygons()
    inner, around = shapely.STRtree(rings).query(shapely.points(art.outlines.xy[art.outlines.start[which]]), predicate="within")
    area = np.abs(art.area[which])
    same = (art.thing[which[inner]] == art.thing[which[around]]) & (area[inner] < area[around])
    inner, around = inner[same], around[same]
    wound = sign[which] + np.bincount(inner, sign[which[around]], len(which))
    depth = 1 + np.bincount(inner, minlength=len(which))
    open_ = np.where(art.evenodd[art.thing[which]], depth % 2 == 0, wound == 0)
    found[which] = open_
    solid = open_[inner] & ~open_[around]
    inner, around = inner[solid], around[solid]
    order = np.argsort(-area[around], kind="stable")  # the smallest around comes last, and stays
    outer[which[inner[order]]] = which[around[order]]
    return found, outer


def between(art: Art, solid: Flags, hole: Flags, outer: Index, half: Array, reach: float) -> tuple[Array, Array, float]:
    """The white gaps below `reach` mm between different marks, (g,) mm, their middles (g, 2), and the share of marks looked at.

    half  (n,) mm that the pen adds to each outline on both sides

    A gap is the least distance of two marks' borders where no third mark lies between. Of more than MOST marks, and of
    more than PAIRS neighbours, marks are drawn by lot, the same ones each time.
    """
    chosen = np.flatnonzero(solid | hole)
    xy, start, owner = _pieces(art, chosen)
    pieces = shapely.linestrings(xy, indices=np.repeat(np.arange(len(owner)), np.diff(start)))
    bounds = shapely.bounds(pieces)
    mark, half = outer[owner], half[owner]
    none: tuple[Array, Array, float] = np.zeros(0), np.zeros((0, 2)), 1.0
    if not len(pieces):
        return none
    tree = shapely.STRtree(pieces)
    lot = np.random.default_rng(0).permutation(len(pieces))
    looked = np.zeros(len(pieces), bool)
    widest, pairs = float(half.max()), 0
    found: list[tuple[Array, Shapes, Index]] = []
    lo, step = 0, 256
    while lo < len(lot):
        if pairs > PAIRS or looked.sum() > MOST * max(1.0, len(pieces) / len(chosen)):
            break
        some = lot[lo : lo + step]
        lo += step
        edge = (reach + half[some] + widest)[:, None] * (-1, -1, 1, 1)
        i, j = tree.query(shapely.box(*(bounds[some] + edge).T))
        step = int(np.clip(step * HITS / max(1, len(i)), 16, LOT))
        i = some[i]
        new = (mark[i] != mark[j]) & ~looked[j] & (~np.isin(j, some) | (i < j))
        i, j = i[new], j[new]
        looked[some] = True
        pairs += len(i)
        far, ends = nearest(xy, start, bounds, i, j, reach + half[i] + half[j])
        gap = far - half[i] - half[j]
        near = (gap > TOUCH) & (gap < reach)
        ends, one, other = ends[near], mark[i[near]], mark[j[near]]
        found.append((gap[near], ends.mean(axis=1), np.minimum(one, other) * len(art) + np.maximum(one, other)))
    gap, at, both = (np.concatenate([part[k] for part in found]) for k in range(3))
    order = np.argsort(gap, kind="stable")
    order = order[np.unique(both[order], return_index=True)[1]]  # long outlines meet in several pieces
    gap, middle = gap[order], shapely.points(at[order])
    covered = np.zeros(len(gap), bool)
    covered[_under(art, solid, hole, outer, middle)] = True
    if widest > 0:
        point, piece = tree.query(middle, predicate="dwithin", distance=widest)
        covered[point[shapely.distance(middle[point], pieces[piece]) < half[piece]]] = True
    return gap[~covered], shapely.get_coordinates(middle[~covered]), float(looked.mean())


def _pieces(art: Art, which: Index) -> tuple[Array, Index, Index]:
    """The outlines as lines of PIECE sides at most, all points and where each begins, and the outline that each is of."""
    paths = art.outlines.take(which)
    count = np.diff(paths.start)
    back = art.closed[which] | (count == 1)
    xy = np.insert(paths.xy, paths.start[1:][back], paths.xy[paths.start[:-1][back]], axis=0)
    count = count + back
    first = np.cumsum(count) - count
    lots = -(-(count - 1) // PIECE)
    path = np.repeat(np.arange(len(which)), lots)
    begin = (np.arange(len(path)) - (np.cumsum(lots) - lots)[path]) * PIECE
    size = np.minimum(PIECE + 1, count[path] - begin)
    at = np.repeat(first[path] + begin - (np.cumsum(size) - size), size) + np.arange(size.sum())
    return xy[at], np.concatenate([[0], np.cumsum(size)]), which[path]


def _under(art: Art, solid: Flags, hole: Flags, outer: Index, points: Any) -> Index:
    """Which points lie in a fill, its holes left out."""
    which = np.flatnonzero(solid & (art.fill[art.thing] >= 0) & (np.diff(art.outlines.start) > 2))
    rings = art.outlines.take(which).polygons()
    place = np.full(len(art), -1)
    place[which] = np.arange(len(which))
    inside = np.flatnonzero(hole & (place[outer] >= 0))
    inside = inside[np.argsort(outer[inside], kind="stable")]
    for own in np.split(inside, np.flatnonzero(np.diff(outer[inside])) + 1) if len(inside) else ():
        around = outer[own[0]]
        rings[place[around]] = shapely.Polygon(art.outlines[around], [art.outlines[i] for i in own])
    found, _ = shapely.STRtree(rings).query(points, predicate="within")
    return np.asarray(np.unique(found), np.int64)
