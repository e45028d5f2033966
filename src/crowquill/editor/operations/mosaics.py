"""Operations on tiles: laid over a canvas, moved as in a mosaic, and cut to stones in the picture's colours.

Source: A. Hausner, Simulating Decorative Mosaics, SIGGRAPH 2001.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Annotated

import numpy as np
import shapely

from crowquill import laying, tiles
from crowquill import relax as dots
from crowquill.editor.brushes import Path, outline
from crowquill.editor.drawing import Drawing, Layer, Tiling
from crowquill.editor.items import Items, Kind, colours
from crowquill.editor.operations import operation
from crowquill.knobs import Range
from crowquill.marks import Glyph
from crowquill.paths import Array, Index, Paths
from crowquill.sheet import Ink, on_screen
from crowquill.styles import mosaic
from crowquill.tesserae import Ground, Progress, Tiles
from crowquill.tone import Tone

Weights = dict[int, tuple[Index, Array]]


@lru_cache(4)
def ground(tone: Tone, tiling: Tiling) -> Ground:
    """What tiles of a tone are laid on, with its edges, mm from the picture's corner."""
    return mosaic.laid_out(tone, tiling.side, None, tiling.gap, tiling.aspect, "found")


def stepped(drawing: Drawing, weights: Weights, wall: bool, off_edges: bool) -> Drawing:
    """A step of Hausner's: tiles move to the centroid of what is nearest to them by their own metric, turn along edges, and take the size
    that is wished for there. Those that nothing belongs to go. Only layers of tiles take part.
    """
    by, facts = {}, {}
    tone, corner = drawing.toned(wall), drawing.picture.corner
    for layer in drawing.free():
        rows, weight = weights.get(layer.id, (np.zeros(0, np.int64), np.zeros(0)))
        if layer.tiling is None or not len(rows):
            continue
        base, items = ground(tone, layer.tiling), layer.items
        xy = items.xy - corner
        centre, some, energy = laying.centred(base, tone, xy, laying.off_edges(base) if off_edges else base.inside)
        way = weight[:, None] * (centre - xy)[rows]
        placed = xy[rows] + way
        posed = items.posed(rows, xy=drawing.clipped(placed + corner), mm=_scale(base, placed), angle=base.angles(placed))
        stay = np.ones(len(items), bool)
        stay[rows] = some[rows]
        by[layer.id] = posed.take(stay)
        facts = {"energy": energy, "movement": float(np.hypot(*way.T).mean() / base.mean)}
    if not by:
        raise ValueError("there are no tiles here; lay some, or take another variant")
    return replace(drawing.with_items(by), facts=facts)


def _scale(base: Ground, xy: Array) -> Array:
    """The scale of a tile at each place: the root of its area, mm."""
    return np.asarray(np.sqrt(base.sides(xy).prod(axis=1)))


@operation("relax")
def tile(
    drawing: Drawing,
    rng: np.random.Generator,
    *,
    side: Annotated[float, Range(0.2, 500, "mm", "side of a square tile as large")] = 3.0,
    aspect: Annotated[float, Range(0.2, 5, "", "length along the rows over width")] = 1.0,
    gap: Annotated[float, Range(0, 50, "mm", "grout between tiles")] = 0.3,
    path: Path = None,
    layer: Annotated[int | None, Range(1, 10**6, "", "a layer of tiles; left out, a new one")] = None,
) -> Drawing:
    """Lay tiles at random over the canvas, or within a path drawn; finer ones where it is important. Relax them as a mosaic.

    Tiles that were there go. In a layer of tiles its own side, aspect and gap are kept to.
    """
    found = None if layer is None else next(drawing.free(layer))
    if found and found.tiling is None:
        raise ValueError(f"layer {found.name!r} has no tiles; leave the layer out for a new one")
    tiling = found.tiling if found and found.tiling else Tiling(side, aspect, gap)
    whole, corner = drawing.toned(), drawing.picture.corner
    base = ground(whole, tiling)
    demand, count = base.crowd(whole)
    if path is not None:
        area = shapely.intersection(shapely.transform(outline(path), lambda xy: xy - corner), whole.canvas)
        if not shapely.area(area) > 0:
            raise ValueError("path encloses nothing of the canvas; draw it over the picture")
        demand = replace(demand, canvas=area)
        count = max(1, round(demand.ink * base.finest**2 / float(np.prod(base.pitch))))
    xy = dots.scatter(demand, count, rng)
    kind = Kind.of_glyph(Glyph(Paths.of([_rectangle(tiling.aspect)]), 2 / float(np.sqrt(np.pi))), "tile")
    drawing, at = drawing.with_kinds((kind,))
    if found is None:
        found = Layer(drawing.next_layer, "tiles", Ink(), Items.none(), tiling=tiling)
        drawing = replace(drawing, layers=(*drawing.layers, found), next_layer=drawing.next_layer + 1)
    gone = shapely.intersects_xy(demand.canvas, *(found.items.xy - corner).T) & ~found.items.frozen
    new = Items.of(drawing.first, xy + corner, scale=_scale(base, xy), angle=base.angles(xy), kind=at[0])
    return replace(drawing.added(replace(found, items=found.items.take(~gone)), new), facts={"tiles": len(xy)})


def _rectangle(aspect: float) -> Array:
    """The corners of a rectangle of area 1 mm^2, the long side given by length over width."""
    return np.asarray(np.array([(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]) * (aspect**0.5, aspect**-0.5), np.float64)


@operation("relax")
def cut(
    drawing: Drawing,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    layer: Annotated[int | None, Range(1, 10**6, "", "a layer of tiles; left out, the topmost")] = None,
    grow: Annotated[float, Range(0.5, 1.5, "", "how large tiles begin before they are cut, over what fits")] = 1.3,
    white: Annotated[float, Range(0, 1, "", "no stones where coverage is below on the mean")] = 0.02,
) -> Drawing:
    """Cut tiles to stones that overlap nowhere and cross no edge, in the picture's colours; hollows get stones of their own.

    They take the place of the tiles, each a shape of its own.
    """
    there = [one for one in drawing.free(layer) if one.tiling]
    if not there or there[-1].tiling is None:
        raise ValueError("there are no tiles to cut; lay some")
    found, tone, corner = there[-1], drawing.toned(), drawing.picture.corner
    base, items = ground(tone, there[-1].tiling), there[-1].items
    root = np.sqrt(np.array([base.pitch[0] / base.pitch[1], base.pitch[1] / base.pitch[0]]))
    laid = Tiles(items.xy - corner, items.angle, items.mm[:, None] * root)
    stones, _, slivers = mosaic.cut(base, Progress(0, laid), grow)
    rings = tiles.rings_of(stones)
    drawn = tiles.means(rings, tone.coverage, tone.size) >= white - mosaic.ROUNDING
    rings = rings.take(np.flatnonzero(drawn & (rings.areas > 0)))
    fill = colours(on_screen(mosaic.painted(rings, tone, False)))
    centre = np.round(shapely.get_coordinates(shapely.centroid(rings.polygons())), 3)
    first = drawing.next_layer
    kinds = [Kind(Paths.of([np.round(ring - at, 3)])) for ring, at in zip(rings, centre, strict=True)]
    drawing, at = drawing.with_kinds(kinds)
    new = Items.of(drawing.first, centre + corner, scale=1.0, kind=at, fill=fill)
    stone = Layer(first, "stones", found.ink, new)
    layers = tuple(stone if one.id == found.id else one for one in drawing.layers)
    facts = {"stones": len(new), "slivers": slivers}
    return replace(drawing, layers=layers, next_layer=first + 1, first=drawing.first + len(new), facts=facts)
