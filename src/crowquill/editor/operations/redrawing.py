"""Operations that draw a region anew: one for each style, with the style's own knobs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, cast

import numpy as np
import shapely

from crowquill import styles
from crowquill.editor.brushes import Path, outline
from crowquill.editor.drawing import Drawing, Layer
from crowquill.editor.operations import STYLE, Operation, Work, add
from crowquill.editor.reading import itemised
from crowquill.paths import Array
from crowquill.sheet import shifted


def redraw(style: str, drawing: Drawing, rng: np.random.Generator, *, path: Path = None, **knobs: Any) -> Work:
    """Draw a region anew in a style: what lies in the path drawn, or on the canvas, goes, if it may change."""
    tone, corner = drawing.toned(), drawing.picture.corner
    tone = tone if styles.coloured(style) else replace(tone, rgb=None)
    if path is not None:
        area = shapely.intersection(shapely.transform(outline(path), lambda xy: xy - corner), tone.canvas)
        if not shapely.area(area) > 0:
            raise ValueError("path encloses nothing of the canvas; draw it over the picture")
        tone = replace(tone, canvas=area)
    seed = cast(int, cast(np.random.SeedSequence, rng.bit_generator.seed_seq).entropy)  # so that a style draws as it does by itself
    sheet = yield from styles.steps(style, tone, seed=seed, **knobs)
    drawing = _emptied(drawing, tone.canvas, corner)
    for layer in sheet.layers:
        drawing, found = itemised(drawing, replace(layer, art=shifted(layer.art, corner)))
        drawing = _placed(drawing, found)
    return replace(drawing, notes=tuple(str(text) for text in sheet.report.get("warnings", ())))


def _emptied(drawing: Drawing, area: shapely.Geometry, corner: Array) -> Drawing:
    """The drawing without what has its centre in an area and may change."""
    shapely.prepare(area)
    by = {}
    for layer in drawing.free():
        gone = shapely.intersects_xy(area, *(layer.items.xy - corner).T) & ~layer.items.frozen
        if gone.any():
            by[layer.id] = layer.items.take(~gone)
    return drawing.with_items(by)


def _placed(drawing: Drawing, found: Layer) -> Drawing:
    """The drawing with a new layer; its items go into one of the same name and ink that may change, if there is one."""
    if not found.still:
        for layer in drawing.free():
            if (layer.name, layer.ink, layer.tiling) == (found.name, found.ink, None):
                return drawing.added(layer, found.items)
    whole = replace(drawing, layers=(*drawing.layers, replace(found, id=drawing.next_layer)), next_layer=drawing.next_layer + 1)
    return replace(whole, first=whole.first + len(found.items))


def _knobs(style: str) -> Callable[[], dict[str, Any]]:
    return partial(styles.knobs, style)


for _style in styles.names():
    add(Operation(f"{STYLE}{_style}", "style", partial(redraw, _style), styles.summary(_style), more=_knobs(_style)))
