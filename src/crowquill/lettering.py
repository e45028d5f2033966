"""Words as outlines: text becomes Paths, so that what is drawn needs no font where it is opened.

The letters are Bitstream Vera Sans, which comes with ReportLab.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from crowquill.paths import Array, Paths

ANCHORS = {"start": 0.0, "middle": 0.5, "end": 1.0}


def text(words: str, x: float, y: float, *, size: float = 3.0, anchor: str = "start") -> Paths:
    """One line of text as closed cubic Paths in mm: x is where it starts, or its middle or end, y its base line.

    size is the font's own, from which lines are set: capitals are 0.73 of it high. A letter that the font lacks
    shows as its empty box. No letters give no paths. Raises ValueError for a size that is not over 0.
    """
    if not size > 0:
        raise ValueError(f"size of text is {size} mm; it takes a length over 0")
    letters = [_letter(letter) for letter in words]
    starts = np.cumsum([0.0, *(width for _, width in letters)])
    left = x - ANCHORS[anchor] * starts[-1] * size
    rings = [ring * size + (left + start * size, y) for (outline, _), start in zip(letters, starts, strict=False) for ring in outline]
    return Paths.of(rings, cubic=True)


@cache
def _font() -> tuple[Any, Any, float]:
    import reportlab
    from fontTools.ttLib import TTFont

    font = TTFont(Path(reportlab.__file__).parent / "fonts" / "Vera.ttf")
    return font.getGlyphSet(), font.getBestCmap(), float(font["head"].unitsPerEm)


@cache
def _letter(letter: str) -> tuple[list[Array], float]:
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

    glyphs, codes, em = _font()
    glyph = glyphs[codes.get(ord(letter), ".notdef")]
    pen = Pen(glyphs)
    glyph.draw(pen)
    return [np.array(ring) / (em, -em) for ring in pen.rings if len(ring) > 2], glyph.width / em
