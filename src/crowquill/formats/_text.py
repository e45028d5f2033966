"""Outlines as the text of SVG paths and PDF content: whole micrometres, the one number formatter."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from crowquill import hilbert
from crowquill.kernel import compiled
from crowquill.marks import Marks
from crowquill.paths import Index, Paths
from crowquill.sheet import Art, outlined

Bytes = npt.NDArray[np.uint8]
POINTS = 220_000  # to an element: some 15 000 dots; more pass 2 MB of SVG, and Ghostscript's time grows with the square
WIDEST = 21  # characters of the widest number and its space


def micrometres(paths: Paths) -> Index:
    """The points in whole micrometres, (m, 2)."""
    return np.round(paths.xy * 1000).astype(np.int64)


def chunks(art: Art) -> Iterator[Paths]:
    """The outlines of a layer's art in few elements, each of a size that editors and readers bear.

    Marks are gathered by place, paths in their order. A renderer smooths each element by itself, so that
    on a screen the paper shines through dark tones where two meet: as few elements as will do show least. Smeared
    borders were tried, and showed more.
    """
    if not isinstance(art, Marks):
        art = outlined(art)
        heads = np.searchsorted(art.start, np.arange(POINTS, len(art.xy), POINTS), side="left")
        if art.closed and len(heads):  # holes stay with the outlines before them, which turn as the largest does
            areas = art.areas
            outer = np.flatnonzero(areas * areas[np.abs(areas).argmax()] > 0)
            heads = np.append(outer, len(art))[np.searchsorted(outer, heads)]
        for lo, hi in pairwise(np.unique([0, *heads, len(art)])):
            yield art.take(np.arange(lo, hi))
        return
    size = max(1, POINTS // max((len(glyph.paths.xy) for glyph in art.glyphs), default=1))
    order = hilbert.of_points(art.xy)
    for lo in range(0, len(art), size):
        yield art.take(np.sort(order[lo : lo + size])).outlines()


def apart(marks: Marks) -> Iterator[Paths]:
    """Each mark's outline by itself."""
    outlines = marks.outlines()
    return (outlines.take([i]) for i in range(len(outlines)))


def number(value: float, digits: int = 3) -> str:
    """A number as SVG and PDF both take it: plain decimals, as few as say it, never an exponent or -0."""
    text = f"{value:.{digits}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return "0" if text == "-0" else text


def svg_path(paths: Paths) -> str:
    """SVG path data in micrometres, relative throughout."""
    buffer = np.empty(8 + 8 * len(paths) + 2 * WIDEST * (len(paths.xy) + len(paths)), np.uint8)
    end = _svg(micrometres(paths), paths.start, paths.closed, paths.cubic, buffer)
    return buffer[:end].tobytes().decode("ascii")


def pdf_path(paths: Paths) -> str:
    """PDF path operators in micrometres, about the first point, behind the matrix that puts them there."""
    points = micrometres(paths)
    x, y = points[0] if len(points) else (0, 0)
    buffer = np.empty(8 + 8 * len(paths) + (2 * WIDEST + 4) * (len(points) + len(paths)), np.uint8)
    end = _pdf(points - (x, y), paths.start, paths.closed, paths.cubic, buffer)
    return f"1 0 0 1 {x} {y} cm\n" + buffer[:end].tobytes().decode("ascii")


@compiled
def _number(out: Bytes, at: int, value: int) -> int:
    """Writes a whole number at `at` and returns where it ends."""
    if value < 0:
        out[at] = 45  # -
        at, value = at + 1, -value
    digits, rest = 1, value
    while rest >= 10:
        digits, rest = digits + 1, rest // 10
    for k in range(digits - 1, -1, -1):
        out[at + k] = 48 + value % 10
        value //= 10
    return at + digits


@compiled
def _pair(out: Bytes, at: int, x: int, y: int, letter: int) -> int:
    """Writes two numbers, after a letter or, where the minus sign does not part them, a space."""
    if letter:
        out[at] = letter
        at += 1
    elif x >= 0:
        out[at] = 32
        at += 1
    at = _number(out, at, x)
    if y >= 0:
        out[at] = 32
        at += 1
    return _number(out, at, y)


@compiled
def _svg(xy: Index, start: Index, closed: bool, cubic: bool, out: Bytes) -> int:
    at, fromx, fromy = 0, 0, 0
    for path in range(len(start) - 1):
        begin, end = start[path], start[path + 1]
        if begin == end:
            continue
        at = _pair(out, at, xy[begin, 0] - fromx, xy[begin, 1] - fromy, 109)  # m
        fromx, fromy = xy[begin, 0], xy[begin, 1]
        step = 3 if cubic else 1
        stop = end + (1 if cubic and closed else 0)  # a closed cubic comes back to its first point
        for k in range(begin + 1, stop):
            j = k if k < end else begin
            letter = 0 if k > begin + 1 else (99 if cubic else 108)  # c, l
            at = _pair(out, at, xy[j, 0] - fromx, xy[j, 1] - fromy, letter)
            if (k - begin) % step == 0:
                fromx, fromy = xy[j, 0], xy[j, 1]
        if closed:
            out[at] = 122  # z
            at += 1
            fromx, fromy = xy[begin, 0], xy[begin, 1]
    return at


@compiled
def _pdf(xy: Index, start: Index, closed: bool, cubic: bool, out: Bytes) -> int:
    at = 0
    for path in range(len(start) - 1):
        begin, end = start[path], start[path + 1]
        if begin == end:
            continue
        step = 3 if cubic else 1
        stop = end + (1 if cubic and closed else 0)
        for k in range(begin, stop):
            j = k if k < end else begin
            at = _number(out, at, xy[j, 0])
            out[at] = 32
            at = _number(out, at + 1, xy[j, 1])
            out[at] = 32
            at += 1
            if (k - begin) % step == 0:
                out[at] = 109 if k == begin else (99 if cubic else 108)  # m, c, l
                out[at + 1] = 10
                at += 2
        if closed:
            out[at] = 104  # h
            out[at + 1] = 10
            at += 2
    return at
