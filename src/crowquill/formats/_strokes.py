"""Strokes of a sheet in whole steps of a machine: what every format of plotters shares."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from crowquill.paths import Array, Index, Paths
from crowquill.sheet import Layer, Sheet, outlined

LONGEST = 40  # characters of a name: GRBL takes lines of 80
Place = Callable[[Array], Array]  # from mm of the sheet, y down, to mm of the machine


@dataclass(frozen=True, eq=False)
class Pen:
    """What one pen draws, in whole steps: xy (m, 2), start (n + 1,). Pens are numbered from 1 as the sheet's layers are."""

    number: int
    name: str
    xy: Index
    start: Index

    def __iter__(self) -> Iterator[list[list[int]]]:
        """The points of each stroke, in the order of the sheet; a dot has one."""
        return (self.xy[a:b].tolist() for a, b in pairwise(self.start.tolist()))


def upright(sheet: Sheet) -> Place:
    """Places of the sheet with the origin at its bottom left and y up."""
    return lambda xy: np.array([0, sheet.size[1]]) + xy * (1, -1)


def by_pen(sheet: Sheet, step: float, format: str, place: Place) -> list[Pen]:
    """The layers that draw something, as pens: curves within half a step, rings back at their first point.

    What lies off the page is not drawn, as in a PDF: a line that leaves it ends at its edge. A stroke
    shorter than a step is a dot. Raises ValueError for a layer that fills.
    """
    if any(layer.ink.pen is None and len(layer.art) for layer in sheet.layers):
        raise ValueError(f"{format} draws strokes only; draw with --for plotter")
    bounds = np.sort([place(np.zeros(2)), place(np.array(sheet.size))], axis=0)
    last = np.floor(bounds[1] / step + 1e-9).astype(np.int64)  # the page's far edge may lie between two steps
    found = []
    for number, layer in enumerate(sheet.layers, 1):
        lines = _lines(layer, sheet.size, step / 2)
        whole = np.clip(np.round(place(lines.xy) / step).astype(np.int64), 0, last)
        first = np.zeros(len(whole), bool)
        first[lines.start[:-1][np.diff(lines.start) > 0]] = True
        kept = first.copy()
        kept[1:] |= (whole[1:] != whole[:-1]).any(axis=1)
        if len(whole):
            found.append(Pen(number, plain(layer.label), whole[kept], np.append(np.flatnonzero(first[kept]), kept.sum())))
    return found


def fit(size: tuple[float, float], bed: tuple[float, float] | None, remedy: str) -> None:
    """Raises ValueError for a sheet larger than the bed, both (width, height) mm; `remedy` is for one that fits when turned."""
    if bed is None or _within(size, bed):
        return
    most = f"paper of at most {bed[0]:g} x {bed[1]:g} mm"
    wish = f"{remedy}, or give {most}" if _within(size[::-1], bed) else f"give {most}"
    raise ValueError(f"a sheet of {size[0]:g} x {size[1]:g} mm is larger than the bed of {bed[0]:g} x {bed[1]:g} mm; {wish}")


def _within(size: tuple[float, float], bed: tuple[float, float]) -> bool:
    return all(side <= most + 1e-6 for side, most in zip(size, bed, strict=True))


def plain(text: str) -> str:
    """A name in letters, digits, spaces and ._- of ASCII: nothing that ends a comment or a line, or that a machine obeys inside one.

    GRBL takes ! ? and ~ out of the stream wherever they are; LinuxCNC obeys comments with a comma behind a word.
    """
    bare = "".join(letter for letter in unicodedata.normalize("NFKD", text) if not unicodedata.combining(letter))
    return " ".join(re.sub("[^A-Za-z0-9._-]", "_", word) for word in bare.split())[:LONGEST].strip() or "unnamed"


def _lines(layer: Layer, size: tuple[float, float], tolerance: float) -> Paths:
    """The layer's strokes as open straight lines on the page."""
    paths = outlined(layer.art).flat(tolerance)
    if paths.closed:
        filled = np.diff(paths.start) > 0
        begin, end = paths.start[:-1][filled], paths.start[1:][filled]
        start = paths.start + np.concatenate([[0], np.cumsum(filled)])
        paths = Paths(np.insert(paths.xy, end, paths.xy[begin], axis=0), start, closed=False)
    if ((paths.xy < 0) | (paths.xy > size)).any():
        return Paths.of([piece for line in paths for piece in _inside(line, size)], closed=False)
    return paths


def _inside(line: Array, size: tuple[float, float]) -> Iterator[Array]:
    """The pieces of a line that lie on the page, its edge included, in order."""
    if not ((line < 0) | (line > size)).any():
        yield line
        return
    a, along = line[:-1], np.diff(line, axis=0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ends = np.stack([-a / along, (size - a) / along])
    ends = np.where(np.isnan(ends), np.array([-np.inf, np.inf])[:, None, None], ends)  # a side along the edge
    enter, leave = np.maximum(ends.min(axis=0).max(axis=1), 0), np.minimum(ends.max(axis=0).min(axis=1), 1)
    piece: list[Array] = []
    for i in np.flatnonzero(enter <= leave):
        if piece and enter[i] > 0:  # it had left the page
            yield np.array(piece)
            piece = []
        piece = piece or [a[i] + enter[i] * along[i]]
        piece.append(line[i + 1] if leave[i] == 1 else a[i] + leave[i] * along[i])
    if piece:
        yield np.array(piece)
