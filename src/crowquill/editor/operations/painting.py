"""The operation that paints tone or importance."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import numpy as np

from crowquill.editor.brushes import Brush, Falloff, Path, Size, Strength
from crowquill.editor.drawing import FULL, Drawing, Map
from crowquill.editor.operations import operation
from crowquill.knobs import Choice, Range


@operation("map")
def paint(
    drawing: Drawing,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    path: Path = None,
    size: Size = 10.0,
    strength: Strength = 0.5,
    falloff: Falloff = "smooth",
    map: Annotated[str, Choice(("tone", "importance"), "what is painted")] = "tone",
    value: Annotated[float, Range(0, 1, "", "coverage, or importance: one half is neither more nor less")] = 1.0,
) -> Drawing:
    """Paint tone, which weighted relaxation and styles follow, or importance, where tiles and dots become finer."""
    brush, shape = Brush.of(path, size, strength, falloff), drawing.tone.values.shape
    old = drawing.tone if map == "tone" else drawing.wish or Map(np.full(shape, FULL // 2, np.uint16))
    pixel, corner = np.array(drawing.picture.size) / shape[::-1], drawing.picture.corner
    low, high = brush.points.min(axis=0) - brush.radius - corner, brush.points.max(axis=0) + brush.radius - corner
    left, top = np.clip(np.floor(low / pixel), 0, shape[::-1]).astype(np.int64)
    right, bottom = np.clip(np.ceil(high / pixel), 0, shape[::-1]).astype(np.int64)
    x, y = np.meshgrid((np.arange(left, right) + 0.5) * pixel[0], (np.arange(top, bottom) + 0.5) * pixel[1])
    rows, weight = brush.under(np.stack([x.ravel(), y.ravel()], axis=1) + corner)
    if not len(rows):
        return drawing
    values = old.values.copy()
    part = values[top:bottom, left:right].ravel()
    part[rows] = np.round(part[rows] + weight * (value * FULL - part[rows])).astype(np.uint16)
    values[top:bottom, left:right] = part.reshape(bottom - top, right - left)
    return replace(drawing, tone=Map(values)) if map == "tone" else replace(drawing, wish=Map(values))
