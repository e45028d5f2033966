"""The operation that relaxes, a step of any variant, and the wall that relaxation may stay within.

What relaxes under a brush or in a selection has only its surroundings triangulated: as much of them as decides its cells.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
import shapely
from scipy.spatial import cKDTree

from crowquill import relax as dots
from crowquill import settling
from crowquill.cells import Cells
from crowquill.editor.brushes import Meant, Path, outline
from crowquill.editor.drawing import Drawing
from crowquill.editor.fields import along
from crowquill.editor.items import Columns, Items, Kind, Mask
from crowquill.editor.operations import on_meant, operation
from crowquill.editor.operations.mosaics import stepped
from crowquill.knobs import Choice, Flag, Range
from crowquill.objects import Objects
from crowquill.paths import Array, Index, Paths
from crowquill.tone import Tone

VARIANTS = ("uniform", "weighted", "objects", "move", "turn", "mosaic")
STEP = 1.8  # of dots; objects, whose regions depend on their turn, swing with more than 1
AROUND = 3.0  # spacings: how far around what moves others are looked at first

Facts = dict[str, float]


@on_meant("relax", on="all", size=10.0, falloff="flat")
def relax(
    meant: Meant,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    variant: Annotated[str, Choice(VARIANTS, "dots, uniform or by tone; objects move and turn, or either; or tiles")] = "weighted",
    step: Annotated[float | None, Range(0.01, 1.99, "", "of the way to the centroid (dots 1.8, others 1)")] = None,
    exponent: Annotated[float | None, Range(0, 4, "", "cells weigh coverage to this power (weighted 2, others 0)")] = None,
    axes: Annotated[str, Choice(("region", "flow"), "what objects turn to: the axis of their region, or the picture's flow")] = "region",
    wall: Annotated[str, Choice(("canvas", "drawn"), "what nothing crosses")] = "canvas",
    off_edges: Annotated[bool, Flag("push tiles off edges; not so in the last steps, gaps close")] = True,
) -> Drawing:
    """Relax: one step; what is not meant, or frozen, or in a locked layer, stands still and keeps its cell.

    Of a layer alone its items take part alone, else those of all that are shown. Items off the canvas, or outside the wall, take no part.
    """
    drawing = meant.drawing
    weights = {found.id: (rows, weight) for found, rows, weight in meant.parts()}
    if not any(len(rows) for rows, _ in weights.values()):
        return drawing
    if variant == "mosaic":
        return stepped(drawing, weights, wall == "drawn", off_edges)
    power = exponent if exponent is not None else 2.0 if variant == "weighted" else 0.0
    crowd = _Crowd.of(drawing, weights, meant.layer, drawing.weight(0.0 if variant == "uniform" else power, wall == "drawn"))
    if not crowd.active.any():
        return drawing
    if variant in ("uniform", "weighted"):
        target, angle, facts = _dots(crowd, step or STEP)
    else:
        towards = (lambda xy: along(drawing.toned()).at(xy)[0]) if axes == "flow" else None
        shares = {"objects": (step or 1.0, 1.0), "move": (step or 1.0, 0.0), "turn": (0.0, step or 1.0)}[variant]
        target, angle, facts = _objects(crowd, shares, towards)
    idle = not facts["energy"] and not crowd.tone.ink
    notes = ("the picture asks for no ink here, so that nothing moves by it; take the variant uniform",) if idle else ()
    return replace(drawing.with_items(crowd.posed(drawing, target, angle)), facts=facts, notes=notes)


@dataclass(frozen=True, eq=False)
class _Crowd:
    """All that might take part, layer after layer, mm from the picture's corner.

    items   of each layer, by its id
    weight  (n,) how far each goes of its way; `active` are those that move, which are on the canvas
    tone    what cells weigh; its canvas is where they lie
    """

    items: dict[int, Items]
    xy: Array
    weight: Array
    active: Mask
    kinds: tuple[Kind, ...]
    corner: Array
    tone: Tone

    @classmethod
    def of(cls, drawing: Drawing, weights: dict[int, tuple[Index, Array]], layer: int | None, tone: Tone) -> _Crowd:
        """The items of layers that are shown, or of one."""
        there = [found for found in drawing.layers if not (found.hidden or found.still) and layer in (None, found.id)]
        items = {found.id: found.items for found in there}
        first = np.cumsum([0, *(len(part) for part in items.values())])
        xy = np.concatenate([part.xy for part in items.values()]) - drawing.picture.corner
        weight = np.zeros(len(xy))
        for id, at in zip(items, first, strict=False):
            rows, value = weights.get(id, (np.zeros(0, np.int64), np.zeros(0)))
            weight[at + rows] = value
        active = weight > 0
        active[active] = tone.holds(xy[active])
        return cls(items, xy, weight, active, drawing.kinds, drawing.picture.corner, tone)

    @property
    def spacing(self) -> float:
        """Of all if they were on the canvas, mm."""
        return float(np.sqrt(shapely.area(self.tone.canvas) / max(1, len(self.xy))))

    @property
    def largest(self) -> float:
        """How far the largest outline reaches from its centre, mm."""
        reach = np.array([kind.reach for kind in self.kinds])
        return max(float((reach[part.kind] * part.mm).max(initial=0.0)) for part in self.items.values())

    def column(self, name: str, rows: Index) -> Any:
        """A column of items at some rows."""
        return np.concatenate([getattr(part, name) for part in self.items.values()])[rows]

    def surroundings(self) -> Iterator[tuple[Index, shapely.Geometry, float]]:
        """Ever more of what lies around those that move: the rows, a window of the canvas, and how far off the next might be, mm.

        Whoever finds cells that reach less than half as far has what decides them.
        """
        if 2 * int(self.active.sum()) >= len(self.xy):
            yield np.flatnonzero(self.active if (self.weight > 0).all() else self.tone.holds(self.xy)), self.tone.canvas, np.inf
            return
        moving = self.xy[self.active]
        low, high = moving.min(axis=0), moving.max(axis=0)
        margin, tree = AROUND * self.spacing, cKDTree(moving)
        while True:
            near = np.flatnonzero(((self.xy >= low - margin) & (self.xy <= high + margin)).all(axis=1))
            near = near[tree.query(self.xy[near], distance_upper_bound=margin)[0] < margin]
            if 2 * len(near) >= len(self.xy):
                yield np.flatnonzero(self.tone.holds(self.xy)), self.tone.canvas, np.inf
                return
            window = shapely.intersection(self.tone.canvas, shapely.box(*(low - margin), *(high + margin)))
            yield near[self.tone.holds(self.xy[near])], window, margin
            margin *= 2

    def posed(self, drawing: Drawing, target: Array, angle: Array | None) -> dict[int, Items]:
        """The items by their layers, those that move as far towards their targets (m, 2) and angles (m,) as their weights say."""
        moving = np.flatnonzero(self.active)
        share = self.weight[moving]
        xy = target if (share == 1).all() else self.xy[moving] + share[:, None] * (target - self.xy[moving])
        xy = xy + self.corner
        now = self.column("angle", moving)
        turned = None if angle is None else now + share * (angle - now)
        by, first = {}, 0
        for id, part in self.items.items():
            mine = (moving >= first) & (moving < first + len(part))
            if mine.any():
                by[id] = part.posed(moving[mine] - first, xy=drawing.clipped(xy[mine]), angle=None if turned is None else turned[mine])
            first += len(part)
        return by


class _Last:
    """The cells of the last step of a whole crowd: those of its next are found sooner by them, and are the same."""

    def __init__(self) -> None:
        self._kept: tuple[list[Columns], Index, Cells] | None = None

    def cells(self, crowd: _Crowd, rows: Index) -> Cells | None:
        """The last cells, if they are of the same items."""
        if self._kept is None:
            return None
        ids, old, found = self._kept
        same = len(ids) == len(crowd.items) and all(one is part.id for one, part in zip(ids, crowd.items.values(), strict=True))
        return found if same and np.array_equal(old, rows) else None

    def keep(self, crowd: _Crowd, rows: Index, found: Cells) -> None:
        """Keeps the cells of these rows of a crowd."""
        self._kept = ([part.id for part in crowd.items.values()], rows, found)


_LAST = _Last()


def _dots(crowd: _Crowd, step: float) -> tuple[Array, None, Facts]:
    """Where sites that move go."""
    for rows, window, margin in crowd.surroundings():
        last = _LAST.cells(crowd, rows) if margin == np.inf else None
        state = dots.measured(crowd.xy[rows], crowd.tone, crowd.tone, canvas=window, last=last)
        mine = crowd.active[rows]
        if margin == np.inf or 2 * _reach(state.cells.rings, state.cells.owner, state.cells.sites, mine) < margin:
            break
    if margin == np.inf:
        _LAST.keep(crowd, rows, state.cells)
    target = dots.moved(state, crowd.tone, step=step)
    if mine.all():
        return target, None, {"energy": state.energy, "movement": state.movement}
    target = target[mine]
    way = (state.moments.centroid - state.sites)[mine]
    spread = np.trace(state.moments.covariance[mine], axis1=1, axis2=2) + (way**2).sum(axis=1)
    area = np.bincount(state.cells.owner, state.cells.rings.areas, len(rows))[mine]
    gone = np.hypot(*way.T) / np.sqrt(np.where(area > 0, area, np.inf))
    return target, None, {"energy": float((state.moments.mass[mine] * spread).sum()), "movement": float(gone.mean())}


def _objects(crowd: _Crowd, shares: tuple[float, float], towards: Callable[[Array], Array] | None) -> tuple[Array, Array, Facts]:
    """Where objects that move go, and their angles then."""
    flat = crowd.tone.coverage.size == 1
    for rows, _, margin in crowd.surroundings():
        mine, xy = crowd.active[rows], crowd.xy[rows]
        used, kind = np.unique(crowd.column("kind", rows), return_inverse=True)
        shapes = tuple(crowd.kinds[k].shape for k in used)
        objects = Objects.of(xy, shapes, angle=crowd.column("angle", rows), scale=crowd.column("mm", rows), shape=kind)
        state = next(
            settling.settle(
                objects, crowd.tone.canvas if flat else crowd.tone, move=shares[0], turn=shares[1],
                exponent=1.0, sampling=settling.APART * crowd.spacing, fixed=~mine, towards=towards,
            )
        )  # fmt: skip
        owner = state.owner[state.cells.owner]
        # cells reach from outlines, and outlines of what is left out into the window
        if margin == np.inf or 2 * (_reach(state.cells.rings, owner, xy, mine) + crowd.largest) < margin:
            break
    spread = np.trace(state.moments.covariance[mine], axis1=1, axis2=2)
    energy = float((state.moments.mass[mine] * spread).sum())
    moved = state.moved.take(mine)
    return moved.xy, moved.angle, {"energy": energy, "movement": state.movement, "turning": state.turning}


def _reach(rings: Paths, owner: Index, xy: Array, mine: Mask) -> float:
    """How far the cells of some sites reach from them, mm."""
    of = owner[rings.path]
    of, corners = of[mine[of]], rings.xy[mine[of]]
    return float(np.hypot(*(corners - xy[of]).T).max(initial=0.0))


@operation("map")
def wall(
    drawing: Drawing,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    path: Path = None,
) -> Drawing:
    """Draw a wall that relaxation does not cross: an outline, or none when the path is left out."""
    if path is None:
        return replace(drawing, wall=None)
    rings, _ = Paths.of_polygons(np.array([outline(path)], dtype=object))
    return replace(drawing, wall=rings)
