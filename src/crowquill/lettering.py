"""Words: lines of text at final size, as letters of a font or as outlines.

The fonts that come along are Bitstream Vera Sans in three faces, which ReportLab brings.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from crowquill.paths import Array, Paths, frozen

ANCHORS = {"start": 0.0, "middle": 0.5, "end": 1.0}
FACES = {"regular": "Vera.ttf", "bold": "VeraBd.ttf", "italic": "VeraIt.ttf"}


@dataclass(frozen=True, eq=False)
class Words:
    """Lines of text, each where it starts: text (n,), xy (n, 2) mm with y the base line, size (n,) mm, in one font.

    font  regular, bold or italic, or the path of a TrueType font of the user's own. PDF sets the text in it; other
          formats draw its outlines, so that they need no font where they are opened.
    """

    text: tuple[str, ...]
    xy: Array
    size: Array
    font: str = "regular"

    def __post_init__(self) -> None:
        object.__setattr__(self, "xy", frozen(self.xy, np.float64, (len(self.text), 2), "xy"))
        object.__setattr__(self, "size", frozen(self.size, np.float64, (len(self.text),), "size"))
        if len(self.size) and not self.size.min() > 0:
            raise ValueError(f"size of text is {self.size.min()} mm; it takes a length over 0")

    @classmethod
    def of(cls, lines: Iterable[tuple[str, float, float]], *, size: float = 3.0, anchor: str = "start", font: str = "regular") -> Words:
        """Lines (text, x, y) of one size; x is where each starts, or its middle or end."""
        parts = [(words, x - ANCHORS[anchor] * width(words, size, font), y) for words, x, y in lines]
        xy = np.array([(x, y) for _, x, y in parts], np.float64).reshape(-1, 2)
        return cls(tuple(words for words, _, _ in parts), xy, np.full(len(parts), float(size)), font)

    def __len__(self) -> int:
        return len(self.text)

    def moved(self, offset: npt.ArrayLike) -> Words:
        """All lines moved by offset (2,) mm."""
        return replace(self, xy=self.xy + np.asarray(offset, np.float64))

    def snapped(self) -> Words:
        """Places and sizes in whole micrometres."""
        return replace(self, xy=np.round(self.xy, 3), size=np.round(self.size, 3))

    def outlines(self) -> Paths:
        """The letters as closed cubic Paths. A letter that the font lacks shows as its empty box."""
        rings = [
            ring
            for words, (x, y), size in zip(self.text, self.xy.tolist(), self.size.tolist(), strict=True)
            for ring in text(words, x, y, size=size, font=self.font)
        ]
        return Paths.of(rings, cubic=True)


def width(words: str, size: float, font: str = "regular") -> float:
    """How wide a line of text is set, mm."""
    return sum(_letter(letter, font)[1] for letter in words) * size


def lacking(words: Iterable[str], font: str = "regular") -> str:
    """The letters that a font has no shape for, each once, in the order of their codes. Raises what text() raises of fonts."""
    codes = _font(font)[1]
    return "".join(sorted({letter for letter in words if ord(letter) not in codes}))


def text(words: str, x: float, y: float, *, size: float = 3.0, anchor: str = "start", font: str = "regular") -> Paths:
    """One line of text as closed cubic Paths in mm: x is where it starts, or its middle or end, y its base line.

    size is the font's own, from which lines are set: capitals of Vera are 0.73 of it high. A letter that the font lacks
    shows as its empty box. No letters give no paths. Raises ValueError for a size that is not over 0, and for a font
    that cannot be read.
    """
    if not size > 0:
        raise ValueError(f"size of text is {size} mm; it takes a length over 0")
    letters = [_letter(letter, font) for letter in words]
    starts = np.cumsum([0.0, *(width for _, width in letters)])
    left = x - ANCHORS[anchor] * starts[-1] * size
    rings = [ring * size + (left + start * size, y) for (outline, _), start in zip(letters, starts, strict=False) for ring in outline]
    return Paths.of(rings, cubic=True)


def file(font: str) -> Path:
    """The TrueType file of a face by name, or of a path. Raises ValueError where there is none."""
    import reportlab

    if font in FACES:
        return Path(reportlab.__file__).parent / "fonts" / FACES[font]
    if not Path(font).suffix:
        raise ValueError(f"no font {font!r}; there are {', '.join(FACES)}, or the path of a TrueType font")
    return Path(font)


@cache
def _font(name: str) -> tuple[Any, Any, float]:
    from fontTools.ttLib import TTFont, TTLibError

    path = file(name)
    try:
        font = TTFont(path)
        return font.getGlyphSet(), font.getBestCmap() or {}, float(font["head"].unitsPerEm)
    except (TTLibError, LookupError, ValueError, AssertionError) as error:
        raise ValueError(f"{path}: not a font that can be read ({str(error)[:80]}); give a TrueType font") from None


@cache
def _letter(letter: str, font: str) -> tuple[list[Array], float]:
    """A letter's rings of cubics, y down, and how far it moves on, for a font of size 1."""
    from fontTools.pens.basePen import BasePen

    class Pen(BasePen):  # type: ignore[misc]
        """Collects rings; quadratic curves come as cubics."""

        def __init__(self, glyphs: Any) -> None:
            super().__init__(glyphs)
            self.rings: list[list[tuple[float, float]]] = []

        def _moveTo(self, point: tuple[float, float]) -> None:
            self.rings.append([point])

        def _curveToOne(self, *points: tuple[float, float]) -> None:
            self.rings[-1] += points

        def _lineTo(self, point: tuple[float, float]) -> None:
            (x, y), (u, v) = self.rings[-1][-1], point
            self.rings[-1] += [(x + (u - x) / 3, y + (v - y) / 3), (u - (u - x) / 3, v - (v - y) / 3), point]

        def _closePath(self) -> None:
            ring = self.rings[-1]
            if ring[0] != ring[-1]:
                self._lineTo(ring[0])
            ring.pop()

    glyphs, codes, em = _font(font)
    glyph = glyphs[codes.get(ord(letter), ".notdef")]
    pen = Pen(glyphs)
    glyph.draw(pen)
    rings = [np.array(ring) / (em, -em) for ring in pen.rings if len(ring) > 2]
    areas = np.abs(Paths.of(rings, cubic=True).areas)
    return [rings[k] for k in np.argsort(-areas, kind="stable")], glyph.width / em  # holes behind their outlines
