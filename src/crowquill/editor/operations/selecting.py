"""The operation that selects."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import shapely

from crowquill.editor.brushes import Brush, OfLayer, Path, Size, outline, way
from crowquill.editor.drawing import Drawing
from crowquill.editor.items import Items, Mask
from crowquill.editor.operations import operation
from crowquill.knobs import Choice, Range

WAYS = ("lasso", "rectangle", "brush", "pick", "layer", "tone", "all", "none", "invert")
PICKED = 1.0  # mm beyond an item's reach from which it is still picked


@operation("select")
def select(
    drawing: Drawing,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    by: Annotated[str, Choice(WAYS, "what of")] = "lasso",
    mode: Annotated[str, Choice(("replace", "add", "remove"), "what becomes of the selection there was")] = "replace",
    path: Path = None,
    size: Size = 5.0,
    layer: OfLayer = None,
    low: Annotated[float, Range(0, 1, "", "by tone: from this coverage")] = 0.0,
    high: Annotated[float, Range(0, 1, "", "by tone: to this coverage")] = 1.0,
) -> Drawing:
    """Select items: inside a lasso or a rectangle, under the brush, the nearest, a layer's, by the tone beneath, all or none.

    A rectangle takes the first and last points of the path for corners, pick its first. Only what may change is selected.
    """
    found = {one.id: one.items for one in drawing.free(layer)}
    hit = _hit(drawing, found, by, path, size, low, high)
    changed = {}
    for one in drawing.free():
        old = one.items.selected
        if one.id not in hit and (by == "invert" or mode != "replace"):
            continue
        meant = hit.get(one.id, np.zeros(len(old), bool))
        new = {"replace": meant, "add": old | meant, "remove": old & ~meant}["replace" if by == "invert" else mode]
        if (new != old).any():
            changed[one.id] = one.items.having(slice(None), selected=new)
    return drawing.with_items(changed) if changed else drawing


def _hit(
    drawing: Drawing, found: dict[int, Items], by: str, path: tuple[float, ...] | None, size: float, low: float, high: float
) -> dict[int, Mask]:
    """Which items of these layers are meant."""
    if by in ("all", "layer", "none"):
        return {id: np.full(len(items), by != "none") for id, items in found.items()}
    if by == "invert":
        return {id: ~items.selected for id, items in found.items()}
    if by == "tone":
        tone, corner = drawing.toned(), drawing.picture.corner
        under = {id: tone.at(items.xy - corner) for id, items in found.items()}
        return {id: (low <= cover) & (cover <= high) for id, cover in under.items()}
    if by == "pick":
        return _picked(drawing, found, path)
    if by == "brush":
        brush = Brush.of(path, size)
        return {id: np.isin(np.arange(len(items)), brush.under(items.xy)[0]) for id, items in found.items()}
    if by == "rectangle":
        points, _ = way(path)
        area = shapely.box(*np.minimum(points[0], points[-1]), *np.maximum(points[0], points[-1]))
    else:
        area = outline(path)
    shapely.prepare(area)
    return {id: np.asarray(shapely.intersects_xy(area, *items.xy.T)) for id, items in found.items()}


def _picked(drawing: Drawing, found: dict[int, Items], path: tuple[float, ...] | None) -> dict[int, Mask]:
    """The one item whose centre is nearest to the path's first point, if the point is on it or nearly."""
    point = way(path)[0][0]
    hit = {id: np.zeros(len(items), bool) for id, items in found.items()}
    best = (np.inf, 0, 0)
    for id, items in found.items():
        if len(items):
            far = np.hypot(*(items.xy - point).T)
            far = np.where(far <= drawing.reach[items.kind] * items.mm + PICKED, far, np.inf)
            row = int(far.argmin())
            best = min(best, (float(far[row]), id, row))
    if best[0] < np.inf:
        hit[best[1]][best[2]] = True
    return hit
