"""Layers made to fit: cut clear of an area that must stay white, and finer by what ink gains on paper."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import shapely

from crowquill.hatching import covered
from crowquill.marks import Marks, whole
from crowquill.paths import Array, Paths
from crowquill.sheet import Bitmap, Layer
from crowquill.units import UM

FLAT = 1e-3  # mm that lines may stray from their curves


def cut(layer: Layer, white: shapely.Geometry) -> tuple[Layer, float, float]:
    """A layer of Paths without what lies on the white, and the length of strokes and the area of fills that did, mm and mm^2.

    Strokes are looked at on their middles. Where nothing lies on the white the layer is as it was; else lines come as open
    straight ones.
    """
    assert isinstance(layer.art, Paths)
    shapely.prepare(white)
    if layer.ink.pen is not None:
        paths, lost = _cut_lines(layer.art, white)
        return replace(layer, art=paths), lost, lost * layer.ink.pen
    filled, colours = areas(layer)
    if not len(filled) or not shapely.intersects(white, filled).any():
        return layer, 0.0, 0.0
    rest = shapely.difference(filled, white)
    return _of_areas(layer, rest, colours), 0.0, float(shapely.area(filled).sum() - shapely.area(rest).sum())


def finer(layer: Layer, gain: float) -> tuple[Layer, int]:
    """The layer so much finer that it prints as it is where every edge grows by the gain in mm, and how many areas nothing is left of.

    A dot's diameter, taken as that of a disc of its area, and a pen lose twice the gain; outlines of areas move in by it;
    words stay as they are. Raises ValueError for dots and pens that nothing is left of, where no area is left, and for pixels.
    """
    art, ink = layer.art, layer.ink
    if isinstance(art, Bitmap):
        raise ValueError("pixels of a device cannot be made finer; leave out ink-gain")
    for size in sizes(layer):
        left(size, gain)
    if ink.pen is not None:
        return replace(layer, ink=replace(ink, pen=float(whole(np.array(left(ink.pen, gain)))))), 0
    if isinstance(art, Marks):
        return replace(layer, art=replace(art, scale=np.where(art.scale > 0, art.scale - gain * np.sqrt(np.pi), 0.0))), 0
    if not isinstance(art, Paths):
        return layer, 0
    filled, colours = areas(layer)
    inner = shapely.buffer(filled, -gain, join_style="mitre")
    gone = int(shapely.is_empty(inner).sum())
    if gone and gone == len(filled):
        raise ValueError(f"an ink gain of {gain:g} mm leaves nothing of all {gone} areas; give less, or draw larger")
    return _of_areas(layer, inner, colours), gone


def left(size: float, gain: float) -> float:
    """What a gain leaves of a width in mm, or a ValueError."""
    if size - 2 * gain < UM:
        raise ValueError(f"an ink gain of {gain:g} mm leaves nothing of what is {size:.3g} mm wide; give less, or draw it wider")
    return size - 2 * gain


def sizes(layer: Layer) -> list[float]:
    """The width of a layer's pen, or of its smallest mark, in mm; of areas and words nothing is known."""
    if layer.ink.pen is not None:
        return [layer.ink.pen] if len(layer.art) else []
    scale = layer.art.scale[layer.art.scale > 0] if isinstance(layer.art, Marks) else np.empty(0)
    return [2 * float(scale.min()) / float(np.sqrt(np.pi))] if len(scale) else []


def snapped(lines: shapely.Geometry) -> shapely.Geometry:
    """The lines of some length joined end to end, in whole micrometres."""
    parts = shapely.get_parts(lines)
    parts = parts[shapely.get_dimensions(parts) == 1]
    joined = shapely.transform(shapely.line_merge(shapely.multilinestrings(shapely.get_parts(parts))), whole) if len(parts) else None
    parts = shapely.get_parts(joined)
    return shapely.multilinestrings(parts[shapely.length(parts) > 0])


def _cut_lines(paths: Paths, white: shapely.Geometry) -> tuple[Paths, float]:
    """Strokes without what lies on the white, and the length that did; those cut come as open straight lines."""
    flat = paths.flat(FLAT)
    lines = np.array([shapely.LineString(np.concatenate([line, line[:1]]) if paths.closed else line) for line in flat if len(line) > 1])
    touched = shapely.intersects(white, lines) if len(lines) else np.zeros(0, bool)
    if not touched.any():
        return paths, 0.0
    rest = lines.copy()
    rest[touched] = [snapped(part) for part in shapely.difference(lines[touched], white)]
    parts = shapely.get_parts(rest)
    parts = parts[~shapely.is_empty(parts)]
    lost = float(shapely.length(lines[touched]).sum() - shapely.length(rest[touched]).sum())
    return Paths.of([shapely.get_coordinates(part) for part in parts], closed=False), lost


def areas(layer: Layer) -> tuple[npt.NDArray[Any], Array | None]:
    """What a layer of filled Paths fills, as shapely Polygons, and the colour of each where they have their own."""
    assert isinstance(layer.art, Paths)
    flat = layer.art.flat(FLAT)
    if layer.fill is None:
        return covered(flat), None
    rings = shapely.make_valid(flat.polygons())
    parts, ring = shapely.get_parts(rings, return_index=True)
    good = shapely.area(parts) > 0
    return parts[good], layer.fill[ring[good]]


def _of_areas(layer: Layer, areas: npt.NDArray[Any], fill: Array | None) -> Layer:
    """The layer with these areas; where each ring has its own colour, those with holes are cut through them."""
    parts, area = shapely.get_parts(areas, return_index=True)
    keep = (shapely.get_dimensions(parts) == 2) & ~shapely.is_empty(parts)
    parts, area = parts[keep], area[keep]
    if fill is None:
        return replace(layer, art=Paths.of_polygons(parts)[0])
    halves = [(half, k) for part, k in zip(parts, area.tolist(), strict=True) for half in _simple(part)]
    rings, which = Paths.of_polygons(np.array([half for half, _ in halves], object))
    return replace(layer, art=rings, fill=fill[np.array([k for _, k in halves], np.int64)[which]])


def _simple(area: shapely.Polygon) -> list[shapely.Polygon]:
    """An area in pieces without holes, cut from top to bottom through the middle of the first of each."""
    if not area.interiors:
        return [area]
    left, top, right, bottom = area.bounds
    middle = area.interiors[0].centroid.x
    halves = [shapely.intersection(area, shapely.box(*side)) for side in ((left, top, middle, bottom), (middle, top, right, bottom))]
    pieces = [part for half in halves for part in shapely.get_parts(half) if part.geom_type == "Polygon"]
    return [piece for part in pieces for piece in _simple(part)]
