"""How much of each pixel art covers: spans between outlines, exact along scan lines, many lines to a row of pixels.

A line's crossings with all outlines are sorted, and it is covered where their windings do not sum to
zero, so that a place covered twice counts once and a hole that turns the other way stays open.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from crowquill.kernel import compiled, shared_out
from crowquill.marks import Marks
from crowquill.paths import Array, Index, Paths
from crowquill.raster.pixels import Pixels
from crowquill.sheet import Art, Bitmap, outlined

LINES = 16  # to a row of pixels: a level border errs by a 32nd of a pixel at most, a sloping one by far less
FLAT = 1 / 200  # of a pixel: how far a chord may stray from its curve; a dot of 7 pixels loses less than a thousandth
FINEST = 1e-3  # of a unit glyph: no coarser, or a thin dot between two pixels would have no width
PIXELS = 1 << 20  # held at a time
CHUNK = 100_000  # points of curves made straight at a time
ROWS = 4  # of pixels at least to a thread
_STEP = 1 << 24  # crossings are kept to this part of a pixel, so that sums are exact in any order


@dataclass(frozen=True, eq=False)
class Raster:
    """Art made ready for any rows of a grid of pixels; see `of`.

    corners  (m, 2), start (s + 1,): outlines in straight pieces, in mm
    shape    (n,) the outline of each thing drawn, and place (n, 4) its x, y, and scale by cosine and sine of its angle
    low      (n,) mm, and high: between which y each lies
    """

    corners: Array
    start: Index
    shape: Index
    place: Array
    low: Array
    high: Array
    pixel: tuple[float, float]
    width: int
    lines: int

    @classmethod
    def of(
        cls,
        art: Art,
        *,
        pixel: tuple[float, float],
        width: int,
        pen: float | None = None,
        lines: int = LINES,
        flat: float | None = None,
    ) -> Raster:
        """Art on a grid `width` pixels wide, its first corner at (0, 0); pixel (width, height) mm, lines to each row of them.

        pen   None fills, and closes lines that are open; a width in mm strokes with round ends and joins
        flat  mm that a chord may stray from its curve; left out, a 200th of a pixel. Marks get back the
              area that chords cut off
        """
        flat = min(pixel) * FLAT if flat is None else flat
        if pen is not None:
            art = stroked(_straight(outlined(art), flat), pen, flat)
        if isinstance(art, Marks):
            return cls(*_of_marks(art, flat, pixel[0] * width), pixel, width, lines)
        return cls(*_of_paths(_straight(outlined(art), flat), pixel[0] * width), pixel, width, lines)

    def touches(self, top: int, bottom: int) -> bool:
        """Whether anything may lie on these rows, `bottom` not among them."""
        return bool(((self.high >= top * self.pixel[1]) & (self.low <= bottom * self.pixel[1])).any())

    def rows(self, top: int, bottom: int) -> Array:
        """The share of each pixel covered, (bottom - top, width): the same bits whatever rows are asked for together."""
        cover = np.zeros((bottom - top, self.width))

        def work(lo: int, hi: int) -> None:
            above, below = (top + lo) * self.pixel[1], (top + hi) * self.pixel[1]
            near = np.flatnonzero((self.high >= above) & (self.low <= below))
            _fill(self.corners, self.start, self.shape, self.place, near, *self.pixel, self.lines, top + lo, cover[lo:hi])

        shared_out(work, bottom - top, ROWS)
        return cover


def ready(
    art: Art, *, pixel: tuple[float, float], width: int, pen: float | None = None, lines: int = LINES, flat: float | None = None
) -> Raster | Pixels:
    """Any art made ready for rows of a grid of pixels; knobs are those of `Raster.of`, and a bitmap heeds the grid alone."""
    if isinstance(art, Bitmap):
        return Pixels.of(art, pixel=pixel, width=width)
    return Raster.of(art, pixel=pixel, width=width, pen=pen, lines=lines, flat=flat)


def covered(
    art: Art,
    grid: tuple[int, int],
    *,
    pixel: tuple[float, float],
    pen: float | None = None,
    lines: int = LINES,
    flat: float | None = None,
) -> Array:
    """The share of each pixel that art covers, (h, w) for grid (h, w), from 0 to 1; what hangs over the grid's edge is not seen.

    Knobs are those of `Raster.of`. Outlines of fewer than three points, and marks of no size, cover nothing.
    """
    h, w = grid
    raster = ready(art, pixel=pixel, width=w, pen=pen, lines=lines, flat=flat)
    cover = np.zeros(grid)
    band = max(1, PIXELS // max(w, 1))
    for top in range(0, h, band):
        bottom = min(h, top + band)
        if raster.touches(top, bottom):
            cover[top:bottom] = raster.rows(top, bottom)
    return cover


def stroked(paths: Paths, pen: float, flat: float) -> Paths:
    """What a round pen covers along straight paths, as rings that turn from x to y: one a side with the join at its end.

    Rings overlap; the nonzero rule joins them. A line of no length is a disc, and one of a single point is nothing, as in
    SVG and PDF; a closed path of a single point is a disc. Arcs stray at most `flat` mm.
    """
    a, b, along, turn = _sides(paths)
    arc = min(np.pi / 8, 2 * float(np.arccos(1 - min(1.0, 2 * flat / pen))))
    steps = np.ceil(np.abs(turn) / arc).astype(np.int64)
    start = np.concatenate([[0], np.cumsum(steps + 5)])
    xy = np.empty((start[-1], 2))
    _rings(a, b, along, turn, steps, pen / 2, start, xy)
    return Paths(xy, start)


def _sides(paths: Paths) -> tuple[Array, Array, Array, Array]:
    """Sides to be stroked: from (n, 2), to (n, 2), direction (n, 2) and turn at the end (n,), half a turn where that is a cap.

    The cap at a line's beginning is a side of no length that leads out of it; a dot is two of them.
    """
    xy, path = paths.xy, paths.path
    kept = np.ones(len(path), bool)
    kept[1:] = (path[1:] != path[:-1]) | (xy[1:] != xy[:-1]).any(axis=1)
    if not paths.closed:
        kept &= (np.diff(paths.start) > 1)[path]
    xy, path = xy[kept], path[kept]
    if paths.closed:  # a last point on the first would be a side of no length too
        at, first, last = _places(path)
        kept = (at == first) | (at != last) | (xy != xy[first]).any(axis=1)
        xy, path = xy[kept], path[kept]
    at, first, last = _places(path)
    after = np.where(at == last, first, at + 1)
    dot = first == last
    side = ~dot if paths.closed else at != last
    gap = np.where(side[:, None], xy[after] - xy, (1.0, 0.0))
    along = gap / np.hypot(*gap.T)[:, None]
    (u, v), (x, y) = along.T, along[after].T
    turn = np.where(side[after], np.arctan2(u * y - v * x, u * x + v * y), np.pi)
    drawn = np.flatnonzero(side | dot)
    heads = np.flatnonzero(dot if paths.closed else dot | (side & (at == first)))
    from_, to = xy[np.concatenate([drawn, heads])], xy[np.concatenate([after[drawn], heads])]
    return from_, to, np.concatenate([along[drawn], -along[heads]]), np.concatenate([turn[drawn], np.full(len(heads), np.pi)])


def _places(path: Index) -> tuple[Index, Index, Index]:
    """The index of each point, and of the first and last of its path, for points in the order of their paths."""
    return np.arange(len(path)), np.searchsorted(path, path), np.searchsorted(path, path, side="right") - 1


def _straight(paths: Paths, flat: float) -> Paths:
    """The paths in straight pieces, made a few at a time: curves under way take ten times the memory of their points."""
    if not paths.cubic or len(paths.xy) <= CHUNK:
        return paths.flat(flat)
    cuts = np.unique([*np.searchsorted(paths.start, np.arange(0, len(paths.xy), CHUNK)), len(paths)])
    parts = [paths.take(np.arange(lo, hi)).flat(flat) for lo, hi in pairwise(cuts.tolist())]
    counts = np.concatenate([np.diff(part.start) for part in parts])
    return Paths(np.concatenate([part.xy for part in parts]), np.concatenate([[0], np.cumsum(counts)]), paths.closed)


def _of_marks(marks: Marks, flat: float, right: float) -> tuple[Array, Index, Index, Array, Array, Array]:
    """Glyphs as outlines, and where marks lie that reach between x = 0 and `right`."""
    marks = marks.take(marks.scale > 0)
    if not len(marks):
        return _of_paths(Paths.of([]), right)
    shapes = marks._shapes.flat(min(FINEST, flat / float(marks.scale.max())))
    area = shapes.areas
    corners = shapes.xy / np.sqrt(np.where(area > 0.5, area, 1.0))[shapes.path][:, None]  # chords cut off area: it is given back
    furthest = np.zeros(len(shapes))
    np.maximum.at(furthest, shapes.path, np.hypot(*corners.T))
    reach = furthest[marks.glyph] * marks.scale * (1 + 1e-9)
    seen = (marks.xy[:, 0] + reach >= 0) & (marks.xy[:, 0] - reach <= right)
    order = np.flatnonzero(seen)[np.argsort(marks.xy[seen, 0], kind="stable")]  # so that lines are nearly in order
    marks, reach = marks.take(order), reach[order]
    place = np.column_stack([marks.xy, marks.scale * np.cos(marks.angle), marks.scale * np.sin(marks.angle)])
    return corners, shapes.start, marks.glyph, place, marks.xy[:, 1] - reach, marks.xy[:, 1] + reach


def _of_paths(paths: Paths, right: float) -> tuple[Array, Index, Index, Array, Array, Array]:
    """Outlines that reach between x = 0 and `right`, each where it is."""
    shape = np.flatnonzero(np.diff(paths.start) > 2)
    heads = paths.start[shape].astype(np.intp)  # points of shorter paths between them widen a box, which does no harm
    low, high = np.minimum.reduceat(paths.xy, heads), np.maximum.reduceat(paths.xy, heads)
    order = np.argsort(low[:, 0], kind="stable")
    order = order[(high[order, 0] >= 0) & (low[order, 0] <= right)]
    place = np.tile([0.0, 0.0, 1.0, 0.0], (len(order), 1))
    return paths.xy, paths.start, shape[order], place, low[order, 1], high[order, 1]


@compiled
def _rings(a: Array, b: Array, along: Array, turn: Array, steps: Index, r: float, start: Index, xy: Array) -> None:
    """Fills a ring a side: the side as wide as the pen, and on the outer side of the turn at its end a piece of pie."""
    for i in range(len(a)):
        nx, ny = -along[i, 1] * r, along[i, 0] * r
        at, way = start[i], 1.0 if turn[i] > 0 else -1.0
        xy[at, 0], xy[at, 1] = a[i, 0] + nx, a[i, 1] + ny
        xy[at + 1, 0], xy[at + 1, 1] = a[i, 0] - nx, a[i, 1] - ny
        xy[at + 2, 0], xy[at + 2, 1] = b[i, 0] - nx, b[i, 1] - ny
        at += 3
        if way < 0:
            xy[at] = b[i]
            at += 1
        for k in range(steps[i]):
            angle = turn[i] * ((k + 1) if way > 0 else (steps[i] - k)) / steps[i]
            cos, sin = np.cos(angle) * way, np.sin(angle) * way
            xy[at, 0], xy[at, 1] = b[i, 0] - cos * nx + sin * ny, b[i, 1] - sin * nx - cos * ny
            at += 1
        if way > 0:
            xy[at] = b[i]
            at += 1
        xy[at, 0], xy[at, 1] = b[i, 0] + nx, b[i, 1] + ny


@compiled
def _fill(
    corners: Array, start: Index, shape: Index, place: Array, near: Index, dx: float, dy: float, lines: int, top: int, cover: Array
) -> None:
    """Fills the cover of rows of pixels from row `top` on by the things `near` them."""
    w = cover.shape[1]
    first, count = top * lines, cover.shape[0] * lines
    at = np.zeros(count + 1, np.int64)
    keys = np.empty(0, np.int64)
    for known in range(2):  # crossings are counted first, then kept, line by line
        for i in near:
            begin, end = start[shape[i]], start[shape[i] + 1]
            px, py, cos, sin = place[i, 0], place[i, 1], place[i, 2], place[i, 3]
            u, v = corners[end - 1, 0], corners[end - 1, 1]
            ax, ay = (px + cos * u - sin * v) / dx, (py + sin * u + cos * v) / dy * lines
            for k in range(begin, end):
                u, v = corners[k, 0], corners[k, 1]
                bx, by = (px + cos * u - sin * v) / dx, (py + sin * u + cos * v) / dy * lines
                # a line runs through the middle of its strip; an end that lies on it belongs to the side below
                upper = int(min(max(np.ceil(min(ay, by) - 0.5) - first, 0.0), count))
                lower = int(min(max(np.ceil(max(ay, by) - 0.5) - first, 0.0), count))
                if upper < lower:
                    if known:
                        slope, down = (bx - ax) / (by - ay), 1 if by > ay else 0
                        for line in range(upper, lower):
                            x = min(max(ax + (line + first + 0.5 - ay) * slope, 0.0), float(w))
                            keys[at[line]] = int(x * _STEP) * 2 + down
                            at[line] += 1
                    else:
                        at[upper] += 1
                        at[lower] -= 1
                ax, ay = bx, by
        if not known:
            total, crossing = 0, 0
            for line in range(count + 1):  # from changes to the place where each line's crossings begin
                crossing += at[line]
                at[line] = total
                total += crossing
            keys = np.empty(total, np.int64)
    begin = 0
    for line in range(count):
        _spans(keys[begin : at[line]], cover[line // lines])
        begin = at[line]
    cover /= lines


@compiled
def _spans(keys: Index, row: Array) -> None:
    """Adds what one scan line covers of each pixel of a row; keys are twice the crossings' places, odd where an outline leads down."""
    _sort(keys)
    winding, left = 0, 0.0
    for key in keys:
        before, x = winding, (key >> 1) / _STEP
        winding += 1 if key & 1 else -1
        if before == 0:
            left = x
        elif winding == 0 and x > left:
            first, last = int(left), int(x)
            if first == last:
                row[first] += x - left
                continue
            row[first] += first + 1 - left
            for column in range(first + 1, last):
                row[column] += 1
            if last < len(row):
                row[last] += x - last


@compiled
def _sort(keys: Index) -> None:
    """Sorts keys that are nearly in order by putting each in its place, and others as numbers are sorted anywhere."""
    moves = 8 * len(keys)
    for k in range(1, len(keys)):
        key, at = keys[k], k
        while at > 0 and keys[at - 1] > key:
            keys[at] = keys[at - 1]
            at -= 1
        keys[at] = key
        moves -= k - at
        if moves < 0:
            keys.sort()
            return
