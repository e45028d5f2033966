"""What the server tells of a drawing in JSON; see PROTOCOL.md."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from typing import Any

import numpy as np
import shapely

from crowquill import formats, glyphs, shapes
from crowquill.cells import voronoi
from crowquill.editor import frames
from crowquill.editor.brushes import MOST as LONGEST
from crowquill.editor.drawing import Drawing, Layer
from crowquill.editor.fields import flow
from crowquill.editor.items import Items, Kind
from crowquill.editor.log import Journal
from crowquill.editor.operations import MOST, Operation, every
from crowquill.editor.operations.marking import library
from crowquill.editor.session import Session
from crowquill.formats._text import svg_path
from crowquill.inertia import crosses
from crowquill.knobs import Choice, Flag, Knob, Numbers, Range, Text
from crowquill.objects import Objects
from crowquill.paths import Paths

PROTOCOL = 1
FRAME = 2**20  # bytes of a frame from the page
SHOWN = {"cells": 0, "axes": 1, "flow": 2}
ARROWS = 60  # of the flow, to the longer side

Json = dict[str, Any]


def hello(session: Session, drawing: Drawing, notes: tuple[str, ...]) -> Json:
    """What a page has to know of a session whose drawing this is, once, and when that has another paper."""
    picture = drawing.picture
    return {
        "say": "hello",
        "protocol": PROTOCOL,
        "version": version("crowquill"),
        "name": session.file.name,
        "size": list(drawing.size),
        "margin": drawing.margin,
        "art": [*map(float, picture.corner), *map(float, picture.size)],
        "picture": bool(session.header.picture),
        "operations": operations(),
        "formats": {name: [knob(one) for one in formats.knobs(name).values()] for name in formats.names()},
        "limits": {"marks": MOST, "path": LONGEST // 3, "frame": FRAME},
        "notes": list(notes),
    }


@cache
def operations() -> list[Json]:
    """All operations with their knobs."""
    return [_operation(one) for one in every().values()]


def _operation(one: Operation) -> Json:
    return {"name": one.name, "group": one.group, "help": one.about, "knobs": [knob(own) for own in one.knobs.values()]}


def knob(one: Knob) -> Json:
    """A knob as data."""
    takes = one.takes
    told: Json = {"name": one.name, "default": one.default, "help": takes.help}
    if isinstance(takes, (Range, Numbers)):
        told |= {"low": takes.low, "high": takes.high, "unit": takes.unit, "whole": one.whole}
    if isinstance(takes, Numbers):
        return {**told, "kind": "numbers", "count": takes.count}
    if isinstance(takes, Choice):
        return {**told, "kind": "choice", "names": list(takes.names)}
    if isinstance(takes, Text):
        return {**told, "kind": "text", "file": takes.file}
    return {**told, "kind": "flag" if isinstance(takes, Flag) else "range"}


@cache
def libraries() -> Json:
    """The shapes of all libraries that come along, as `kinds` of a state are told."""
    return {name: [_kind(k, kind) for k, kind in enumerate(library(name))] for name in [*glyphs.names(), *shapes.names()]}


def state(drawing: Drawing, shown: Drawing | None, undo: tuple[list[str], list[str]]) -> Json:
    """What a page that shows a drawing, or none, has to know of another, beside its frames."""
    known = shown.kinds if shown else ()
    new = [_kind(k, kind) for k, kind in enumerate(drawing.kinds) if k >= len(known) or kind is not known[k]]
    return {
        "say": "state",
        "reset": shown is None,
        "layers": [_layer(layer, drawing.kinds) for layer in drawing.layers],
        "kinds": new,
        "selected": sum(int(layer.items.selected.sum()) for layer in drawing.layers),
        "marks": sum(len(layer.items) for layer in drawing.layers),
        "undo": undo[0],
        "redo": undo[1],
        "wall": None if drawing.wall is None else _rings(drawing.wall),
        **({"canvas": _rings(Paths.of_polygons(shapely.simplify(drawing.picture.placed, 0.01))[0])} if shown is None else {}),
    }


def _rings(paths: Paths) -> list[list[float]]:
    return [np.round(ring, 3).ravel().tolist() for ring in paths]


def _layer(layer: Layer, kinds: tuple[Kind, ...]) -> Json:
    sort = "still" if layer.still else "tiles" if layer.tiling else "marks"
    if sort == "marks" and any(kinds[k].glyph is None for k in np.unique(layer.items.kind)):
        sort = "objects"
    ink = layer.ink
    return {
        "id": layer.id,
        "name": layer.name or ink.name,
        "kind": sort,
        "ink": ink.name,
        "spot": ink.spot,
        "cmyk": list(ink.cmyk),
        "rgb": list(ink.rgb),
        "pen": ink.pen,
        "hidden": layer.hidden,
        "locked": layer.locked,
        "items": len(layer.items),
    }


def _kind(k: int, kind: Kind) -> Json:
    told = {"id": k, "d": svg_path(kind.paths), "closed": kind.paths.closed, "reach": round(kind.reach, 4), "name": kind.name}
    return {**told, "size": round(kind.glyph.size, 4)} if kind.glyph else told


def overlay(drawing: Drawing, what: str, layer: int | None, revision: int) -> bytes:
    """The frame of what is to be shown over a drawing: cells of the items, their axes, or the picture's flow."""
    corner = drawing.picture.corner
    there = [one.items for one in drawing.layers if not one.hidden and not one.still and layer in (None, one.id)]
    items = Items.joined(there) if there else Items.none()
    if what == "flow":
        return frames.of_lines(SHOWN[what], _arrows(drawing), revision)
    if what == "axes":
        used, kind = np.unique(items.kind, return_inverse=True)
        every = Objects.of(items.xy, tuple(drawing.kinds[k].shape for k in used), angle=items.angle, scale=items.mm, shape=kind)
        return frames.of_lines(SHOWN[what], every.axes(), revision)
    tone = drawing.toned()
    rings = voronoi((items.xy - corner)[tone.holds(items.xy - corner)], tone.canvas).rings
    return frames.of_lines(SHOWN[what], Paths(rings.xy + corner, rings.start), revision)


def _arrows(drawing: Drawing) -> Paths:
    """Short lines along the picture's flow, on a grid."""
    picture = drawing.picture
    step = max(picture.size) / ARROWS
    x, y = np.meshgrid(*(np.arange(step / 2, side, step) for side in picture.size))
    xy = np.stack([x.ravel(), y.ravel()], axis=1) + picture.corner
    lines = crosses(xy, flow(drawing, xy), np.full((len(xy), 2), 0.4 * step))
    return lines.take(np.arange(0, len(lines), 2))


def step(n: Any, done: int, total: int, stage: str, facts: Mapping[str, float]) -> Json:
    """A step of work under way."""
    return {"say": "step", "n": n, "done": done, "total": total, "stage": stage, "facts": finite(facts)}


def saved(journal: Journal) -> Json:
    """Whether all entries are on the disk, and why not."""
    why = f"edits are not written down ({journal.error}); free some space"
    text = why if journal.waiting else "all edits are written down"
    return {"say": "saved", "ok": not journal.waiting, "waiting": journal.waiting, "text": text}


def finite(facts: Mapping[str, float]) -> Json:
    """Figures as JSON can hold them."""
    return {key: float(value) for key, value in facts.items() if isinstance(value, (int, float)) and np.isfinite(value)}
