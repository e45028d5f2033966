"""Dots as characters of embedded fonts, for PDF: a dot takes 7 bytes of the page, its outline a hundred.

A character is a glyph turned by one of some steps and drawn in micrometres, about its centroid, without advance.
Readers smooth each by itself, so that on screens paper shines through where dots touch: ink of 0.89 shows at 100 dpi
as 0.76 (its outlines as 0.95), at 300 as 0.86, at 600 as 0.88, at 2540 as it is.
"""

from __future__ import annotations

import io
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from types import SimpleNamespace
from typing import TypeGuard

import numpy as np
import pikepdf
from fontTools import cffLib
from fontTools.misc.psCharStrings import T2CharString

from crowquill import hilbert
from crowquill.formats._fonts import composite, mapped, tag
from crowquill.formats._text import WIDEST, Bytes, _number, number
from crowquill.kernel import compiled
from crowquill.marks import TURN_STEPS, Glyph, Marks
from crowquill.paths import Array, Index, Paths

SLIP = 0.003  # mm that an outline may lie off because its turn is rounded: a hundredth of a dot of 0.3 mm
EM = 1000  # units to a font's size, as readers take for granted: at size 1000 a unit is a micrometre
FULL = 65_534  # characters to a font: with the empty one that it must have, 65535, the most that CFF counts
REACH = 16_000  # um from a character's middle to its rim: a charstring's numbers end at 32767, and go from rim to rim
SHOWN = 50_000  # marks to a piece of text
OPERANDS = 48  # to an operator of a charstring, at most
# Filled alone, characters are bitmaps from a cache, which readers place on whole pixels: at 2540 dpi up to 8 um off in
# Ghostscript and 14 in Poppler, at 600 dpi 43. Filled and stroked they are drawn as the outlines they are, within 1 um. The
# stroke's dashes begin in a gap of a metre, so that none is ever drawn.
EXACT = "2 Tr [1 1000000] 2 d"


@dataclass(frozen=True)
class Font:
    """An embedded font: its name, the box around all characters in um, their number, and the CFF program."""

    name: str
    box: tuple[int, int, int, int]
    count: int
    program: bytes

    @property
    def key(self) -> str:
        """Its name in the page: the hash of its shapes, so that layers of the same shapes share it."""
        return self.name[:6]


def takes(art: Marks | Paths) -> TypeGuard[Marks]:
    """Whether filled art can be shown as characters: marks of closed outlines."""
    return isinstance(art, Marks) and all(art.glyphs[k].paths.closed for k in np.unique(art.glyph))


def typeset(marks: Marks) -> tuple[Iterator[str], list[Font]]:
    """The text operators that show the marks, in micrometres and y down, piece by piece, and the fonts they need.

    Places are exact, areas to a thousandth. Turns are rounded: an outline lies within SLIP and a micrometre of where it
    belongs, a dot of over 30 mm within SLIP and a ten-thousandth of its width. More characters than a font holds go on
    in a second. Marks of scale 0 have no ink and are not shown.
    """
    if not (marks.scale > 0).all():
        marks = marks.take(marks.scale > 0)
    if not len(marks):
        return iter([""]), []
    marks = marks.take(hilbert.of_points(marks.xy))
    drawn, steps = _drawing(marks)
    turn = np.round(marks.angle * steps[marks.glyph] / (2 * np.pi)).astype(np.int64) % steps[marks.glyph]
    character = marks.glyph * TURN_STEPS + turn
    used = np.zeros(len(marks.glyphs) * TURN_STEPS, bool)
    used[character] = True
    kinds, character = np.flatnonzero(used), (np.cumsum(used) - 1)[character]
    fonts: list[Font] = []
    for lo in range(0, len(kinds), FULL):
        shapes = []
        for kind in kinds[lo : lo + FULL]:
            which, step = divmod(int(kind), TURN_STEPS)
            shapes.append(_turned(marks.glyphs[which], drawn[which], 2 * np.pi * step / steps[which]))
        fonts.append(_font(shapes))
    font, code = np.divmod(character, FULL)
    size = np.round(1e6 * np.round(marks.scale * 1000) / drawn[marks.glyph]).astype(np.int64)  # in thousandths
    return _text(marks, fonts, font, code + 1, size), fonts


def resource(pdf: pikepdf.Pdf, font: Font) -> pikepdf.Object:
    """The font as an object of the file: each of its characters is copied as a bullet."""
    left, low, right, top = font.box
    file = pdf.make_stream(zlib.compress(font.program, 9), Filter=pikepdf.Name.FlateDecode, Subtype=pikepdf.Name.CIDFontType0C)
    descriptor = {
        "FontBBox": [left, low, right, top],
        "ItalicAngle": 0,
        "Ascent": top,
        "Descent": low,
        "CapHeight": top,
        "StemV": max(0, right - left),
        "MissingWidth": 0,
        "FontFile3": file,
    }
    return composite(pdf, font.name, kind="CIDFontType0", descriptor=descriptor, character={}, unicode=_bullets(font.count))


def _drawing(marks: Marks) -> tuple[Array, Index]:
    """For each glyph the scale in um that its characters are drawn at, and how many turns it is drawn in; 1 where it is not used.

    Where each glyph has one scale, as in plates of one pen, all text is of one size, and a dot's neighbour on the
    page follows it in the file. Otherwise all are drawn at the largest scale, and text is grouped by size.
    """
    scale = np.round(marks.scale * 1000)
    largest = np.zeros(len(marks.glyphs))
    np.maximum.at(largest, marks.glyph, scale)
    drawn, steps = largest.copy(), np.ones(len(largest), np.int64)
    if (scale != largest[marks.glyph]).any():
        drawn[:] = scale.max()
    for k in np.flatnonzero(largest):
        glyph = marks.glyphs[k]
        drawn[k] = min(drawn[k], REACH / np.hypot(*glyph.paths.xy.T).max())
        steps[k] = np.clip(np.ceil(np.pi * slope(glyph) * largest[k] / 1000 / SLIP), 1, TURN_STEPS)
    return drawn, steps


def slope(glyph: Glyph) -> float:
    """How far the unit glyph's outline moves across itself, at most, to a radian of turn: 0 for a disc.

    A point p turned about the middle goes along p's normal; what counts of it is p along the outline's direction there.
    """
    worst = 0.0
    for ring in glyph.paths.flat(1e-6):
        side = np.roll(ring, -1, axis=0) - ring
        length = np.hypot(*side.T)
        along = np.abs((ring * side).sum(axis=1)), np.abs((np.roll(ring, -1, axis=0) * side).sum(axis=1))
        worst = max(worst, float((np.maximum(*along)[length > 0] / length[length > 0]).max(initial=0.0)))
    return worst


def _turned(glyph: Glyph, scale: float, angle: float) -> tuple[list[Index], bool]:
    """A character's rings in whole units, y up, and whether they are cubic."""
    cos, sin = scale * np.cos(angle), scale * np.sin(angle)
    paths = glyph.paths.moved([(cos, -sin), (-sin, -cos)])
    return [np.round(ring).astype(np.int64) for ring in paths if len(ring)], paths.cubic


def _font(shapes: list[tuple[list[Index], bool]]) -> Font:
    """A font of these characters, codes from 1 on. Its name is the hash of its shapes, since printers keep fonts by name."""
    points = np.concatenate([np.zeros((0, 2), np.int64), *(ring for rings, _ in shapes for ring in rings)])
    box = np.concatenate([points.min(axis=0, initial=0), points.max(axis=0, initial=0)]).tolist()
    cuts = np.array([len(ring) * 2 + cubic for rings, cubic in shapes for ring in rings])
    name = tag(points.astype("<i8").tobytes() + cuts.astype("<i8").tobytes()) + "+Dots"
    subroutines, private = cffLib.GlobalSubrsIndex(), cffLib.PrivateDict()
    private.defaultWidthX = private.nominalWidthX = 0  # a dot advances by nothing
    top, part = cffLib.TopDict(GlobalSubrs=subroutines), cffLib.FontDict(GlobalSubrs=subroutines)
    part.FontName, part.Private = name, private
    top.ROS, top.CIDCount, top.FontBBox = ("Adobe", "Identity", 0), len(shapes) + 1, box
    top.charset = [".notdef", *(f"cid{code:05}" for code in range(1, len(shapes) + 1))]
    top.FDArray, top.FDSelect = cffLib.FDArrayIndex(), cffLib.FDSelect(format=3)
    top.FDArray.append(part)
    top.FDSelect.gidArray = [0] * len(top.charset)
    top.CharStrings = cffLib.CharStrings(None, top.charset, subroutines, private, top.FDSelect, top.FDArray)
    programs = [["endchar"], *(_charstring(*shape) for shape in shapes)]
    for glyph, program in zip(top.charset, programs, strict=True):
        top.CharStrings[glyph] = T2CharString(program=program, private=private, globalSubrs=subroutines)
    whole = cffLib.CFFFontSet()
    whole.major, whole.minor, whole.fontNames, whole.GlobalSubrs = 1, 0, [name], subroutines
    whole.topDictIndex = cffLib.TopDictIndex()
    whole.topDictIndex.append(top)
    buffer = io.BytesIO()
    whole.compile(buffer, SimpleNamespace(recalcBBoxes=False))
    return Font(name, tuple(box), len(shapes), buffer.getvalue())


def _charstring(rings: list[Index], cubic: bool) -> list[int | str]:
    """The Type 2 program that draws the rings, by relative moves."""
    program: list[int | str] = []
    at = np.zeros(2, np.int64)
    for ring in rings:
        if cubic:  # a closed cubic comes back to its first point; a straight side back is understood
            ring = np.concatenate([ring, ring[:1]])
        moves: list[int] = np.diff(ring, axis=0).ravel().tolist()
        program += [*(ring[0] - at).tolist(), "rmoveto"]
        for lo in range(0, len(moves), OPERANDS):
            program += [*moves[lo : lo + OPERANDS], "rrcurveto" if cubic else "rlineto"]
        at = ring[-1]
    return [*program, "endchar"]


def _bullets(count: int) -> bytes:
    """The ToUnicode map that reads every character as a bullet."""
    ranges: list[str] = []
    for lo in range(0, count + 1, 256):  # a range may not pass from one first byte to another
        hi = min(lo + 255, count)
        ranges.append(f"<{lo:04x}> <{hi:04x}> [{'<2022>' * (hi - lo + 1)}]")
    return mapped(ranges, "range")


def _text(marks: Marks, fonts: list[Font], font: Index, code: Index, size: Index) -> Iterator[str]:
    """One text object: for each font and size the marks along the Hilbert curve, each a move and a character.

    Two marks of one height are one in a thousand, so that showing several at once would save nothing. Codes as
    bytes are a tenth shorter than in hexadecimal, and deflated a hundredth longer.
    """
    order = np.lexsort((size, font))
    font, code, size = font[order], code[order], size[order]
    xy = np.round(marks.xy[order] * 1000).astype(np.int64)
    xy[1:] -= xy[:-1].copy()
    moves = xy * (1, -1)
    ends = np.flatnonzero((np.diff(font) != 0) | (np.diff(size) != 0)) + 1
    parts = [f"{EXACT}\nBT\n1 0 0 -1 0 0 Tm\n"]  # upright on a page whose y goes down
    for lo, hi in pairwise([0, *ends.tolist(), len(order)]):
        parts.append(f"/{fonts[font[lo]].key} {number(size[lo] / 1000)} Tf\n")
        for first in range(lo, hi, SHOWN):
            last = min(first + SHOWN, hi)
            buffer = np.empty((2 * WIDEST + 16) * (last - first), np.uint8)
            parts.append(buffer[: _show(moves[first:last], code[first:last], buffer)].tobytes().decode("ascii"))
            if last == first + SHOWN:
                yield "".join(parts)
                parts = []
    yield "".join([*parts, "ET"])


@compiled
def _show(moves: Index, code: Index, out: Bytes) -> int:
    """Writes `x y Td<code>Tj` for each mark and returns where it ends."""
    at = 0
    for k in range(len(moves)):
        at = _number(out, at, moves[k, 0])
        out[at] = 32
        at = _number(out, at + 1, moves[k, 1])
        for letter in (32, 84, 100, 60):  # " Td<"
            out[at] = letter
            at += 1
        for shift in (12, 8, 4, 0):
            digit = (code[k] >> shift) & 15
            out[at] = digit + (48 if digit < 10 else 87)
            at += 1
        for letter in (62, 84, 106, 10):  # ">Tj\n"
            out[at] = letter
            at += 1
    return at
