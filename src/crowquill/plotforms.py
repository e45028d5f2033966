"""What a pen of one width does to draw dots: touches of its tip, spirals and hatching. Strokes, the data of it all."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.hatching import FINE, FLAT, PITCH, SHORTEST, hatched, tick
from crowquill.marks import Marks
from crowquill.paths import Array, Paths

FORMS = ("circle", "tick", "spiral", "hatch")
TOUCH = 0.05  # of the nib: the radius of a circle so small that it is one touch, a fifth more ink than the tip alone leaves
TICK = (SHORTEST, 0.1)  # mm; longer ones look like strokes
FILLED = 1.2  # nibs across, up to which a dot is one touch whatever its form
CLOSED = 2.0  # nibs across, up to which a touch can be as wide as its dot
ROUNDS = 6  # of looking for how deep inside the outline a fill's ring goes; all but dots hardly wider than the nib take two
CLOSE = 0.01  # of a dot's ink: a fill further off than that, of a dot hardly wider than the nib, becomes a tick


@dataclass(frozen=True, eq=False)
class Strokes:
    """Open straight paths, a closed one ending where it began, and which of them begin a dot: `dot` (n,)."""

    paths: Paths
    dot: npt.NDArray[np.bool_]

    @classmethod
    def of(cls, strokes: list[Array], dot: npt.ArrayLike = False) -> Strokes:
        """Strokes of points (k, 2); dot is one for all or (n,)."""
        return cls(Paths.of(strokes, closed=False), np.broadcast_to(np.asarray(dot, bool), len(strokes)))

    @classmethod
    def together(cls, parts: list[Strokes]) -> Strokes:
        """All strokes of several, in their order."""
        dot = np.concatenate([np.zeros(0, bool), *(part.dot for part in parts)])
        return cls(Paths.of([stroke for part in parts for stroke in part.paths], closed=False), dot)


def lines(paths: Paths) -> Strokes:
    """Paths drawn as they are, curves in straight pieces within FLAT; an open path of one point draws nothing."""
    paths = paths.flat(FLAT)
    found = [np.concatenate([points, points[:1]]) if paths.closed else points for points in paths]
    return Strokes.of([points for points in found if len(points) > 1])


def dots(marks: Marks, nib: float, form: str) -> Strokes:
    """Marks drawn in one of FORMS; marks of no size are not drawn.

    circle  a closed circle of TOUCH nibs, larger for a dot of more than 1.1 nibs, so that the pen's outer rim is the dot's:
            up to CLOSED nibs it leaves no white inside
    tick    a line along the dot's long axis as much longer than the nib as the dot is, in the limits of TICK
    spiral  for dots over FILLED nibs wide, a spiral from the middle and a ring; where a dot bends back round its middle, hatch
    hatch   for dots over FILLED nibs wide, lines along the dot's long axis and a ring, one stroke

    Spiral and hatch put down the dot's own area. A dot too narrow for them is a tick of as much ink.
    """
    marks = marks.take(marks.scale > 0)
    wide = widths(marks) > FILLED * nib if form in ("spiral", "hatch") else np.zeros(len(marks), bool)
    return Strokes.together([_touches(marks.take(~wide), nib, form), _fills(marks.take(wide), nib, form)])


def widths(marks: Marks) -> Array:
    """The diameter in mm of a disc of each mark's area, (n,)."""
    return np.asarray(2 * marks.scale / np.sqrt(np.pi))


def _touches(marks: Marks, nib: float, form: str) -> Strokes:
    """A touch of the pen for each mark: a small circle, or a tick for any other form than that and spiral."""
    longer = widths(marks) - nib
    if form in ("circle", "spiral"):
        # a smaller circle would be no longer than the strokes that plotting programs drop
        r = np.maximum(np.clip(longer / 2, TOUCH * nib, (CLOSED - 1) / 2 * nib), SHORTEST / 5)
        n = 8 if not len(r) else max(8, int(np.ceil(np.pi / np.sqrt(2 * min(0.05, nib * 0.01 / r.max())))))
        turn = np.append(np.arange(n), 0) * 2 * np.pi / n
        xy = marks.xy[:, None] + r[:, None, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    else:
        half = np.clip(longer, *TICK) / 2
        along = np.stack([np.cos(marks.angle), np.sin(marks.angle)], axis=1) * half[:, None]
        xy = np.stack([marks.xy - along, marks.xy + along], axis=1)
    start = np.arange(len(marks) + 1) * xy.shape[1]
    return Strokes(Paths(xy.reshape(-1, 2), start, closed=False), np.ones(len(marks), bool))


def _fills(marks: Marks, nib: float, form: str) -> Strokes:
    """Marks wider than the nib, filled: a shape of one size is worked out once, and turned to where it lies."""
    kinds, kind = np.unique(np.stack([marks.glyph, marks.scale], axis=1), axis=0, return_inverse=True)
    each = Marks.of(np.zeros((len(kinds), 2)), marks.glyphs, scale=kinds[:, 1], glyph=kinds[:, 0].astype(np.int64))
    outlines = shapely.buffer(each.outlines().flat(nib * FINE).polygons(), 0)
    draw = partial(_spiral if form == "spiral" else hatched, nib=nib)
    shapes: list[list[Array]] = []
    for inner, size in zip(_inset(outlines, kinds[:, 1] ** 2, nib), kinds[:, 1].tolist(), strict=True):
        shape = [stroke for part in shapely.get_parts(inner) if not part.is_empty for stroke in draw(part)]
        shapes.append(shape or [tick((0, 0), 0.0, (size**2 - np.pi / 4 * nib**2) / nib)])
    found: list[Array] = []
    first: list[bool] = []
    for at, angle, k in zip(marks.xy, marks.angle.tolist(), kind.reshape(-1).tolist(), strict=True):
        cos, sin = np.cos(angle), np.sin(angle)
        for number, stroke in enumerate(shapes[k]):
            x, y = stroke.T
            found.append(np.stack([cos * x - sin * y, sin * x + cos * y], axis=1) + at)
            first.append(number == 0)
    return Strokes.of(found, first)


def _inset(outlines: npt.NDArray[np.object_], wanted: Array, nib: float) -> npt.NDArray[np.object_]:
    """Outlines about half a nib inside, by so much that the pen along and within them covers the areas wanted, mm^2.

    Exactly half a nib would lose the corners that are sharper than the nib. Empty where no such depth was found.
    """

    def inside(which: npt.NDArray[np.bool_]) -> npt.NDArray[np.object_]:
        return np.asarray(shapely.simplify(shapely.buffer(outlines[which], -depth[which]), nib * FINE))

    depth = np.full(len(outlines), nib / 2)
    off = np.ones(len(outlines), bool)
    inner, ink = inside(off), np.zeros(len(outlines))
    for _ in range(ROUNDS):
        ink[off] = shapely.area(shapely.buffer(inner[off], nib / 2))
        off &= (ink > 0) & (np.abs(ink / wanted - 1) > CLOSE / 5)
        step = (wanted - ink) / np.maximum(shapely.length(outlines), nib)
        depth = np.where(off, np.clip(depth - step, nib / 4, nib), depth)
        inner[off] = inside(off)
    ink[off] = shapely.area(shapely.buffer(inner[off], nib / 2))
    inner[np.abs(ink / wanted - 1) > CLOSE] = shapely.Polygon()
    return inner


def _spiral(inner: shapely.Polygon, nib: float) -> list[Array]:
    """One stroke from the middle out, its arms shaped as the ring it ends in; hatch where the ring is not seen whole from its middle."""
    middle = shapely.get_coordinates(inner.centroid)[0]
    ring = shapely.get_coordinates(inner.exterior)[:-1] - middle
    after = np.roll(ring, -1, axis=0)
    cross = ring[:, 0] * after[:, 1] - ring[:, 1] * after[:, 0]
    if inner.interiors or not ((cross > 0).all() or (cross < 0).all()):
        return hatched(inner, nib)
    if cross[0] < 0:
        ring = ring[::-1]
    angle = np.arctan2(ring[:, 1], ring[:, 0])
    ring, angle = np.roll(ring, -int(angle.argmin()), axis=0), np.roll(angle, -int(angle.argmin()))
    far = float(np.hypot(*ring.T).max())
    if far <= PITCH * nib / 2:
        return [np.concatenate([ring, ring[:1]]) + middle]
    turns = far / (PITCH * nib)
    steps = max(24, int(np.ceil(np.pi / np.sqrt(2 * min(0.1, nib / 40 / far)))))  # chords stray a 40th of a nib at most
    share = np.linspace(0, 1, int(np.ceil(turns * steps)) + 1)
    at = (share * turns * 2 * np.pi + np.pi) % (2 * np.pi) - np.pi
    side = np.searchsorted(angle, at, side="right") - 1  # -1: the side across the ray of half a turn
    a, b = ring[side], np.roll(ring, -1, axis=0)[side]
    cos, sin = np.cos(at), np.sin(at)
    reach = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / (cos * (b[:, 1] - a[:, 1]) - sin * (b[:, 0] - a[:, 0]))
    arms = (share * reach)[:, None] * np.stack([cos, sin], axis=1)
    rest = np.roll(ring, -(int(side[-1]) + 1), axis=0)
    return [np.concatenate([arms, rest, arms[-1:]]) + middle]
