"""From sheets to layers of items: what of a drawing can be edited, and what stays as it is."""

from __future__ import annotations

import numpy as np

from crowquill import sheet
from crowquill.editor.drawing import Drawing, Layer
from crowquill.editor.items import Items, Kind, colours
from crowquill.inertia import of_sides, pooled
from crowquill.marks import Marks
from crowquill.moments import of_rings
from crowquill.paths import Array, Index, Paths

MOST = 50_000  # outlines of a layer that are items of their own; of more the layer stays as it is


def itemised(drawing: Drawing, layer: sheet.Layer) -> tuple[Drawing, Layer]:
    """The drawing with the kinds that a sheet's layer takes, and the layer with items for its marks, or for its outlines.

    The items' ids begin at the drawing's next, which stays what it is, and so does the layer's. A ring that turns back is a hole of
    the one before. Bitmaps, words, and more outlines than can be told apart stay as they are.
    """
    art = layer.art
    if isinstance(art, Marks):
        drawing, at = drawing.with_kinds([Kind.of_glyph(glyph) for glyph in art.glyphs])
        kind = at[art.glyph] if len(at) else np.zeros(0, np.int64)
        return drawing, _layer(drawing, layer, Items.of(drawing.first, art.xy, scale=art.scale, angle=art.angle, kind=kind))
    if not isinstance(art, Paths) or len(art) > MOST:
        return drawing, Layer(drawing.next_layer, layer.name, layer.ink, Items.none(), still=layer)
    filled = np.flatnonzero(np.diff(art.start))
    art = art.take(filled)
    holes = art.areas < 0 if art.closed and layer.ink.pen is None and layer.fill is None else np.zeros(len(art), bool)
    of = np.maximum(np.cumsum(~holes) - 1, 0)
    fill = 0 if layer.fill is None else colours(sheet.on_screen(layer.fill[filled]))
    drawing, items = outlined(drawing, art, of, fill)
    return drawing, _layer(drawing, layer, items)


def _layer(drawing: Drawing, layer: sheet.Layer, items: Items) -> Layer:
    return Layer(drawing.next_layer, layer.name, layer.ink, items)


def outlined(drawing: Drawing, paths: Paths, of: Index, fill: int | Array = 0) -> tuple[Drawing, Items]:
    """The drawing with the kinds that paths take, and an item for each group of them: `of` (n,) says the group, rising from 0."""
    n = int(of[-1]) + 1 if len(of) else 0
    first = paths.xy[paths.start[:-1]]
    about = first[np.searchsorted(of, np.arange(n))]
    if paths.closed:
        parts, owner = of_rings(paths, first), of
    else:
        flat = paths.flat(0.01) if paths.cubic else paths
        parts = of_sides(flat)
        inner = np.ones(len(flat.xy), bool)
        inner[flat.start[1:] - 1] = False
        owner = of[flat.path[inner]]
    centre = np.round(pooled(parts, owner, n, about).centroid, 3)
    bounds = np.searchsorted(of, np.arange(n + 1))
    kinds = []
    for k in range(n):
        part = paths.take(np.arange(bounds[k], bounds[k + 1]))
        kinds.append(Kind(Paths(np.round(part.xy - centre[k], 3), part.start, part.closed, part.cubic)))
    drawing, at = drawing.with_kinds(kinds)
    return drawing, Items.of(drawing.first, centre, scale=1.0, kind=at, fill=fill)
