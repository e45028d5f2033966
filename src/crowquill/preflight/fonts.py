"""Fonts of PDF: codes in strings, how far each goes, and the outlines of characters that are dots."""

from __future__ import annotations

import io
import logging
from typing import Any

import numpy as np
import pikepdf
from fontTools import cffLib
from fontTools.agl import UV2AGL
from fontTools.encodings.StandardEncoding import StandardEncoding
from fontTools.pens.basePen import BasePen
from fontTools.ttLib import TTFont

from crowquill.paths import Paths
from crowquill.preflight.document import TooLarge, unpacked
from crowquill.preflight.marks import shape
from crowquill.preflight.values import text

logging.getLogger("fontTools").addHandler(logging.NullHandler())  # what it says of odd fonts is no line on stderr

PROGRAM = 64 * 2**20  # bytes of a font
POINTS = 20_000  # of a character


class _Outline(BasePen):  # type: ignore[misc]
    """Gathers a character's outlines as cubics."""

    def __init__(self, glyphs: Any) -> None:
        super().__init__(glyphs)
        self.rings: list[list[tuple[float, float]]] = []
        self.left = POINTS

    def _moveTo(self, pt: Any) -> None:
        self.rings.append([pt])

    def _lineTo(self, pt: Any) -> None:
        (a, b), (c, d) = self.rings[-1][-1], pt
        self._curveToOne((a + (c - a) / 3, b + (d - b) / 3), (c - (c - a) / 3, d - (d - b) / 3), pt)

    def _curveToOne(self, pt1: Any, pt2: Any, pt3: Any) -> None:
        self.left -= 1
        if self.left < 0:
            raise ValueError("a character has too many points")
        self.rings[-1] += [pt1, pt2, pt3]


class Font:
    """A font of a page. `name` is its own; `embedded`: whether its program is in the file; `procs`: the content of a Type 3 one."""

    def __init__(self, found: Any) -> None:
        kind = text(found.get("/Subtype"))
        inner = found
        if kind == "/Type0" and isinstance(found.get("/DescendantFonts"), pikepdf.Array) and len(found.DescendantFonts):
            inner = found.DescendantFonts[0]
        self.wide = kind == "/Type0"
        self.named = found
        self.inner = inner
        self.name = (text(found.get("/BaseFont")) or text(found.get("/Name")) or "/unnamed")[1:]
        self.procs = found.get("/CharProcs") if kind == "/Type3" else None
        descriptor = inner.get("/FontDescriptor")
        self.files = {key: descriptor[key] for key in ("/FontFile", "/FontFile2", "/FontFile3") if key in descriptor} if descriptor else {}
        self.embedded = bool(self.files) or kind == "/Type3"
        self.advances, self.usual = self._widths()
        self.unread = False  # whether some of its outlines could not be read
        self._dots: dict[int, Paths | None] = {}
        self._glyphs: Any = None
        self._opened = False

    def codes(self, shown: bytes) -> list[int]:
        """The codes of a string: two bytes each for composite fonts."""
        if not self.wide:
            return list(shown)
        return [256 * shown[k] + shown[k + 1] for k in range(0, len(shown) - 1, 2)]

    def advance(self, code: int) -> float:
        """How far a character goes, in sizes of the font."""
        return self.advances.get(code, self.usual)

    def dot(self, code: int) -> Paths | None:
        """A character's outlines in sizes of the font where it is a dot; None for letters and what cannot be read.

        A dot is one compact outline, or anything that does not advance: whoever sets dots as text places each by itself.
        """
        if code not in self._dots:
            self._dots[code] = self._dot(code)
        return self._dots[code]

    def _dot(self, code: int) -> Paths | None:
        try:
            rings, scale = self._drawn(code)
        except Exception:  # a font of anybody's may fail in any way
            self.unread = True
            return None
        rings = [ring[:-1] if ring[0] == ring[-1] else ring + _back(ring) for ring in rings if len(ring) > 3]
        if not rings:
            return None
        paths = Paths.of([np.array(ring) * scale for ring in rings], cubic=True)
        flat = paths.flat(0.002)
        length = sum(float(np.hypot(*(np.roll(ring, -1, axis=0) - ring).T).sum()) for ring in flat)
        compact = len(rings) == 1 and bool(shape(np.abs(paths.areas), np.array([length]))[0][0])
        return paths if compact or self.advance(code) == 0 else None

    def _drawn(self, code: int) -> tuple[list[list[tuple[float, float]]], float]:
        """A character's outlines in its font's units, and how many sizes a unit is."""
        if not self._opened:
            self._opened, self._glyphs = True, self._program()
        if self._glyphs is None:
            return [], 1.0
        names, glyphs, scale = self._glyphs
        pen = _Outline(glyphs)
        glyphs[names(code)].draw(pen)
        return pen.rings, scale

    def _program(self) -> Any:
        """The font's program: the function from codes to its characters' names, those characters, and the unit."""
        if "/FontFile3" in self.files and self.files["/FontFile3"].get("/Subtype") != pikepdf.Name.OpenType:
            whole = cffLib.CFFFontSet()
            whole.decompile(io.BytesIO(unpacked(self.files["/FontFile3"], PROGRAM)), None)
            top = whole[0]
            scale = float(top.FontMatrix[0]) if hasattr(top, "FontMatrix") else 0.001
            if not self.wide:
                inside = top.Encoding if isinstance(top.Encoding, list) else StandardEncoding
                return self._encoded(inside), top.CharStrings, scale
            if hasattr(top, "ROS"):
                return (lambda code: f"cid{code:05}"), top.CharStrings, scale
            return (lambda code: top.charset[code]), top.CharStrings, scale
        key = next((key for key in ("/FontFile2", "/FontFile3") if key in self.files), None)
        if key is None:
            return None
        font = TTFont(io.BytesIO(unpacked(self.files[key], PROGRAM)), lazy=True)
        scale = 1 / font["head"].unitsPerEm
        order = font.getGlyphOrder()
        if self.wide:
            table = self.inner.get("/CIDToGIDMap")
            gids = unpacked(table, PROGRAM) if isinstance(table, pikepdf.Stream) else None
            return (lambda code: order[code if gids is None else 256 * gids[2 * code] + gids[2 * code + 1]]), font.getGlyphSet(), scale
        maps = {(one.platformID, one.platEncID): one.cmap for one in font["cmap"].tables} if "cmap" in font else {}
        symbol, mac, unicode = maps.get((3, 0), {}), maps.get((1, 0), {}), maps.get((3, 1), {})

        def name(code: int) -> str:
            letter = bytes([code]).decode("cp1252", "replace")
            found = [symbol.get(code), symbol.get(0xF000 + code), unicode.get(ord(letter)), mac.get(code)]
            return str(next((one for one in found if one), order[0]))

        return name, font.getGlyphSet(), scale

    def _encoded(self, inside: list[str]) -> Any:
        """The function from codes to names, by the font's own encoding and what the file changes in it."""
        names = dict(enumerate(inside))
        encoding = self.named.get("/Encoding")
        if isinstance(encoding, pikepdf.Name) or (isinstance(encoding, pikepdf.Dictionary) and "/BaseEncoding" in encoding):
            names = {code: UV2AGL.get(ord(bytes([code]).decode("cp1252", "replace")), ".notdef") for code in range(256)}
        if isinstance(encoding, pikepdf.Dictionary):
            at = 0
            for one in encoding.get("/Differences", []):
                if isinstance(one, pikepdf.Name):
                    names[at] = text(one)[1:]
                    at += 1
                else:
                    at = int(one)
        return lambda code: names[code]

    def _widths(self) -> tuple[dict[int, float], float]:
        """How far characters go, by code, and all others."""
        try:
            if not self.wide:
                first = int(self.named.get("/FirstChar", 0))
                unit = float(self.named.FontMatrix[0]) if self.procs is not None else 0.001
                return {first + k: float(width) * unit for k, width in enumerate(self.named.get("/Widths", []))}, 0.5
            found: dict[int, float] = {}
            parts = list(self.inner.get("/W", []))
            at = 0
            while at + 1 < len(parts):
                if isinstance(parts[at + 1], pikepdf.Array):
                    found |= {int(parts[at]) + k: float(width) / 1000 for k, width in enumerate(parts[at + 1])}
                    at += 2
                else:
                    found |= dict.fromkeys(range(int(parts[at]), min(int(parts[at + 1]), 65535) + 1), float(parts[at + 2]) / 1000)
                    at += 3
            return found, float(self.inner.get("/DW", 1000)) / 1000
        except (LookupError, TypeError, ValueError, AttributeError, TooLarge):
            return {}, 0.5


def _back(ring: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """The two inner points of the straight way back to the first."""
    (a, b), (c, d) = ring[-1], ring[0]
    return [(a + (c - a) / 3, b + (d - b) / 3), (c - (c - a) / 3, d - (d - b) / 3)]
