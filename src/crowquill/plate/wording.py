"""Captions: text with *italic* and **bold** words, set in lines of a width."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import groupby

from crowquill import lettering
from crowquill.lettering import Words
from crowquill.sheet import Ink, Layer

STARS = re.compile(r"(\*\*[^*]+\*\*|\*[^*]+\*)")
CAPITALS = 0.73  # of the font's size, in Vera; other fonts are near it
LEADING = 1.25  # from line to line, in sizes
DEPTH = 0.24  # of letters below their line, in sizes

Faces = Mapping[str, str]  # regular, italic, bold: the font of each
Piece = tuple[str, str]  # words and their face


@dataclass(frozen=True)
class Caption:
    """Lines of pieces, each with its face and how far from the left it starts, for a font's size, all in mm."""

    lines: tuple[tuple[tuple[str, str, float], ...], ...]
    size: float
    faces: Faces

    @property
    def height(self) -> float:
        """From the tops of capitals to the lowest of the letters."""
        return self.size * (CAPITALS + DEPTH + LEADING * (len(self.lines) - 1)) if self.lines else 0.0

    @property
    def width(self) -> float:
        """Of the longest of its lines."""
        return max((x + lettering.width(text, self.size, self.faces[face]) for *_, (text, face, x) in self.lines), default=0.0)

    def layers(self, left: float, top: float, name: str, ink: Ink) -> list[Layer]:
        """The lines as words from a place of the page on, a layer a face."""
        found = []
        for face in self.faces:
            at = [
                (text, left + x, top + self.size * (CAPITALS + LEADING * row))
                for row, line in enumerate(self.lines)
                for text, own, x in line
                if own == face
            ]
            if at:
                label = name if face == "regular" else f"{name} {face}"
                found.append(Layer(ink, Words.of(at, size=self.size, font=self.faces[face]), label))
        return found


def caption(text: str, width: float, size: float, faces: Faces) -> Caption:
    """The text in lines of at most this width in mm. Raises ValueError for a word that is wider."""
    lines: list[list[Piece]] = []
    for word in _words(text):
        long = _wide(word, size, faces)
        if long > width:
            raise ValueError(
                f"caption: {''.join(part for part, _ in word)!r} is {long:.3g} mm wide in a room of {width:.4g} mm; set it smaller"
            )
        if lines and _wide([*lines[-1], (" ", lines[-1][-1][1]), *word], size, faces) <= width:
            lines[-1] += [(" ", lines[-1][-1][1]), *word]
        else:
            lines.append(list(word))
    return Caption(tuple(tuple(_placed(line, size, faces)) for line in lines), size, faces)


def _words(text: str) -> list[list[Piece]]:
    """Words of pieces: of "*Hoplites*, 2" the first is two pieces, an italic name and a regular comma."""
    words: list[list[Piece]] = []
    open_word = False
    for run in STARS.split(text):
        face, said = "regular", run
        if STARS.fullmatch(run):
            face = "bold" if run.startswith("**") else "italic"
            said = run.strip("*")
        for part in re.split(r"(\s+)", said):
            if not part:
                continue
            if part.isspace():
                open_word = False
            elif open_word:
                words[-1].append((part, face))
            else:
                words.append([(part, face)])
                open_word = True
    return words


def _placed(line: list[Piece], size: float, faces: Faces) -> list[tuple[str, str, float]]:
    """Pieces of one face joined, and where they start."""
    found, x = [], 0.0
    for face, pieces in groupby(line, key=lambda piece: piece[1]):
        text = "".join(part for part, _ in pieces)
        found.append((text, face, x))
        x += lettering.width(text, size, faces[face])
    return found


def _wide(line: list[Piece], size: float, faces: Faces) -> float:
    return sum(lettering.width(part, size, faces[face]) for part, face in line)
