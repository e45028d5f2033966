"""Operations that move, turn and resize items."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Annotated

import numpy as np

from crowquill.editor.brushes import FAR, Brush, Falloff, Meant, OfLayer, Path, Size, Strength
from crowquill.editor.drawing import Drawing, Layer
from crowquill.editor.fields import flow
from crowquill.editor.items import Items
from crowquill.editor.operations import on_meant, operation
from crowquill.field import between
from crowquill.knobs import Choice, Range
from crowquill.paths import Array, Index
from crowquill.tone import Tone

Length = Annotated[float, Range(-FAR, FAR, "mm", "to the right")]
Down = Annotated[float, Range(-FAR, FAR, "mm", "down")]


@operation("brush")
def push(
    drawing: Drawing,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    path: Path = None,
    size: Size = 5.0,
    strength: Strength = 1.0,
    falloff: Falloff = "smooth",
    layer: OfLayer = None,
) -> Drawing:
    """Drag what is under the brush along its way."""
    brush = Brush.of(path, size, strength, falloff)
    by = {}
    for found in drawing.free(layer):
        rows = brush.near(found.items.xy)
        rows = rows[~found.items.frozen[rows]]
        xy = found.items.xy[rows]
        for here, there, pressure in zip(brush.points, brush.points[1:], brush.pressure, strict=False):
            weight = brush.strength * pressure * brush.profile(np.hypot(*(xy - here).T))
            xy = xy + weight[:, None] * (there - here)
        moved = (xy != found.items.xy[rows]).any(axis=1)
        if moved.any():
            by[found.id] = found.items.posed(rows[moved], xy=drawing.clipped(xy[moved]))
    return drawing.with_items(by) if by else drawing


@on_meant("brush")
def attract(
    meant: Meant,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    reach: Annotated[float, Range(0.05, 50, "mm", "how far around a mark the tone is looked at")] = 1.0,
) -> Drawing:
    """Move marks towards the ink that the picture asks for around them.

    Each goes to the mean of the places around it, weighed by coverage and by a Gaussian of the reach; where that finds no ink it stays.
    Source: K. Fukunaga, L. Hostetler, The Estimation of the Gradient of a Density Function, IEEE IT 21(1), 1975.
    """
    drawing, tone, corner = meant.drawing, meant.drawing.toned(), meant.drawing.picture.corner

    def moved(found: Layer, rows: Index, weight: Array) -> Items:
        xy = found.items.xy[rows]
        way = np.stack([between(part, tone.size, xy - corner) for part in pulls(tone, reach)], axis=1)
        return found.items.posed(rows, xy=drawing.clipped(xy + weight[:, None] * way))

    return meant.changed(moved)


@lru_cache(2)
def pulls(tone: Tone, reach: float) -> tuple[Array, Array]:
    """How far right and down of each pixel's centre the mean place around it lies, mm, by coverage times a Gaussian of a reach in mm.

    It is the Gaussian's variance times the gradient of the logarithm of the blurred coverage.
    """
    from scipy.ndimage import gaussian_filter

    sigma = [reach / side for side in reversed(tone.pixel)]
    around = gaussian_filter(tone.coverage * tone.inside, sigma, mode="constant")
    some = np.where(around > 1e-6, around, np.inf)
    x, y = (
        reach**2 * gaussian_filter(tone.coverage * tone.inside, sigma, order=order, mode="constant") / side / some
        for order, side in zip(((0, 1), (1, 0)), tone.pixel, strict=True)
    )
    return x, y


@on_meant("brush")
def jitter(
    meant: Meant,
    rng: np.random.Generator,
    *,
    amount: Annotated[float, Range(0, 50, "mm", "how far, on the mean about")] = 0.1,
) -> Drawing:
    """Shake marks off their places, each its own way."""

    def moved(found: Layer, rows: Index, weight: Array) -> Items:
        off = rng.normal(0, amount, (len(rows), 2)) * weight[:, None]
        return found.items.posed(rows, xy=meant.drawing.clipped(found.items.xy[rows] + off))

    return meant.changed(moved)


@on_meant("brush")
def resize(
    meant: Meant,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    factor: Annotated[float, Range(0.1, 10, "", "over 1 larger, below smaller")] = 1.1,
) -> Drawing:
    """Make marks larger or smaller."""

    def made(found: Layer, rows: Index, weight: Array) -> Items:
        return found.items.posed(rows, mm=np.minimum(found.items.mm[rows] * factor**weight, max(meant.drawing.size)))

    return meant.changed(made)


@on_meant("brush")
def turn(
    meant: Meant,
    rng: np.random.Generator,
    *,
    by: Annotated[str, Choice(("angle", "random", "flow", "stroke"), "by an angle, by chance, or along the picture or the way")] = "angle",
    angle: Annotated[float, Range(-360, 360, "deg", "from right towards down")] = 15.0,
) -> Drawing:
    """Turn marks about their centres: by an angle, or their long axes along the picture's flow or the brush's way."""
    drawing = meant.drawing
    if by == "stroke" and meant.brush is None:
        raise ValueError("by stroke takes a brush with a way; turn along the flow, or by an angle")

    def turned(found: Layer, rows: Index, weight: Array) -> Items:
        items = found.items
        if by == "angle":
            way = np.radians(angle) * weight
        elif by == "random":
            way = rng.uniform(-np.pi, np.pi, len(rows)) * weight
        else:
            axes = np.array([drawing.kinds[k].axis for k in items.kind[rows]])
            wanted = meant.brush.heading(items.xy[rows]) if by == "stroke" and meant.brush else flow(drawing, items.xy[rows])
            way = weight * _half_turn(wanted - items.angle[rows] - axes)
        return items.posed(rows, angle=items.angle[rows] + way)

    return meant.changed(turned)


def _half_turn(angle: Array) -> Array:
    """The angles less whole half turns, from -90 to 90 degrees: an axis has no ends."""
    return np.asarray((angle + np.pi / 2) % np.pi - np.pi / 2)


@operation("select")
def move(
    drawing: Drawing,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    dx: Length = 0.0,
    dy: Down = 0.0,
    angle: Annotated[float, Range(-360, 360, "deg", "turn it about its middle too")] = 0.0,
) -> Drawing:
    """Move the selection, and turn it as a whole about the middle of its box."""
    chosen = {layer.id: (layer.items, layer.items.selected & ~layer.items.frozen) for layer in drawing.free()}
    every = np.concatenate([np.empty((0, 2)), *(items.xy[mask] for items, mask in chosen.values())])
    if not len(every):
        return drawing
    middle = (every.min(axis=0) + every.max(axis=0)) / 2
    cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    by = {}
    for id, (items, mask) in chosen.items():
        x, y = (items.xy[mask] - middle).T
        xy = np.stack([cos * x - sin * y, sin * x + cos * y], axis=1) + middle + (dx, dy)
        by[id] = items.posed(mask, xy=drawing.clipped(xy), angle=items.angle[mask] + np.radians(angle))
    return drawing.with_items(by)


@operation("select")
def duplicate(
    drawing: Drawing,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    dx: Length = 2.0,
    dy: Down = 2.0,
) -> Drawing:
    """Duplicate the selection, so far off; the copies are then what is selected."""
    for layer in list(drawing.free()):
        mask = layer.items.selected
        if mask.any():
            copies, n = layer.items.take(mask), int(mask.sum())
            new = np.arange(drawing.first, drawing.first + n)
            copies = replace(copies, id=new, frozen=np.zeros(n, bool)).posed(
                slice(None), xy=drawing.clipped(copies.xy + np.array([dx, dy]))
            )
            drawing = drawing.added(replace(layer, items=layer.items.having(mask, selected=False)), copies)
    return drawing
