"""The operation that gives a drawing another paper."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np
import shapely

from crowquill import units
from crowquill.editor.drawing import FULL, Drawing, Layer, Map, Picture
from crowquill.editor.operations import operation
from crowquill.knobs import Choice, Flag, Range, Text
from crowquill.marks import Marks
from crowquill.paths import Array, Paths
from crowquill.sheet import Art, Bitmap, check_fit, shifted, turned

FILLS = 1e-3  # a picture that leaves no more of its room than this part fills it
BAR = "check bar"  # what the layer is called whose length must stay what it says


@operation("paper")
def paper(
    drawing: Drawing,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    paper: Annotated[str | None, Text("a4, a5, letter, or a size such as 120x80mm; left out, as it is")] = None,
    orientation: Annotated[str, Choice(("auto", "portrait", "landscape"), "how it lies; auto suits the drawing")] = "auto",
    margin: Annotated[float | None, Range(0, 10_000, "mm", "white kept around the drawing; left out, as it is")] = None,
    scale: Annotated[bool | None, Flag("as large as there is room for, marks and pens too")] = None,
) -> Drawing:
    """Put the drawing in the middle of another paper.

    It keeps its size, but where `scale` says otherwise; left out, a picture that filled its room does so again, if nothing is drawn
    yet. Raises ValueError for a paper on which it has no room.
    """
    art = drawing.picture.size
    units.paper(paper or "a4")
    size = turned(paper or drawing.size, art, orientation)
    edge = drawing.margin if margin is None else margin
    room = np.array(size) - 2 * (edge or 0.0)
    if min(room) <= 0:
        raise ValueError(f"a margin of {edge:g} mm leaves no room on a paper of {size[0]:g} x {size[1]:g} mm; make it smaller")
    if scale is None and not _is_bare(drawing):
        old = (np.array(drawing.size) - 2 * (drawing.margin or 0.0)) / art
        scale = abs(min(old) - 1) <= FILLS and not any(len(layer.items) or layer.still for layer in drawing.layers if not _is_bar(layer))
    move = _Move(drawing, size, edge, float(min(room / art)) if scale else 1.0)
    if not _is_bare(drawing):
        check_fit(move.art, size, edge or 0.0)
    made = replace(drawing, layers=tuple(map(move.layer, drawing.layers)), size=size, margin=edge, recipe=move.recipe)
    made = replace(made, picture=move.picture, tone=move.map(drawing.tone, 0))
    off = sum(int(((layer.items.xy < 0) | (layer.items.xy > size)).any(axis=1).sum()) for layer in made.layers)
    if off:
        raise ValueError(f"{off} marks would lie off a paper of {size[0]:g} x {size[1]:g} mm; scale the drawing, or give a larger paper")
    wish = None if drawing.wish is None else move.map(drawing.wish, FULL // 2)
    return replace(made, wish=wish, wall=None if drawing.wall is None else move.paths(drawing.wall))


def _is_bare(drawing: Drawing) -> bool:
    """Whether no picture lies beneath, so that all the paper is drawn on."""
    picture = drawing.picture
    return picture.rgb is None and picture.size == drawing.size and not picture.corner.any()


def _is_bar(layer: Layer) -> bool:
    return layer.name.startswith(BAR)


@dataclass(frozen=True, eq=False)
class _Move:
    """A drawing on its way to a paper of `size` mm: all becomes `factor` times as large, and lies in the middle."""

    drawing: Drawing
    size: tuple[float, float]
    margin: float | None
    factor: float

    @property
    def art(self) -> tuple[float, float]:
        """What the picture's rectangle measures then, mm."""
        width, height = self.drawing.picture.size
        return width * self.factor, height * self.factor

    @cached_property
    def corner(self) -> Array:
        """Where its corner lies then, mm."""
        return np.asarray(np.round((np.array(self.size) - self.art) / 2, 3))

    @property
    def offset(self) -> Array:
        """Where a mark goes that is at 0, mm."""
        return self.corner - self.drawing.picture.corner * self.factor

    @property
    def picture(self) -> Picture:
        """What lies beneath then."""
        if _is_bare(self.drawing):
            return Picture(np.zeros(2), self.size, shapely.box(0, 0, *self.size))
        old = self.drawing.picture
        canvas = old.canvas if self.factor == 1 else shapely.transform(old.canvas, lambda xy: xy * self.factor)
        return Picture(self.corner, self.art, canvas, old.rgb)

    @property
    def recipe(self) -> Mapping[str, Any]:
        """What files say of the paper and the picture's place, where they do."""
        picture = self.picture
        told = {"art_mm": list(picture.size), "art_at_mm": picture.corner.tolist(), "paper_mm": list(self.size)}
        return {**self.drawing.recipe, **{key: value for key, value in told.items() if key in self.drawing.recipe}}

    def map(self, old: Map, outside: int) -> Map:
        """A map on the new rectangle: the same, but where all the paper is drawn on, and there is more or less of it now."""
        if not _is_bare(self.drawing):
            return old
        shape = np.array(old.values.shape)
        was = np.array(self.drawing.size)[::-1] / shape  # mm of a pixel, down and across
        count = np.maximum(1, np.round(np.array(self.size)[::-1] / (was * self.factor))).astype(np.int64)
        values = old.values
        for axis, n in enumerate(count.tolist()):
            middle = (np.arange(n) + 0.5) * self.size[1 - axis] / n - self.offset[1 - axis]
            at = np.floor(middle / (was[axis] * self.factor)).astype(np.int64)
            inside = (at >= 0) & (at < shape[axis])
            values = np.take(values, np.clip(at, 0, shape[axis] - 1), axis=axis)
            values[~inside if axis == 0 else (slice(None), ~inside)] = outside
        return Map(values)

    def layer(self, old: Layer) -> Layer:
        """A layer on the new paper; a check bar stays as long as it is, and in its corner."""
        if _is_bar(old) and old.still is None and self.drawing.margin is not None and self.margin is not None:
            now = np.array((self.margin, self.size[1] - self.margin / 2))
            was = (self.drawing.margin, self.drawing.size[1] - self.drawing.margin / 2)
            return replace(old, items=old.items.posed(slice(None), xy=old.items.xy + (now - was), frozen=True))
        items = old.items
        larger = items.mm * self.factor if self.factor != 1 else None
        items = items.posed(slice(None), xy=items.xy * self.factor + self.offset, mm=larger, frozen=True)
        tiling, ink, still = old.tiling, old.ink, old.still
        if self.factor != 1:
            ink = ink if ink.pen is None else replace(ink, pen=ink.pen * self.factor)
            tiling = tiling and replace(tiling, side=tiling.side * self.factor, gap=tiling.gap * self.factor)
        return replace(old, items=items, ink=ink, tiling=tiling, still=still and replace(still, ink=ink, art=self._art(still.art)))

    def paths(self, old: Paths) -> Paths:
        """Outlines on the new paper."""
        return old.moved(np.eye(2) * self.factor, self.offset)

    def _art(self, old: Art) -> Art:
        if self.factor == 1:
            return shifted(old, self.offset)
        if isinstance(old, Paths):
            return self.paths(old)
        if isinstance(old, Bitmap):
            return replace(old, dpi=old.dpi / self.factor, corner=old.corner * self.factor + self.offset)
        xy = old.xy * self.factor + self.offset
        return (
            replace(old, xy=xy, scale=old.scale * self.factor)
            if isinstance(old, Marks)
            else replace(old, xy=xy, size=old.size * self.factor)
        )
