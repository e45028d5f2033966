"""Operations that insert, erase, exchange and freeze items."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Annotated

import numpy as np

from crowquill import glyphs, shapes
from crowquill.editor.brushes import Brush, Falloff, Meant, Path, Size, Strength
from crowquill.editor.drawing import Drawing, Layer
from crowquill.editor.fields import flow
from crowquill.editor.items import Items, Kind, Mask, micrometres
from crowquill.editor.operations import on_meant, operation
from crowquill.kernel import compiled
from crowquill.knobs import Choice, Flag, Range, Text
from crowquill.paths import Array, Index
from crowquill.stippling import PEN

FIRST = "nib-03"  # what is inserted where a layer has nothing yet
ROUND = float(np.sqrt(np.pi) / 2)  # the scale of a glyph over its diameter
TRIES = 100_000  # of one operation
SQUARES = 1000  # of a grid, to a side

Which = Annotated[str | None, Text("a library, library/number, or an SVG; left out, what the layer has", file=True)]


@operation("brush")
def insert(
    drawing: Drawing,
    rng: np.random.Generator,
    *,
    path: Path = None,
    size: Size = 5.0,
    strength: Strength = 1.0,
    falloff: Falloff = "flat",
    layer: Annotated[int | None, Range(1, 10**6, "", "where to; left out, the topmost that may change")] = None,
    rate: Annotated[float, Range(0, 1000, "", "tries for each point of the way")] = 3.0,
    glyph: Which = None,
    diameter: Annotated[float | None, Range(0.01, 500, "mm", "how large; left out, as the layer has them")] = None,
    gap: Annotated[float, Range(-50, 50, "mm", "least white to all others of the layer; below 0 they may overlap")] = 0.05,
    turn: Annotated[str, Choice(("random", "flow", "stroke", "level"), "how they lie")] = "random",
) -> Drawing:
    """Insert marks, never nearer to others than a gap.

    Tries that find no room are left out. A size of 0 puts them on the points of the way themselves.
    """
    (found,) = drawing.free(drawing.layer(layer).id)
    brush = Brush.of(path, size, strength, falloff)
    xy, along = _tries(brush, rate, rng)
    inside = ((xy >= 0) & (xy <= drawing.size)).all(axis=1)
    xy, along = micrometres(xy[inside]) / 1000, along[inside]
    kinds, spread = _kinds(drawing, found, glyph)
    mean = _mean(found.items) if diameter is None and glyph is None else None
    drawing, at = drawing.with_kinds(kinds)
    found = drawing.layer(found.id)
    which = rng.integers(len(at), size=len(xy))
    scale = (mean or ROUND * (diameter or PEN)) * spread[which]
    angle = _turned(drawing, turn, xy, along, rng)
    reach = drawing.reach
    stay = roomy(found.items, reach[found.items.kind] * found.items.mm, xy, reach[at[which]] * scale, gap)
    if not stay.any():
        return replace(drawing, facts={"inserted": 0})
    new = Items.of(drawing.first, xy[stay], scale=scale[stay], angle=angle[stay], kind=at[which[stay]])
    return replace(drawing.added(found, new), facts={"inserted": len(new)})


def _tries(brush: Brush, rate: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """Places (n, 2) to try, at random in the brush about each point of its way by its profile, and the way's direction at each, rad."""
    wanted = rate * brush.strength * brush.pressure
    count = np.floor(wanted + rng.random(len(wanted))).astype(np.int64)
    if count.sum() > TRIES:
        raise ValueError(f"rate {rate:g} makes {count.sum()} tries, over {TRIES}; lower it, or draw less at a time")
    of = np.repeat(np.arange(len(count)), count)
    far, round_ = brush.radius * np.sqrt(rng.random(len(of))), rng.uniform(0, 2 * np.pi, len(of))
    kept = rng.random(len(of)) < brush.profile(far)
    off = far[:, None] * np.stack([np.cos(round_), np.sin(round_)], axis=1)
    return (brush.points[of] + off)[kept], brush.headings[of][kept]


def _turned(drawing: Drawing, turn: str, xy: Array, along: Array, rng: np.random.Generator) -> Array:
    """The angles of new items, rad."""
    if turn == "random":
        return rng.uniform(0, 2 * np.pi, len(xy))
    if turn == "flow":
        return flow(drawing, xy)
    return along if turn == "stroke" else np.zeros(len(xy))


def _mean(items: Items) -> float | None:
    """The scale of a layer's items that is in the middle, mm; None without any."""
    return float(np.median(items.mm)) if len(items) else None


def _kinds(drawing: Drawing, layer: Layer, glyph: str | None) -> tuple[tuple[Kind, ...], Array]:
    """What to insert, and how large each is beside the others."""
    if glyph is None and len(layer.items):
        own = tuple(drawing.kinds[k] for k in np.unique(layer.items.kind))
        return own, np.ones(len(own))
    found = library(glyph or FIRST)
    size = np.array([kind.glyph.size if kind.glyph else 1.0 for kind in found])
    return found, size / np.sqrt((size**2).mean())


def library(name: str) -> tuple[Kind, ...]:
    """The kinds of a library that comes along, of dots or of objects, or the one of library/number, or all of an SVG file.

    Of an object with areas its lines are left out. Raises ValueError for an unknown one.
    """
    if name.lower().endswith(".svg"):
        return tuple(_kind("", motif) for motif in shapes.load(name).motifs)
    book, _, number = name.partition("/")
    if book not in [*glyphs.names(), *shapes.names()]:
        raise ValueError(f"no library {book!r}; there are {', '.join([*glyphs.names(), *shapes.names()])}")
    found = _book(book)
    if not number:
        return found
    if not number.isdecimal() or int(number) >= len(found):
        raise ValueError(f"no shape {number!r} in library {book}; it has 0 to {len(found) - 1}")
    return (found[int(number)],)


@lru_cache(32)
def _book(name: str) -> tuple[Kind, ...]:
    """The kinds of a library that comes along."""
    if name in glyphs.names():
        return tuple(Kind.of_glyph(glyph, f"{name}/{k}") for k, glyph in enumerate(glyphs.load(name).glyphs))
    return tuple(_kind(f"{name}/{k}", motif) for k, motif in enumerate(shapes.load(name).motifs))


def _kind(name: str, motif: shapes.Motif) -> Kind:
    """The kind of an object: a glyph, or its areas, or where it has none its lines, as large as a glyph of the same length."""
    if motif.glyph:
        return Kind.of_glyph(motif.glyph, name)
    paths = motif.rings if len(motif.rings) else motif.lines
    return Kind(paths.moved(np.eye(2) / (ROUND * motif.across)), None, name)


def roomy(items: Items, reach: Array, xy: Array, own: Array, gap: float) -> Mask:
    """Which new places (n, 2) stay, when each that is nearer than the gap to an item or to one before it goes.

    All are taken as circles: items of these reaches (k,) mm, the new of their `own` (n,).
    """
    stay = np.ones(len(xy), bool)
    most = float(own.max(initial=0.0) + max(own.max(initial=0.0), reach.max(initial=0.0)) + gap)
    if not len(xy) or most <= 0:
        return stay
    low, high = xy.min(axis=0) - most, xy.max(axis=0) + most
    near = np.flatnonzero(((items.xy >= low) & (items.xy <= high)).all(axis=1))
    side = max(most, float((high - low).max()) / SQUARES)
    columns, rows = np.floor((high - low) / side).astype(np.int64) + 1
    places, radius = np.concatenate([items.xy[near], xy]), np.concatenate([reach[near], own])
    column, row = np.floor((places - low) / side).astype(np.int64).T
    _settle(places, radius, gap, column, row, np.full((rows, columns), -1), np.full(len(places), -1), len(near), stay)
    return stay


@compiled
def _settle(places: Array, radius: Array, gap: float, column: Index, row: Index, head: Index, after: Index, old: int, stay: Mask) -> None:
    """Places one after the other into squares, each a chain of places; of the new, from `old` on, only those that have room."""
    for i in range(len(places)):
        x, y = column[i], row[i]
        if i >= old:
            for v in range(max(0, y - 1), min(head.shape[0], y + 2)):
                for u in range(max(0, x - 1), min(head.shape[1], x + 2)):
                    j = head[v, u]
                    while j >= 0 and stay[i - old]:
                        room = radius[i] + radius[j] + gap
                        far = (places[i, 0] - places[j, 0]) ** 2 + (places[i, 1] - places[j, 1]) ** 2
                        if room > 0 and far < room * room:
                            stay[i - old] = False
                        j = after[j]
            if not stay[i - old]:
                continue
        after[i], head[y, x] = head[y, x], i


@on_meant("brush", falloff="flat")
def erase(meant: Meant, rng: np.random.Generator) -> Drawing:
    """Erase marks; below full strength some stay, by chance."""
    by, count = {}, 0
    for found, rows, weight in meant.parts():
        gone = rows[rng.random(len(rows)) < weight]
        if len(gone):
            stay = np.ones(len(found.items), bool)
            stay[gone] = False
            by[found.id] = found.items.take(stay)
            count += len(gone)
    return replace(meant.drawing.with_items(by), facts={"erased": count})


@on_meant("brush", falloff="flat")
def swap(
    meant: Meant,
    rng: np.random.Generator,
    *,
    glyph: Annotated[str, Text("a library, library/number, or an SVG file", file=True)] = FIRST,
) -> Drawing:
    """Exchange the shapes of marks for others of the same size; below full strength some stay as they are."""
    drawing, at = meant.drawing.with_kinds(library(glyph))
    by = {}
    for found, rows, weight in meant.parts():
        hit = rows[rng.random(len(rows)) < weight]
        if len(hit):
            by[found.id] = found.items.having(hit, kind=at[rng.integers(len(at), size=len(hit))])
    return drawing.with_items(by)


@on_meant("brush", falloff="flat")
def freeze(
    meant: Meant,
    rng: np.random.Generator,  # noqa: ARG001
    *,
    frozen: Annotated[bool, Flag("freeze, or else thaw")] = True,
) -> Drawing:
    """Freeze marks, so that nothing changes them, or thaw them."""
    by = {found.id: found.items.having(rows, frozen=frozen) for found, rows, _ in meant.parts(frozen=True) if len(rows)}
    return meant.drawing.with_items(by)
