"""A drawing under the pen: layers of items over a picture, all of it frozen, so that to undo is to keep what was."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, reduce
from typing import Any

import numpy as np
import numpy.typing as npt
import shapely

from crowquill import sheet
from crowquill.editor.items import OWN, Items, Kind
from crowquill.marks import Marks
from crowquill.paths import Array, Index, Paths
from crowquill.sheet import Ink, Sheet
from crowquill.stippling import importance
from crowquill.tone import Tone

FULL = 65535  # of a map: the share 1


@dataclass(frozen=True, eq=False)
class Map:
    """Shares (h, w) laid over the picture's rectangle, in 65535ths."""

    values: npt.NDArray[np.uint16]

    def __post_init__(self) -> None:
        self.values.setflags(write=False)

    @classmethod
    def of(cls, shares: Array) -> Map:
        """The map of shares of 0 to 1."""
        return cls(np.round(np.asarray(shares) * FULL).astype(np.uint16))


@dataclass(frozen=True, eq=False)
class Layer:
    """Items of one ink. `still` is art that is shown and written, and not edited.

    tiling  what its items are tiles of, where they are
    """

    id: int
    name: str
    ink: Ink
    items: Items
    hidden: bool = False
    locked: bool = False
    tiling: Tiling | None = None
    still: sheet.Layer | None = None

    @property
    def is_free(self) -> bool:
        """Whether its items may change."""
        return not (self.hidden or self.locked or self.still)


@dataclass(frozen=True)
class Tiling:
    """Tiles side by side: the side of a square of their area in mm, length over width, and the grout between them in mm."""

    side: float
    aspect: float
    gap: float


@dataclass(frozen=True, eq=False)
class Picture:
    """What lies beneath: a rectangle of `size` mm with its corner (2,) mm on the sheet, and in it the canvas.

    canvas  shapely, mm from the rectangle's corner
    rgb     (h, w, 3) colours, or None without a picture
    """

    corner: Array
    size: tuple[float, float]
    canvas: shapely.Geometry
    rgb: npt.NDArray[np.uint8] | None = None

    @cached_property
    def placed(self) -> shapely.Geometry:
        """The canvas on the sheet."""
        return shapely.transform(self.canvas, lambda xy: xy + self.corner)


@dataclass(frozen=True, eq=False)
class Drawing:
    """All that operations change, and what the last of them found.

    size        (width, height) mm of the paper
    layers      from the bottom up; `kinds` are the shapes of their items
    tone        coverage; `wish` the importance, or None without one
    wall        rings drawn on the sheet, mm, within which relaxation stays, or None
    first       the id that the next item gets; next_layer that of a layer
    facts       figures of the last operation; notes, texts to be shown
    """

    size: tuple[float, float]
    picture: Picture
    tone: Map
    layers: tuple[Layer, ...] = ()
    kinds: tuple[Kind, ...] = ()
    wish: Map | None = None
    wall: Paths | None = None
    first: int = 0
    next_layer: int = 1
    margin: float | None = None
    recipe: Mapping[str, Any] = field(default_factory=dict)
    facts: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def layer(self, id: int | None) -> Layer:
        """The layer of an id, None being the topmost that may change. Raises ValueError where there is none."""
        found = [layer for layer in self.layers if layer.id == id or (id is None and layer.is_free)]
        if not found:
            raise ValueError("there is no layer to draw on; add one" if id is None else f"there is no layer {id}; refresh the page")
        return found[-1]

    def free(self, id: int | None = None) -> Iterator[Layer]:
        """The layers whose items may change, or that of an id. Raises ValueError for one that may not."""
        if id is None:
            yield from (layer for layer in self.layers if layer.is_free)
        elif not (layer := self.layer(id)).is_free:
            why = "is not edited here" if layer.still else f"is {'hidden' if layer.hidden else 'locked'}; show or unlock it first"
            raise ValueError(f"layer {layer.name!r} {why}")
        else:
            yield layer

    def with_layers(self, *changed: Layer) -> Drawing:
        """The drawing with these layers in place of those with their ids."""
        by = {layer.id: layer for layer in changed}
        return replace(self, layers=tuple(by.get(layer.id, layer) for layer in self.layers))

    def with_items(self, changed: Mapping[int, Items]) -> Drawing:
        """The drawing with these items in the layers of these ids."""
        return self.with_layers(*(replace(layer, items=changed[layer.id]) for layer in self.layers if layer.id in changed))

    def added(self, layer: Layer, items: Items) -> Drawing:
        """The drawing with new items in a layer; their ids are the next."""
        whole = Items.joined([layer.items, items])
        return replace(self.with_layers(replace(layer, items=whole)), first=self.first + len(items))

    def with_kinds(self, kinds: Sequence[Kind]) -> tuple[Drawing, Index]:
        """The drawing with these kinds among its own, each outline once, and where each is."""
        known = dict(self._places)
        new: list[Kind] = []
        for kind in kinds:
            if kind.key not in known:
                known[kind.key] = len(self.kinds) + len(new)
                new.append(kind)
        at = np.array([known[kind.key] for kind in kinds], np.int64)
        return (replace(self, kinds=(*self.kinds, *new)) if new else self), at

    @cached_property
    def _places(self) -> dict[bytes, int]:
        return {kind.key: k for k, kind in enumerate(self.kinds)}

    @property
    def reach(self) -> Array:
        """The reach of each kind at scale 1, mm."""
        return np.array([kind.reach for kind in self.kinds], np.float64)

    def toned(self, wall: bool = False) -> Tone:
        """Coverage, importance and colours in the picture's rectangle, on the canvas or what of it lies in the wall."""
        return _toned(self.picture, self.tone, self.wish, self._wall if wall else None)

    def weight(self, exponent: float, wall: bool = False) -> Tone:
        """The coverage, more where it is important, to a power: what relaxation weighs cells by. One pixel where it is the same all over.

        Raises ValueError where the wall is none, or encloses nothing of the canvas.
        """
        return _weight(self.picture, self.tone, self.wish, self._wall if wall else None, exponent)

    @property
    def _wall(self) -> Paths:
        if self.wall is None:
            raise ValueError("no wall is drawn; draw one, or relax within the canvas")
        return self.wall

    def clipped(self, xy: Array) -> Array:
        """The places, those off the paper at its edge."""
        return np.clip(xy, 0.0, self.size)


@lru_cache(4)
def _toned(picture: Picture, tone: Map, wish: Map | None, wall: Paths | None) -> Tone:
    canvas = picture.canvas if wall is None else _walled(picture, wall)
    return Tone(tone.values / FULL, picture.size, canvas, None if wish is None else wish.values / FULL, rgb=picture.rgb)


@lru_cache(4)
def _weight(picture: Picture, tone: Map, wish: Map | None, wall: Paths | None, exponent: float) -> Tone:
    if exponent == 0:
        return Tone(np.ones((1, 1)), picture.size, picture.canvas if wall is None else _walled(picture, wall))
    whole = _toned(picture, tone, wish, wall)
    finer = importance(whole)
    return whole.holding((whole.coverage if finer is None else whole.coverage * finer / 2) ** exponent)


def _walled(picture: Picture, wall: Paths) -> shapely.Geometry:
    """The part of the canvas in a wall. Raises ValueError where that is nothing."""
    rings = shapely.make_valid((Paths(wall.xy - picture.corner, wall.start)).polygons())
    inner = shapely.intersection(reduce(shapely.symmetric_difference, rings), picture.canvas)
    parts = [part for part in shapely.get_parts(inner) if part.geom_type == "Polygon" and part.area > 0]
    if not parts:
        raise ValueError("the wall encloses nothing of the canvas; draw it over the picture")
    return parts[0] if len(parts) == 1 else shapely.multipolygons(parts)


def sheet_of(drawing: Drawing) -> Sheet:
    """The drawing as files have it: marks where a layer is of glyphs in its ink, else paths. Hidden layers are left out."""
    layers: list[sheet.Layer] = []
    for layer in drawing.layers:
        if layer.hidden:
            continue
        if layer.still:
            layers.append(layer.still)
        else:
            layers += _layers(layer, drawing.kinds)
    return Sheet(drawing.size, tuple(layers), drawing.recipe, {"warnings": []})


def _layers(layer: Layer, kinds: tuple[Kind, ...]) -> list[sheet.Layer]:
    """The layers of a sheet that a layer's items take: one, or one for each sort of outline."""
    items, used = layer.items, np.unique(layer.items.kind)
    if not len(items):
        return []
    if layer.ink.pen is None and not items.fill.any() and all(kinds[k].glyph for k in used):
        return [sheet.Layer(layer.ink, marks_of(items, kinds, used), layer.name)]
    found = []
    for closed in (True, False):
        for cubic in (False, True):
            sort = np.array([(kind.paths.closed, kind.paths.cubic) == (closed, cubic) for kind in kinds], bool)
            part = items.take(sort[items.kind])
            if not len(part):
                continue
            paths, owner = placed(part, kinds)
            filled = closed and layer.ink.pen is None and part.fill.any()
            found.append(sheet.Layer(layer.ink, paths, layer.name, _fills(part, layer.ink)[owner] if filled else None))
    return found


def marks_of(items: Items, kinds: tuple[Kind, ...], used: npt.NDArray[Any]) -> Marks:
    """Items of glyphs as marks; `used` are the kinds there are among them, rising."""
    glyphs = [kind.glyph for kind in (kinds[k] for k in used) if kind.glyph]
    if len({glyph.paths.cubic for glyph in glyphs}) > 1:
        glyphs = [replace(glyph, paths=glyph.paths.curved()) for glyph in glyphs]
    return Marks(items.xy, items.angle, items.mm, np.searchsorted(used, items.kind), tuple(glyphs))


def placed(items: Items, kinds: tuple[Kind, ...]) -> tuple[Paths, Index]:
    """The outlines of items at their places, and the item that each is of; of one sort, closed or open, straight or cubic."""
    used, kind = np.unique(items.kind, return_inverse=True)
    parts = [kinds[k].paths for k in used]
    table = Paths.of([path for part in parts for path in part], closed=parts[0].closed, cubic=parts[0].cubic)
    count = np.array([len(part) for part in parts], np.int64)
    owner = np.repeat(np.arange(len(items)), count[kind])
    first = (np.cumsum(count) - count)[kind[owner]]
    local = table.take(first + np.arange(len(owner)) - np.searchsorted(owner, owner))
    of = owner[local.path]
    cos, sin, (x, y) = np.cos(items.angle)[of], np.sin(items.angle)[of], (local.xy * items.mm[of][:, None]).T
    xy = np.stack([cos * x - sin * y, sin * x + cos * y], axis=1) + items.xy[of]
    return Paths(xy, local.start, local.closed, local.cubic), owner


def _fills(items: Items, ink: Ink) -> Array:
    """Shares of process inks (n, 4) of each item: of its own colour, or of its layer's."""
    rgb = np.stack([items.fill >> 16 & 255, items.fill >> 8 & 255, items.fill & 255], axis=1)
    return np.where((items.fill & OWN > 0)[:, None], sheet.in_process(rgb), ink.cmyk)
